#include "ocean/fields.h"

#include <pthread.h>
#include <stdlib.h>
#include <string.h>

#include "ocean/evolve.h"

#define N PEL_CASCADE_N

static struct pel_cascade_fields *allocate(void)
{
    struct pel_cascade_fields *f = calloc(1, sizeof *f);
    bool whole = f;
    for (int i = 0; f && i < PEL_CASCADES; i++) {
        f->displacement[i] = malloc(N * N * sizeof *f->displacement[i]);
        f->slopes[i] = malloc(N * N * sizeof *f->slopes[i]);
        f->fold[i] = malloc(N * N * sizeof *f->fold[i]);
        f->velocity[i] = malloc(N * N * sizeof *f->velocity[i]);
        whole = whole && f->displacement[i] && f->slopes[i] && f->fold[i] &&
                f->velocity[i];
    }
    if (!whole) {
        pel_cascade_fields_destroy(f);
        return NULL;
    }
    return f;
}

static void compute(const struct pel_cascades *c, double time_s,
                    struct pel_evolve_work *work, struct pel_cascade_fields *f)
{
    f->time_s = time_s;
    for (int i = 0; i < PEL_CASCADES; i++) {
        const struct pel_evolve_target to = { f->displacement[i], f->slopes[i],
                                              f->fold[i], f->velocity[i] };
        pel_evolve(c, i, time_s, work, &to);
    }
}

enum pel_err pel_cascade_fields_create(const struct pel_cascades *c,
                                       double time_s,
                                       struct pel_cascade_fields **out)
{
    struct pel_cascade_fields *f = allocate();
    struct pel_evolve_work *work = pel_evolve_work_create();
    enum pel_err err = f && work ? PEL_OK : PEL_ERR_NO_MEMORY;
    if (err) {
        pel_cascade_fields_destroy(f);
    } else {
        compute(c, time_s, work, f);
        *out = f;
    }
    pel_evolve_work_destroy(work);
    return err;
}

void pel_cascade_fields_destroy(struct pel_cascade_fields *f)
{
    for (int i = 0; f && i < PEL_CASCADES; i++) {
        free(f->displacement[i]);
        free(f->slopes[i]);
        free(f->fold[i]);
        free(f->velocity[i]);
    }
    free(f);
}

/* --- the moments kept ---------------------------------------------------- */

#define KEPT 2

/* `lock` guards the cache and is held while fields are computed, so that
 * threads asking for one moment compute it once. */
struct pel_fields_cache {
    pthread_mutex_t lock;
    struct pel_kept_fields *kept[KEPT];
    struct pel_evolve_work *work; /* NULL until a moment is asked for */
    uint64_t clock;
    struct pel_cascades *second; /* accelerations; NULL until asked for */
};

bool pel_fields_cache_init(struct pel_fields_cache **out)
{
    struct pel_fields_cache *c = calloc(1, sizeof *c);
    if (!c) {
        return false;
    }
    pthread_mutex_init(&c->lock, NULL);
    *out = c;
    return true;
}

static void drop(struct pel_kept_fields *k)
{
    if (k && k->users == 0) {
        pel_cascade_fields_destroy(k->fields);
        free(k);
    } else if (k) {
        k->stale = true;
    }
}

/* Shares all but the amplitudes with the cascades it was made of. */
static void destroy_second(struct pel_cascades *second)
{
    if (!second) {
        return;
    }
    pel_fields_cache_finish(second->cache);
    for (int i = 0; i < PEL_CASCADES; i++) {
        free(second->cascade[i].h0);
    }
    free(second);
}

static enum pel_err make_second(const struct pel_cascades *c,
                                struct pel_cascades **out)
{
    struct pel_cascades *second = malloc(sizeof *second);
    if (!second) {
        return PEL_ERR_NO_MEMORY;
    }
    *second = *c;
    bool whole = pel_fields_cache_init(&second->cache);
    second->cache = whole ? second->cache : NULL;
    for (int i = 0; i < PEL_CASCADES; i++) {
        const struct pel_cascade *from = &c->cascade[i];
        float(*h0)[4] = malloc(PEL_CASCADE_MODES * sizeof *h0);
        second->cascade[i].h0 = h0;
        whole = whole && h0;
        for (size_t m = 0; h0 && m < PEL_CASCADE_MODES; m++) {
            double omega = 2.0 * PEL_PI * (double)from->mode[m][0];
            for (int part = 0; part < 4; part++) {
                h0[m][part] =
                    (float)(-omega * omega * (double)from->h0[m][part]);
            }
        }
    }
    if (!whole) {
        destroy_second(second);
        return PEL_ERR_NO_MEMORY;
    }
    *out = second;
    return PEL_OK;
}

enum pel_err pel_fields_second(const struct pel_cascades *c,
                               const struct pel_cascades **out)
{
    struct pel_fields_cache *cache = c->cache;
    enum pel_err err = PEL_OK;
    pthread_mutex_lock(&cache->lock);
    if (!cache->second) {
        err = make_second(c, &cache->second);
    }
    *out = cache->second;
    pthread_mutex_unlock(&cache->lock);
    return err;
}

void pel_fields_cache_finish(struct pel_fields_cache *cache)
{
    if (!cache) {
        return;
    }
    for (int i = 0; i < KEPT; i++) {
        drop(cache->kept[i]);
    }
    pel_evolve_work_destroy(cache->work);
    pthread_mutex_destroy(&cache->lock);
    destroy_second(cache->second);
    free(cache);
}

static struct pel_kept_fields *find(struct pel_fields_cache *cache,
                                    double time_s)
{
    for (int i = 0; i < KEPT; i++) {
        struct pel_kept_fields *k = cache->kept[i];
        if (k && k->fields->time_s == time_s) {
            return k;
        }
    }
    return NULL;
}

/* The least used place, without users and with memory for fields: a moment is
 * 14 MiB, which goes from one to the next: freeing and allocating it anew
 * would hold several times as much in the heap of the thread that asks. */
static struct pel_kept_fields *place(struct pel_fields_cache *cache)
{
    int oldest = 0;
    for (int i = 0; i < KEPT && cache->kept[oldest]; i++) {
        if (!cache->kept[i] ||
            cache->kept[i]->used < cache->kept[oldest]->used) {
            oldest = i;
        }
    }
    struct pel_kept_fields **at = &cache->kept[oldest];
    if (*at && (*at)->users > 0) {
        drop(*at);
        *at = NULL;
    }
    if (!*at) {
        struct pel_kept_fields *k = calloc(1, sizeof *k);
        if (!k || !(k->fields = allocate())) {
            free(k);
            return NULL;
        }
        *at = k;
    }
    return *at;
}

static enum pel_err add(const struct pel_cascades *c, double time_s,
                        struct pel_kept_fields **out)
{
    struct pel_fields_cache *cache = c->cache;
    if (!cache->work) {
        cache->work = pel_evolve_work_create();
    }
    struct pel_kept_fields *k = cache->work ? place(cache) : NULL;
    if (!k) {
        return PEL_ERR_NO_MEMORY;
    }
    compute(c, time_s, cache->work, k->fields);
    *out = k;
    return PEL_OK;
}

enum pel_err pel_fields_take(const struct pel_cascades *c, double time_s,
                             struct pel_kept_fields **out)
{
    struct pel_fields_cache *cache = c->cache;
    enum pel_err err = PEL_OK;
    pthread_mutex_lock(&cache->lock);
    struct pel_kept_fields *k = find(cache, time_s);
    if (!k) {
        err = add(c, time_s, &k);
    }
    if (!err) {
        k->users++;
        k->used = ++cache->clock;
        *out = k;
    }
    pthread_mutex_unlock(&cache->lock);
    return err;
}

void pel_fields_give(const struct pel_cascades *c, struct pel_kept_fields *kept)
{
    pthread_mutex_lock(&c->cache->lock);
    kept->users--;
    if (kept->stale) {
        drop(kept);
    }
    pthread_mutex_unlock(&c->cache->lock);
}
