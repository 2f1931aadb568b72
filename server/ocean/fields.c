#include "ocean/fields.h"

#include <pthread.h>
#include <stdlib.h>
#include <string.h>

#include "ocean/fft.h"

#define N PEL_CASCADE_N

_Static_assert(N == PEL_FFT_N, "the transform is made for the cascades");

/* Two real fields ride in one complex transform. */
enum pair {
    PAIR_HEIGHT_DX,
    PAIR_DY_VZ,
    PAIR_VX_VY,
    PAIR_HX_HY,
    PAIR_XX_YY,
    PAIR_XY,
    PAIRS,
};

struct grids {
    struct pel_fft_grid g[PAIRS];
};

struct complex2 {
    double re, im;
};

/* g += f1 + i f2 */
static void put(struct pel_fft_grid *g, int j, int i, struct complex2 a,
                struct complex2 b)
{
    g->re[j][i] = (float)(a.re - b.im);
    g->im[j][i] = (float)(a.im + b.re);
}

static struct complex2 times(double s, struct complex2 z)
{
    return (struct complex2){ s * z.re, s * z.im };
}

static struct complex2 times_i(double s, struct complex2 z)
{
    return (struct complex2){ -s * z.im, s * z.re };
}

/* The eleven fields of one mode (cascade.h). */
static void put_mode(const struct pel_cascades *all,
                     const struct pel_cascade *c, int j, int i, double time_s,
                     struct grids *out)
{
    int at = j * N + i;
    const float *h0 = c->h0[at];
    double turns = c->mode[at][0] * time_s;
    double phase = 2.0 * PEL_PI * (turns - floor(turns));
    double cs = cos(phase), sn = sin(phase);
    /* h0 e^{−iφ} and h0m e^{+iφ}; their sum is h̃, iω times their difference
     * its derivative. */
    struct complex2 a = { h0[0] * cs + h0[1] * sn, h0[1] * cs - h0[0] * sn };
    struct complex2 b = { h0[2] * cs - h0[3] * sn, h0[3] * cs + h0[2] * sn };
    struct complex2 h = { a.re + b.re, a.im + b.im };
    double omega = 2.0 * PEL_PI * c->mode[at][0];
    struct complex2 v = { omega * (a.im - b.im), omega * (b.re - a.re) };

    double step = 2.0 * PEL_PI / c->length_m;
    double u = step * (i < N / 2 ? i : i - N),
           w = step * (j < N / 2 ? j : j - N);
    double kx = u * c->turn_cos - w * c->turn_sin;
    double ky = u * c->turn_sin + w * c->turn_cos;
    double k = sqrt(kx * kx + ky * ky), chop = c->mode[at][1];
    double gd = (double)all->displacement_gain[i] * all->displacement_gain[j];
    double gs = (double)all->slope_gain[i] * all->slope_gain[j];
    double dx = gd * chop * kx / k, dy = gd * chop * ky / k;
    double fold = -gs * chop / k;
    put(&out->g[PAIR_HEIGHT_DX], j, i, times(gd, h), times_i(dx, h));
    put(&out->g[PAIR_DY_VZ], j, i, times_i(dy, h), times(gd, v));
    put(&out->g[PAIR_VX_VY], j, i, times_i(dx, v), times_i(dy, v));
    put(&out->g[PAIR_HX_HY], j, i, times_i(gs * kx, h), times_i(gs * ky, h));
    put(&out->g[PAIR_XX_YY], j, i, times(fold * kx * kx, h),
        times(fold * ky * ky, h));
    put(&out->g[PAIR_XY], j, i, times(fold * kx * ky, h),
        (struct complex2){ 0, 0 });
}

static void compute(const struct pel_cascades *all, int index, double time_s,
                    struct grids *grids, struct pel_cascade_fields *out)
{
    const struct pel_cascade *c = &all->cascade[index];
    memset(grids, 0, sizeof *grids);
    for (int j = 0; j < N; j++) {
        for (int i = 0; i < N; i++) {
            if (c->mode[j * N + i][0] > 0) {
                put_mode(all, c, j, i, time_s, grids);
            }
        }
    }
    for (int p = 0; p < PAIRS; p++) {
        pel_fft_inverse(&grids->g[p], PEL_CASCADE_HIGHEST);
    }
    const struct pel_fft_grid *g = grids->g;
    for (int j = 0; j < N; j++) {
        for (int i = 0; i < N; i++) {
            int at = j * N + i;
            float *d = out->displacement[index][at];
            float *s = out->slopes[index][at];
            float *v = out->velocity[index][at];
            d[0] = g[PAIR_HEIGHT_DX].im[j][i];
            d[1] = g[PAIR_DY_VZ].re[j][i];
            d[2] = g[PAIR_HEIGHT_DX].re[j][i];
            s[0] = g[PAIR_HX_HY].re[j][i];
            s[1] = g[PAIR_HX_HY].im[j][i];
            s[2] = g[PAIR_XX_YY].re[j][i];
            s[3] = g[PAIR_XX_YY].im[j][i];
            out->fold[index][at] = g[PAIR_XY].re[j][i];
            v[0] = g[PAIR_VX_VY].re[j][i];
            v[1] = g[PAIR_VX_VY].im[j][i];
            v[2] = g[PAIR_DY_VZ].im[j][i];
            d[3] = v[3] = 0;
        }
    }
}

enum pel_err pel_cascade_fields_create(const struct pel_cascades *c,
                                       double time_s,
                                       struct pel_cascade_fields **out)
{
    struct pel_cascade_fields *f = calloc(1, sizeof *f);
    struct grids *grids = aligned_alloc(64, sizeof *grids);
    bool whole = f && grids;
    for (int i = 0; f && i < PEL_CASCADES; i++) {
        f->displacement[i] = malloc(N * N * sizeof *f->displacement[i]);
        f->slopes[i] = malloc(N * N * sizeof *f->slopes[i]);
        f->fold[i] = malloc(N * N * sizeof *f->fold[i]);
        f->velocity[i] = malloc(N * N * sizeof *f->velocity[i]);
        whole = whole && f->displacement[i] && f->slopes[i] && f->fold[i] &&
                f->velocity[i];
    }
    if (!whole) {
        free(grids);
        pel_cascade_fields_destroy(f);
        return PEL_ERR_NO_MEMORY;
    }
    f->time_s = time_s;
    for (int i = 0; i < PEL_CASCADES; i++) {
        compute(c, i, time_s, grids, f);
    }
    free(grids);
    *out = f;
    return PEL_OK;
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

/* --- the moments kept
 * --------------------------------------------------------- */

#define KEPT 2

/* `lock` guards the cache and is held while fields are computed, so that
 * threads asking for one moment compute it once. */
struct pel_fields_cache {
    pthread_mutex_t lock;
    struct pel_kept_fields *kept[KEPT];
    uint64_t clock;
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

void pel_fields_cache_finish(struct pel_fields_cache *cache)
{
    if (!cache) {
        return;
    }
    for (int i = 0; i < KEPT; i++) {
        drop(cache->kept[i]);
    }
    pthread_mutex_destroy(&cache->lock);
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

/* Puts new fields in place of those used longest ago. */
static enum pel_err add(const struct pel_cascades *c, double time_s,
                        struct pel_kept_fields **out)
{
    struct pel_fields_cache *cache = c->cache;
    struct pel_kept_fields *k = calloc(1, sizeof *k);
    if (!k || pel_cascade_fields_create(c, time_s, &k->fields)) {
        free(k);
        return PEL_ERR_NO_MEMORY;
    }
    int oldest = 0;
    for (int i = 0; i < KEPT; i++) {
        if (!cache->kept[i]) {
            oldest = i;
            break;
        }
        if (cache->kept[i]->used < cache->kept[oldest]->used) {
            oldest = i;
        }
    }
    drop(cache->kept[oldest]);
    cache->kept[oldest] = k;
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
