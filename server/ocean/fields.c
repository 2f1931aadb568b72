#include "ocean/fields.h"

#include <pthread.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/lock.h"
#include "ocean/evolve.h"
#include "ocean/foam.h"

#define N PEL_CASCADE_N

/* --- the fields of one moment --------------------------------------------- */

/* Writes nothing where there is room: others may be filling it. */
static bool need(void *array, size_t texel)
{
    void **at = array;
    if (!*at) {
        *at = malloc(N * N * texel);
    }
    return *at != NULL;
}

/* Room for all down to `depth`. */
static bool make_room(struct pel_cascade_fields *f, enum pel_fields_depth depth)
{
    bool whole = true;
    for (int i = 0; depth == PEL_FIELDS_BREAKING && i < PEL_FOAM_CASCADES;
         i++) {
        whole = whole && need(&f->breaking[i], sizeof(float[2]));
    }
    for (int i = 0; depth != PEL_FIELDS_BREAKING && i < PEL_CASCADES; i++) {
        whole = whole && need(&f->displacement[i], sizeof(float[4])) &&
                need(&f->slopes[i], sizeof(float[4])) &&
                need(&f->fold[i], sizeof(float));
        if (depth >= PEL_FIELDS_VELOCITY) {
            whole = whole && need(&f->velocity[i], sizeof(float[4]));
        }
        if (depth >= PEL_FIELDS_SURGE) {
            whole = whole && need(&f->surge[i], sizeof(float[2]));
        }
    }
    return whole;
}

static void drop_room(struct pel_cascade_fields *f)
{
    for (int i = 0; i < PEL_CASCADES; i++) {
        free(f->displacement[i]);
        free(f->slopes[i]);
        free(f->fold[i]);
        free(f->velocity[i]);
        free(f->surge[i]);
        free(f->breaking[i]);
    }
}

/* Fields of cascade i below depth `from`, down to `to`. */
static void fill(const struct pel_cascades *c, int i,
                 struct pel_evolve_work *work, enum pel_fields_depth from,
                 enum pel_fields_depth to, const struct pel_cascade_fields *f)
{
    struct pel_evolve_target target = { 0 };
    if (to == PEL_FIELDS_BREAKING) {
        target.breaking = f->breaking[i];
        pel_evolve(c, i, f->time_s, work, &target);
        return;
    }
    if (from < PEL_FIELDS_REST) {
        target.displacement = f->displacement[i];
        target.slopes = f->slopes[i];
        target.fold = f->fold[i];
    }
    if (from < PEL_FIELDS_VELOCITY && to >= PEL_FIELDS_VELOCITY) {
        target.velocity = f->velocity[i];
    }
    if (to >= PEL_FIELDS_SURGE) {
        target.surge = f->surge[i];
    }
    pel_evolve(c, i, f->time_s, work, &target);
}

enum pel_err pel_cascade_fields_create(const struct pel_cascades *c,
                                       double time_s,
                                       struct pel_cascade_fields **out)
{
    struct pel_cascade_fields *f = calloc(1, sizeof *f);
    struct pel_evolve_work *work = pel_evolve_work_create();
    if (!f || !work || !make_room(f, PEL_FIELDS_SURGE)) {
        pel_evolve_work_destroy(work);
        pel_cascade_fields_destroy(f);
        return PEL_ERR_NO_MEMORY;
    }
    f->time_s = time_s;
    for (int i = 0; i < PEL_CASCADES; i++) {
        fill(c, i, work, PEL_FIELDS_NONE, PEL_FIELDS_SURGE, f);
    }
    pel_evolve_work_destroy(work);
    *out = f;
    return PEL_OK;
}

void pel_cascade_fields_destroy(struct pel_cascade_fields *f)
{
    if (f) {
        drop_room(f);
        free(f);
    }
}

/* --- the moments kept ------------------------------------------------------
 */

#define KEPT 3 /* besides what is held */
#define SLOTS (KEPT + PEL_SEA_HELD)
#define MOST_WORKS 4 /* scratches kept */

/* How deep each cascade's fields are being computed and are computed. */
struct progress {
    enum pel_fields_depth begun[PEL_CASCADES], done[PEL_CASCADES];
};

struct pel_kept_fields {
    struct pel_cascade_fields fields;
    struct progress waves, breaking; /* the latter by itself */
    unsigned users;
    bool stale; /* out of the cache: its last user frees it */
    uint64_t used;
    int64_t used_ns;
};

struct pel_fields_cache {
    pthread_mutex_t lock; /* guards all, but not the texels being computed */
    pthread_cond_t changed;
    struct pel_kept_fields *kept[SLOTS];
    int held_count;
    double held[PEL_SEA_HELD]; /* moments */
    uint64_t clock;
    struct pel_evolve_work *works[MOST_WORKS]; /* idle ones */
    int64_t worked_ns;
    struct pel_fields_cache *before, *after; /* of all that there are */
};

/* All caches there are; a cache's own lock is taken after this one. */
static pthread_mutex_t all_lock = PTHREAD_MUTEX_INITIALIZER;
static struct pel_fields_cache *all;

bool pel_fields_cache_init(struct pel_fields_cache **out)
{
    struct pel_fields_cache *c = calloc(1, sizeof *c);
    if (!c) {
        return false;
    }
    pel_lock_init(&c->lock);
    pthread_cond_init(&c->changed, NULL);
    pthread_mutex_lock(&all_lock);
    c->after = all;
    if (all) {
        all->before = c;
    }
    all = c;
    pthread_mutex_unlock(&all_lock);
    *out = c;
    return true;
}

static void drop(struct pel_kept_fields *k)
{
    if (k && k->users == 0) {
        drop_room(&k->fields);
        free(k);
    } else if (k) {
        k->stale = true;
    }
}

void pel_fields_cache_finish(struct pel_fields_cache *cache)
{
    if (!cache) {
        return;
    }
    pthread_mutex_lock(&all_lock);
    *(cache->before ? &cache->before->after : &all) = cache->after;
    if (cache->after) {
        cache->after->before = cache->before;
    }
    pthread_mutex_unlock(&all_lock);
    for (int i = 0; i < SLOTS; i++) {
        drop(cache->kept[i]);
    }
    for (int i = 0; i < MOST_WORKS; i++) {
        pel_evolve_work_destroy(cache->works[i]);
    }
    pthread_mutex_destroy(&cache->lock);
    pthread_cond_destroy(&cache->changed);
    free(cache);
}

/* --- under the lock --- */

static struct pel_kept_fields *find(struct pel_fields_cache *cache,
                                    double time_s)
{
    for (int i = 0; i < SLOTS; i++) {
        struct pel_kept_fields *k = cache->kept[i];
        if (k && k->fields.time_s == time_s) {
            return k;
        }
    }
    return NULL;
}

static bool is_among(const double *times, int count, double time_s)
{
    for (int i = 0; i < count; i++) {
        if (times[i] == time_s) {
            return true;
        }
    }
    return false;
}

static bool is_held(const struct pel_fields_cache *cache, double time_s)
{
    return is_among(cache->held, cache->held_count, time_s);
}

/* The place for another moment: an empty one while there are few others, else
 * that used longest ago, of those that are not held. */
static int place_for(const struct pel_fields_cache *cache, double time_s)
{
    int empty = -1, oldest = -1, others = 0;
    for (int i = 0; i < SLOTS; i++) {
        const struct pel_kept_fields *k = cache->kept[i];
        if (!k) {
            empty = i;
        } else if (!is_held(cache, k->fields.time_s)) {
            others++;
            oldest =
                oldest < 0 || k->used < cache->kept[oldest]->used ? i : oldest;
        }
    }
    bool room = empty >= 0 && (others < KEPT || is_held(cache, time_s));
    return room ? empty : oldest;
}

static void begin_moment(struct pel_kept_fields *k, double time_s)
{
    k->waves = k->breaking = (struct progress){ 0 };
    k->fields.time_s = time_s;
}

static struct pel_kept_fields *add(struct pel_fields_cache *cache,
                                   double time_s)
{
    int place = place_for(cache, time_s);
    struct pel_kept_fields *k = cache->kept[place];
    if (!k || k->users > 0) {
        drop(k);
        k = calloc(1, sizeof *k);
        cache->kept[place] = k;
    }
    if (k) {
        begin_moment(k, time_s);
    }
    return k;
}

static struct pel_kept_fields *open_moment(struct pel_fields_cache *cache,
                                           double time_s,
                                           enum pel_fields_depth depth)
{
    struct pel_kept_fields *k = find(cache, time_s);
    k = k ? k : add(cache, time_s);
    if (!k || !make_room(&k->fields, depth)) {
        return NULL;
    }
    k->users++;
    k->used = ++cache->clock;
    k->used_ns = pel_now_ns();
    return k;
}

static void close_moment(struct pel_kept_fields *k)
{
    k->users--;
    if (k->stale) {
        drop(k);
    }
}

static struct pel_evolve_work *take_work(struct pel_fields_cache *cache)
{
    for (int i = 0; i < MOST_WORKS; i++) {
        struct pel_evolve_work *work = cache->works[i];
        if (work) {
            cache->works[i] = NULL;
            return work;
        }
    }
    return pel_evolve_work_create();
}

static void give_work(struct pel_fields_cache *cache,
                      struct pel_evolve_work *work)
{
    cache->worked_ns = pel_now_ns();
    for (int i = 0; i < MOST_WORKS; i++) {
        if (!cache->works[i]) {
            cache->works[i] = work;
            return;
        }
    }
    pel_evolve_work_destroy(work);
}

static void forget(struct pel_fields_cache *cache, int64_t before_ns)
{
    struct pel_kept_fields *kept[SLOTS] = { NULL };
    struct pel_evolve_work *works[MOST_WORKS] = { NULL };
    pthread_mutex_lock(&cache->lock);
    for (int i = 0; i < SLOTS; i++) {
        struct pel_kept_fields *k = cache->kept[i];
        if (k && k->users == 0 && k->used_ns <= before_ns) {
            kept[i] = k;
            cache->kept[i] = NULL;
        }
    }
    if (cache->worked_ns <= before_ns) {
        memcpy(works, cache->works, sizeof works);
        memset(cache->works, 0, sizeof works);
    }
    pthread_mutex_unlock(&cache->lock);
    for (int i = 0; i < SLOTS; i++) {
        drop(kept[i]);
    }
    for (int i = 0; i < MOST_WORKS; i++) {
        pel_evolve_work_destroy(works[i]);
    }
}

static struct progress *progress_of(struct pel_kept_fields *k,
                                    enum pel_fields_depth depth)
{
    return depth == PEL_FIELDS_BREAKING ? &k->breaking : &k->waves;
}

static int cascades_of(enum pel_fields_depth depth)
{
    return depth == PEL_FIELDS_BREAKING ? PEL_FOAM_CASCADES : PEL_CASCADES;
}

/* A cascade that no thread has begun to this depth; −1: none. */
static int next_cascade(struct pel_kept_fields *k, enum pel_fields_depth depth)
{
    const struct progress *at = progress_of(k, depth);
    for (int i = 0; i < cascades_of(depth); i++) {
        /* a thread that computes it to less depth must have finished */
        if (at->begun[i] < depth && at->begun[i] == at->done[i]) {
            return i;
        }
    }
    return -1;
}

static bool is_whole(struct pel_kept_fields *k, enum pel_fields_depth depth)
{
    const struct progress *at = progress_of(k, depth);
    for (int i = 0; i < cascades_of(depth); i++) {
        if (at->done[i] < depth) {
            return false;
        }
    }
    return true;
}

/* Computes cascade i, without the lock meanwhile. */
static void compute(const struct pel_cascades *c, struct pel_kept_fields *k,
                    int i, enum pel_fields_depth depth,
                    struct pel_evolve_work *work)
{
    struct pel_fields_cache *cache = c->cache;
    struct progress *at = progress_of(k, depth);
    enum pel_fields_depth from = at->begun[i];
    at->begun[i] = depth;
    pthread_mutex_unlock(&cache->lock);
    fill(c, i, work, from, depth, &k->fields);
    pthread_mutex_lock(&cache->lock);
    at->done[i] = depth;
    pthread_cond_broadcast(&cache->changed);
}

/* --- for all ----------------------------------------------------------------
 */

enum pel_err pel_fields_take(const struct pel_cascades *c, double time_s,
                             enum pel_fields_depth depth,
                             struct pel_kept_fields **out)
{
    struct pel_fields_cache *cache = c->cache;
    struct pel_evolve_work *work = NULL;
    enum pel_err err = PEL_OK;
    pthread_mutex_lock(&cache->lock);
    struct pel_kept_fields *k = open_moment(cache, time_s, depth);
    if (!k) {
        err = PEL_ERR_NO_MEMORY;
    }
    while (!err && !is_whole(k, depth)) {
        int i = next_cascade(k, depth);
        if (i < 0) {
            pthread_cond_wait(&cache->changed, &cache->lock);
            continue;
        }
        work = work ? work : take_work(cache);
        if (!work) {
            close_moment(k);
            err = PEL_ERR_NO_MEMORY;
            break;
        }
        compute(c, k, i, depth, work);
    }
    if (work) {
        give_work(cache, work);
    }
    pthread_mutex_unlock(&cache->lock);
    *out = err ? NULL : k;
    return err;
}

const struct pel_cascade_fields *
pel_fields_of(const struct pel_kept_fields *kept)
{
    return &kept->fields;
}

void pel_fields_give(const struct pel_cascades *c, struct pel_kept_fields *kept)
{
    pthread_mutex_lock(&c->cache->lock);
    close_moment(kept);
    pthread_mutex_unlock(&c->cache->lock);
}

bool pel_fields_prepare(const struct pel_cascades *c, double time_s,
                        enum pel_fields_depth depth, bool (*go_on)(void *user),
                        void *user)
{
    struct pel_fields_cache *cache = c->cache;
    bool whole = false;
    pthread_mutex_lock(&cache->lock);
    struct pel_kept_fields *k = open_moment(cache, time_s, depth);
    struct pel_evolve_work *work = k ? take_work(cache) : NULL;
    while (work && go_on(user)) {
        int i = next_cascade(k, depth);
        if (i < 0) {
            break;
        }
        compute(c, k, i, depth, work);
    }
    if (work) {
        give_work(cache, work);
    }
    if (k) {
        whole = is_whole(k, depth);
        close_moment(k);
    }
    pthread_mutex_unlock(&cache->lock);
    return whole;
}

void pel_fields_hold(const struct pel_cascades *c, const double *times_s,
                     int count)
{
    struct pel_fields_cache *cache = c->cache;
    pthread_mutex_lock(&cache->lock);
    for (int i = 0, from = 0; i < count; i++) {
        bool there = find(cache, times_s[i]) != NULL;
        /* What is not held any more gives its memory to what is. */
        for (; !there && from < SLOTS; from++) {
            struct pel_kept_fields *k = cache->kept[from];
            if (k && k->users == 0 && is_held(cache, k->fields.time_s) &&
                !is_among(times_s, count, k->fields.time_s)) {
                begin_moment(k, times_s[i]);
                k->used = ++cache->clock;
                k->used_ns = pel_now_ns();
                from++;
                break;
            }
        }
    }
    cache->held_count = count;
    memcpy(cache->held, times_s, (size_t)count * sizeof *times_s);
    pthread_mutex_unlock(&cache->lock);
}

void pel_fields_forget(int64_t before_ns)
{
    pthread_mutex_lock(&all_lock);
    for (struct pel_fields_cache *cache = all; cache; cache = cache->after) {
        forget(cache, before_ns);
    }
    pthread_mutex_unlock(&all_lock);
}
