/* What malloc holds and nobody uses goes back to the system. */
#pragma once

/* Part of something large whose memory nobody uses any more. */
struct pel_discard {
    struct pel_discard *next;
    void (*drop)(struct pel_discard *self); /* any thread */
};

/* Before the first thread: blocks of pictures and seas go back as they are
 * freed. By itself glibc soon takes such blocks from the heaps of threads,
 * where smaller ones above keep them: half of what was resident after a while.
 * What lies on top of a heap is not given back and asked for again with each
 * picture, but by the thread below. */
void pel_heap_settle(void);

/* A thread that gives back free pages every PEL_HEAP_PAUSE_S, in real time
 * where the system permits it (base/urgent.h), since no thread that waits for
 * its heap may wait for a core as well: 0.2 to 1.2 ms each time of a daemon of
 * 300 MB. Without memory for it there is none. Main thread. */
#define PEL_HEAP_PAUSE_S 10
void pel_heap_begin(void);
void pel_heap_end(void); /* all that waits is dropped */

/* That thread drops it: unmapping 100 MB takes milliseconds, which the control
 * thread has not. At once where there is no such thread. Any thread. */
void pel_heap_discard(struct pel_discard *what);
