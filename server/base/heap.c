#include "base/heap.h"

#include <errno.h>
#include <malloc.h>
#include <pthread.h>
#include <stdbool.h>
#include <time.h>

#include "base/urgent.h"

static struct {
    pthread_mutex_t lock; /* protects ending */
    pthread_cond_t changed;
    pthread_t thread;
    bool running, ending;
} heap = { .lock = PTHREAD_MUTEX_INITIALIZER };

void pel_heap_settle(void)
{
    mallopt(M_MMAP_THRESHOLD, 256 << 10);
    mallopt(M_TRIM_THRESHOLD, 8 << 20);
}

static bool pause_ends(void)
{
    struct timespec end;
    clock_gettime(CLOCK_MONOTONIC, &end);
    end.tv_sec += PEL_HEAP_PAUSE_S;
    pthread_mutex_lock(&heap.lock);
    int told = 0;
    while (!heap.ending && told != ETIMEDOUT) {
        told = pthread_cond_timedwait(&heap.changed, &heap.lock, &end);
    }
    bool go_on = !heap.ending;
    pthread_mutex_unlock(&heap.lock);
    return go_on;
}

static void *run(void *unused)
{
    struct pel_urgent urgent = { 0 };
    pel_urgent_begin(&urgent, PEL_URGENT_ANSWERS);
    while (pause_ends()) {
        malloc_trim(0);
        pel_urgent_account(&urgent);
    }
    return unused;
}

void pel_heap_begin(void)
{
    pthread_condattr_t monotonic;
    pthread_condattr_init(&monotonic);
    pthread_condattr_setclock(&monotonic, CLOCK_MONOTONIC);
    pthread_cond_init(&heap.changed, &monotonic);
    pthread_condattr_destroy(&monotonic);
    heap.ending = false;
    heap.running = pthread_create(&heap.thread, NULL, run, NULL) == 0;
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
