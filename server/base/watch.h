/* What keeps the control thread busy for longer than a millisecond: counted by
 * what it was, told in the log (CTL-001, seldom: struct pel_watch_told) and in
 * the metrics. Counted twice: by the clock, in which the thread may also have
 * waited for a processor, and by the processor time of the thread itself, which
 * is the same on a busy machine. Costs two readings of both clocks, half a
 * microsecond, for each thing that the loop dispatches. Other threads, and
 * programs that never begin, pay a load. */
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "base/metrics.h"

#define PEL_WATCH_LIMIT_NS 1000000
#define PEL_WATCH_NAMES 40

/* This thread is the one to be watched, from now until the end. */
void pel_watch_begin(void);
void pel_watch_end(void);

/* The loop goes to sleep; it wakes. What it did between the two beside what is
 * named is called "other". */
void pel_watch_sleep(void);
void pel_watch_wake(void);

/* Names what the rest of the block does; blocks may be within others. A stall
 * of the outermost is counted for the one that took most of it by itself.
 * `what`: static, [a-z ]+. */
struct pel_watch_scope {
    int before;
};
struct pel_watch_scope pel_watch_enter(const char *what);
void pel_watch_leave(const struct pel_watch_scope *scope);
#define PEL_WATCH(what)                                                        \
    const struct pel_watch_scope pel_watch_scope                               \
        __attribute__((cleanup(pel_watch_leave), unused)) =                    \
            pel_watch_enter(what)

/* How often `what` was done by the watched thread, how often it was a stall,
 * and how often it took the processor for longer than that. */
uint64_t pel_watch_count(const char *what);
uint64_t pel_watch_stalls(const char *what);
uint64_t pel_watch_busy(const char *what);

/* Processor time of the dispatch at hand [ns]; 0 outside of one. For handlers
 * that end their turn in time. */
int64_t pel_watch_spent_ns(void);

/* When a name was told of in the log, and how long it is not again: a minute,
 * then twice as long each time, an hour at most. Zero at first. */
struct pel_watch_told {
    int64_t at_ns, rest_ns;
};
/* Whether it is told of now. took_ns: how long everything else waited; cpu_ns:
 * what the thread computed meanwhile. One that did not compute had to wait for
 * the processor, which a busy machine does to everybody: that is told where it
 * took 50 ms. */
bool pel_watch_tells(struct pel_watch_told *told, int64_t took_ns,
                     int64_t cpu_ns, int64_t now_ns);

/* pelagos_control_*; `user` is not used. */
void pel_watch_collect(void *user, struct pel_metrics_page *page);
