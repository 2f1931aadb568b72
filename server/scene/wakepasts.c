#include "scene/wakepasts.h"

#include <pthread.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <unistd.h>

#include "base/lock.h"
#include "base/reserve.h"
#include "scene/wakes.h"

/* Of each ship the one in use and the next, and one more. */
#define KEPT (2 * PEL_WAKES + 1)

struct pel_wake_kept {
    struct pel_wake_track track; /* up to its epoch */
    double epoch_s, depth_m;
    unsigned users; /* and the list */
    uint64_t used;
    pthread_mutex_t making;
    struct pel_wake_past *past;
    size_t bytes; /* of it */
};

static pthread_once_t once = PTHREAD_ONCE_INIT;
static pthread_mutex_t lock; /* guards all below and what users, used are */
static pthread_cond_t settled = PTHREAD_COND_INITIALIZER;
static struct pel_wake_kept *kept[KEPT];
static uint64_t uses;
static unsigned long awaited, made_ahead;
static struct pel_wake_kept *soon[KEPT]; /* first come, first made */
static int soon_count;
static bool making_ahead;

static void begin(void)
{
    pel_lock_init(&lock);
}

static void enter(void)
{
    pthread_once(&once, begin);
    pthread_mutex_lock(&lock);
}

static void put(struct pel_wake_kept *k) /* has the lock */
{
    if (k && --k->users == 0) {
        pel_wake_past_destroy(k->past);
        pthread_mutex_destroy(&k->making);
        free(k);
    }
}

static bool is_of(const struct pel_wake_kept *k,
                  const struct pel_wake_track *track, double epoch_s,
                  double depth_m)
{
    return k->epoch_s == epoch_s && k->depth_m == depth_m &&
           memcmp(&k->track, track, sizeof *track) == 0;
}

/* One more user's, in the place of the one that was used longest ago. */
static struct pel_wake_kept *find(const struct pel_wake_track *track,
                                  double epoch_s, double depth_m, bool *fresh)
{
    int oldest = 0;
    struct pel_wake_kept *k = NULL;
    for (int i = 0; i < KEPT && !k; i++) {
        k = kept[i] && is_of(kept[i], track, epoch_s, depth_m) ? kept[i] : NULL;
        if (kept[oldest] && (!kept[i] || kept[i]->used < kept[oldest]->used)) {
            oldest = i;
        }
    }
    *fresh = !k;
    if (!k) {
        k = pel_sure_calloc(1, sizeof *k);
        k->track = *track;
        k->epoch_s = epoch_s;
        k->depth_m = depth_m;
        k->users = 1;
        pel_lock_init(&k->making);
        put(kept[oldest]);
        kept[oldest] = k;
    }
    k->used = ++uses;
    k->users++;
    return k;
}

/* Makes it, or waits until it is made. */
static void make(struct pel_wake_kept *k, unsigned long *count)
{
    pthread_mutex_lock(&k->making);
    bool fresh = !k->past;
    if (fresh &&
        pel_wake_past_create(&k->track, k->epoch_s, k->depth_m, &k->past) &&
        (!pel_reserve_spend() ||
         pel_wake_past_create(&k->track, k->epoch_s, k->depth_m, &k->past))) {
        abort();
    }
    pthread_mutex_unlock(&k->making);
    if (fresh) {
        enter();
        k->bytes = pel_wake_past_bytes(k->past);
        ++*count;
        pthread_mutex_unlock(&lock);
    }
}

struct pel_wake_kept *pel_wake_kept_take(const struct pel_wake_track *track,
                                         double epoch_s, double depth_m)
{
    bool fresh;
    enter();
    struct pel_wake_kept *k = find(track, epoch_s, depth_m, &fresh);
    pthread_mutex_unlock(&lock);
    make(k, &awaited);
    return k;
}

void pel_wake_kept_put(struct pel_wake_kept *k)
{
    enter();
    put(k);
    pthread_mutex_unlock(&lock);
}

const struct pel_wake_past *pel_wake_kept_past(const struct pel_wake_kept *k)
{
    return k->past;
}

/* --- ahead ---------------------------------------------------------------- */

/* Ends when nothing is left to make. */
static void *make_ahead(void *argument)
{
    (void)argument;
    /* It may come from one that draws, which would starve it. */
    (void)setpriority(PRIO_PROCESS, (id_t)gettid(), 0);
    enter();
    while (soon_count > 0) {
        struct pel_wake_kept *k = soon[0];
        memmove(soon, soon + 1, (size_t)--soon_count * sizeof(void *));
        pthread_mutex_unlock(&lock);
        make(k, &made_ahead);
        enter();
        put(k);
    }
    making_ahead = false;
    pthread_cond_broadcast(&settled);
    pthread_mutex_unlock(&lock);
    return NULL;
}

static bool start(void)
{
    pthread_t thread;
    pthread_attr_t detached;
    pthread_attr_init(&detached);
    pthread_attr_setdetachstate(&detached, PTHREAD_CREATE_DETACHED);
    bool started = pthread_create(&thread, &detached, make_ahead, NULL) == 0;
    pthread_attr_destroy(&detached);
    if (started) {
        pthread_setname_np(thread, "wakes ahead");
    }
    return started;
}

void pel_wake_kept_soon(const struct pel_wake_track *track, double epoch_s,
                        double depth_m)
{
    bool fresh;
    enter();
    struct pel_wake_kept *k = find(track, epoch_s, depth_m, &fresh);
    if (fresh && soon_count < KEPT) {
        soon[soon_count++] = k;
        making_ahead = making_ahead || start();
    } else {
        put(k);
    }
    pthread_mutex_unlock(&lock);
}

void pel_wake_kept_settle(void)
{
    enter();
    while (making_ahead) {
        pthread_cond_wait(&settled, &lock);
    }
    pthread_mutex_unlock(&lock);
}

void pel_wake_kept_counts(unsigned long *waited_for, unsigned long *ahead)
{
    enter();
    *waited_for = awaited;
    *ahead = made_ahead;
    pthread_mutex_unlock(&lock);
}

size_t pel_wake_kept_bytes(void)
{
    size_t sum = 0;
    enter();
    for (int i = 0; i < KEPT; i++) {
        sum += kept[i] ? kept[i]->bytes : 0;
    }
    pthread_mutex_unlock(&lock);
    return sum;
}
