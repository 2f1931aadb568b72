#include "base/heap.h"

#include <errno.h>
#include <malloc.h>
#include <pthread.h>
#include <stdbool.h>
#include <time.h>

#include "base/urgent.h"

static struct {
    pthread_mutex_t lock; /* protects what follows */
    pthread_cond_t changed;
    pthread_t thread;
    bool running, ending;
    struct pel_discard *discarded;
} heap = { .lock = PTHREAD_MUTEX_INITIALIZER };

void pel_heap_settle(void)
{
    mallopt(M_MMAP_THRESHOLD, 256 << 10);
    mallopt(M_TRIM_THRESHOLD, 8 << 20);
}

static void drop_all(struct pel_discard *first)
{
    while (first) {
        struct pel_discard *next = first->next;
        first->drop(first);
        first = next;
    }
}

/* Waits until `end` or for what is discarded, which it drops; false: the end.
 */
static bool wait_until(const struct timespec *end, bool *passed)
{
    pthread_mutex_lock(&heap.lock);
    int told = 0;
    while (!heap.ending && !heap.discarded && told != ETIMEDOUT) {
        told = pthread_cond_timedwait(&heap.changed, &heap.lock, end);
    }
    struct pel_discard *discarded = heap.discarded;
    heap.discarded = NULL;
    bool go_on = !heap.ending;
    pthread_mutex_unlock(&heap.lock);
    drop_all(discarded);
    *passed = told == ETIMEDOUT;
    return go_on;
}

static struct timespec pause_end(void)
{
    struct timespec end;
    clock_gettime(CLOCK_MONOTONIC, &end);
    end.tv_sec += PEL_HEAP_PAUSE_S;
    return end;
}

static void *run(void *unused)
{
    struct pel_urgent urgent = { 0 };
    struct timespec end = pause_end();
    bool passed;
    pel_urgent_begin(&urgent, PEL_URGENT_ANSWERS);
    while (wait_until(&end, &passed)) {
        if (passed) {
            malloc_trim(0);
            end = pause_end();
        }
        pel_urgent_account(&urgent);
    }
    return unused;
}

void pel_heap_discard(struct pel_discard *what)
{
    pthread_mutex_lock(&heap.lock);
    bool later = heap.running && !heap.ending;
    if (later) {
        what->next = heap.discarded;
        heap.discarded = what;
        pthread_cond_signal(&heap.changed);
    }
    pthread_mutex_unlock(&heap.lock);
    if (!later) {
        what->drop(what);
    }
}

void pel_heap_begin(void)
{
    pthread_condattr_t monotonic;
    pthread_condattr_init(&monotonic);
    pthread_condattr_setclock(&monotonic, CLOCK_MONOTONIC);
    pthread_cond_init(&heap.changed, &monotonic);
    pthread_condattr_destroy(&monotonic);
    pthread_mutex_lock(&heap.lock);
    heap.ending = false;
    heap.running = pthread_create(&heap.thread, NULL, run, NULL) == 0;
    pthread_mutex_unlock(&heap.lock);
    if (heap.running) {
        pthread_setname_np(heap.thread, "heap");
    }
}

void pel_heap_end(void)
{
    if (!heap.running) {
        return;
    }
    pthread_mutex_lock(&heap.lock);
    heap.ending = true;
    pthread_cond_signal(&heap.changed);
    pthread_mutex_unlock(&heap.lock);
    pthread_join(heap.thread, NULL);
    pthread_cond_destroy(&heap.changed);
    heap.running = false;
}
