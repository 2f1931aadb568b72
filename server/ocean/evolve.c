#include "ocean/evolve.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "base/simd.h"
#include "ocean/fft.h"
#include "ocean/lanes.h"

#define N PEL_CASCADE_N
#define LANES PEL_FFT_LANES
#define HIGHEST PEL_CASCADE_HIGHEST

_Static_assert(N == PEL_FFT_N, "the transform is made for the cascades");

typedef pel_lanes lanes;
typedef pel_ints ints;
typedef float texel __attribute__((vector_size(16)));

/* Two real fields ride in one complex transform, f + i g. */
enum pair {
    PAIR_SHIFT,    /* Dx, Dy */
    PAIR_HEIGHT,   /* h, ∂Dx/∂y */
    PAIR_SLOPE,    /* ∂h/∂x, ∂h/∂y */
    PAIR_FOLD,     /* ∂Dx/∂x, ∂Dy/∂y */
    PAIR_DRIFT,    /* ∂Dx/∂t, ∂Dy/∂t */
    PAIR_HEAVE,    /* ∂h/∂t, ∂²h/∂t² */
    PAIR_SURGE,    /* ∂²Dx/∂t², ∂²Dy/∂t² */
    PAIR_BREAKING, /* X, Y of foam.h */
    PAIRS,
};

struct range { /* of pairs */
    int first, end;
};

struct pel_evolve_work {
    struct pel_fft_strip strip[PAIRS]; /* LANES rows */
    /* After the transform along the rows: blocks of LANES columns, so that the
     * transform down the columns is done in place. */
    struct pel_fft_strip block[PAIRS][N / LANES];
};

struct pel_evolve_work *pel_evolve_work_create(void)
{
    return aligned_alloc(64, sizeof(struct pel_evolve_work));
}

void pel_evolve_work_destroy(struct pel_evolve_work *work)
{
    free(work);
}

/* --- modes as they are read -------------------------------------------------
 */

/* Column i of rows j … j + LANES − 1, side by side: amplitudes at k and −k,
 * turns a second, and the displacement's direction, chop k/|k|. */
struct bunch {
    lanes h0r, h0i, mr, mi, frequency, ux, uy;
};

/* A strip of rows has modes in columns 0 … reach and N − reach … N − 1. */
struct strip {
    bool any;
    int reach;
    size_t first; /* its bunches, in that order */
};

struct pel_evolve_modes {
    struct strip strip[N / LANES];
    struct bunch bunch[];
};

/* Modes lie within PEL_CASCADE_HIGHEST of the middle, single waves half a mode
 * farther. */
static struct strip strip_of(int j, size_t first)
{
    int least = N;
    for (int l = 0; l < LANES; l++) {
        int n = j + l < N / 2 ? j + l : N - j - l;
        least = n < least ? n : least;
    }
    struct strip s = { .any = least <= HIGHEST, .first = first };
    while (s.any && s.reach < HIGHEST &&
           s.reach * s.reach + least * least < (HIGHEST + 1) * (HIGHEST + 1)) {
        s.reach++;
    }
    return s;
}

static int columns_of(const struct strip *s)
{
    return s->any ? 2 * s->reach + 1 : 0;
}

/* Of LANES rows from j on. */
PEL_INLINE lanes numbers_of(int j)
{
    lanes n;
    for (int l = 0; l < LANES; l++) {
        n[l] = (float)(j + l < N / 2 ? j + l : j + l - N);
    }
    return n;
}

PEL_INLINE void wave_vector(const struct pel_cascade *c, int i, lanes n,
                            lanes *kx, lanes *ky)
{
    float step = (float)(2.0 * PEL_PI / c->length_m);
    float tc = (float)c->turn_cos, ts = (float)c->turn_sin;
    float m = (float)(i < N / 2 ? i : i - N);
    *kx = (m * tc - n * ts) * step;
    *ky = (m * ts + n * tc) * step;
}

static void gather(const struct pel_cascade *c, int j, int i, struct bunch *out)
{
    lanes chop, kx, ky;
    for (int l = 0; l < LANES; l++) {
        const float *h = c->h0[(j + l) * N + i];
        const float *m = c->mode[(j + l) * N + i];
        out->h0r[l] = h[0];
        out->h0i[l] = h[1];
        out->mr[l] = h[2];
        out->mi[l] = h[3];
        out->frequency[l] = m[0];
        chop[l] = m[1];
    }
    wave_vector(c, i, numbers_of(j), &kx, &ky);
    lanes k2 = kx * kx + ky * ky;
    ints none = (ints)(k2 == 0.0f);
    lanes k =
        pel_lanes_root(pel_lanes_choose(none, pel_lanes_spread(1.0f), k2));
    out->ux = chop * kx / k;
    out->uy = chop * ky / k;
}

struct pel_evolve_modes *pel_evolve_modes_create(const struct pel_cascade *c)
{
    struct strip strips[N / LANES];
    size_t count = 0;
    for (int s = 0; s < N / LANES; s++) {
        strips[s] = strip_of(s * LANES, count);
        count += (size_t)columns_of(&strips[s]);
    }
    struct pel_evolve_modes *modes = aligned_alloc(
        64, (sizeof *modes + count * sizeof *modes->bunch + 63) / 64 * 64);
    if (!modes) {
        return NULL;
    }
    memcpy(modes->strip, strips, sizeof strips);
    for (int s = 0; s < N / LANES; s++) {
        struct bunch *to = &modes->bunch[strips[s].first];
        for (int i = 0; strips[s].any && i < N; i++) {
            if (i <= strips[s].reach || i >= N - strips[s].reach) {
                gather(c, s * LANES, i, to++);
            }
        }
    }
    return modes;
}

void pel_evolve_modes_destroy(struct pel_evolve_modes *modes)
{
    free(modes);
}

/* --- modes at a moment ------------------------------------------------------
 */

PEL_INLINE void put(struct pel_fft_strip *s, int i, lanes hr, lanes hi, lanes p,
                    lanes q)
{
    s->re[i] = hr * p - hi * q;
    s->im[i] = hr * q + hi * p;
}

/* One column of a strip of rows, the pairs in `range` (cascade.h). */
PEL_INLINE void put_bunch(const struct pel_cascades *all,
                          const struct pel_cascade *c, const struct bunch *b,
                          int j, int i, lanes n, double time_s,
                          struct range range, struct pel_fft_strip *out)
{
    lanes cs, sn, kx, ky, rows_d, rows_s;
    pel_lanes_turn(pel_lanes_fraction(b->frequency, time_s), &cs, &sn);
    lanes ar = b->h0r * cs + b->h0i * sn, ai = b->h0i * cs - b->h0r * sn;
    lanes br = b->mr * cs - b->mi * sn, bi = b->mi * cs + b->mr * sn;
    lanes hr = ar + br, hi = ai + bi;
    memcpy(&rows_d, &all->displacement_gain[j], sizeof rows_d);
    lanes gd = rows_d * all->displacement_gain[i];
    if (range.first == PAIR_SHIFT) {
        memcpy(&rows_s, &all->slope_gain[j], sizeof rows_s);
        lanes gs = rows_s * all->slope_gain[i];
        wave_vector(c, i, n, &kx, &ky);
        put(&out[PAIR_SHIFT], i, hr, hi, -gd * b->uy, gd * b->ux);
        put(&out[PAIR_HEIGHT], i, hr, hi, gd, -gs * b->ux * ky);
        put(&out[PAIR_SLOPE], i, hr, hi, -gs * ky, gs * kx);
        put(&out[PAIR_FOLD], i, hr, hi, -gs * b->ux * kx, -gs * b->uy * ky);
    }
    if (range.first == PAIR_BREAKING) {
        /* Σ k h e^{iφ}: the waves of k alone, twice. */
        memcpy(&rows_s, &all->slope_gain[j], sizeof rows_s);
        wave_vector(c, i, n, &kx, &ky);
        lanes g = 2.0f * rows_s * all->slope_gain[i] *
                  pel_lanes_root(kx * kx + ky * ky);
        out[PAIR_BREAKING].re[i] = g * ar;
        out[PAIR_BREAKING].im[i] = g * ai;
        return;
    }
    lanes omega = 6.28318530718f * b->frequency;
    if (range.end > PAIR_DRIFT && range.first <= PAIR_DRIFT) {
        lanes vr = omega * (ai - bi), vi = omega * (br - ar);
        lanes wr = omega * omega * hi, wi = -(omega * omega * hr);
        put(&out[PAIR_DRIFT], i, vr, vi, -gd * b->uy, gd * b->ux);
        out[PAIR_HEAVE].re[i] = gd * (vr + wr); /* − ω² h rides on i */
        out[PAIR_HEAVE].im[i] = gd * (vi + wi);
    }
    if (range.end > PAIR_SURGE) {
        lanes square = -(omega * omega);
        put(&out[PAIR_SURGE], i, square * hr, square * hi, -gd * b->uy,
            gd * b->ux);
    }
}

PEL_CLONES static void put_strip(const struct pel_cascades *all, int index,
                                 int j, double time_s, struct range range,
                                 struct pel_fft_strip *out)
{
    const struct pel_cascade *c = &all->cascade[index];
    const struct strip *strip = &c->modes->strip[j / LANES];
    const struct bunch *bunch = &c->modes->bunch[strip->first];
    lanes n = numbers_of(j);
    int reach = strip->reach;
    for (int p = range.first; p < range.end; p++) {
        size_t none = sizeof(lanes) * (size_t)(N - 2 * reach - 1);
        memset(&out[p].re[reach + 1], 0, none);
        memset(&out[p].im[reach + 1], 0, none);
    }
    for (int i = 0; i <= reach; i++) {
        put_bunch(all, c, bunch++, j, i, n, time_s, range, out);
    }
    for (int i = N - reach; i < N; i++) {
        put_bunch(all, c, bunch++, j, i, n, time_s, range, out);
    }
}

/* --- fields ----------------------------------------------------------------
 */

PEL_CLONES static void lay_rows(const struct pel_fft_strip *s, int j,
                                struct pel_fft_strip block[N / LANES])
{
    pel_lanes_lay_rows(s, j, block);
}

PEL_CLONES static void store_rest(const struct pel_evolve_work *work, int b,
                                  const struct pel_evolve_target *out)
{
    const struct pel_fft_strip *shift = &work->block[PAIR_SHIFT][b];
    const struct pel_fft_strip *height = &work->block[PAIR_HEIGHT][b];
    const struct pel_fft_strip *slope = &work->block[PAIR_SLOPE][b];
    const struct pel_fft_strip *fold = &work->block[PAIR_FOLD][b];
    const lanes zero = { 0 };
    for (int j = 0; j < N; j++) {
        int at = j * N + b * LANES;
        pel_lanes_store4(&out->displacement[at], shift->re[j], shift->im[j],
                         height->re[j], zero);
        pel_lanes_store4(&out->slopes[at], slope->re[j], slope->im[j],
                         fold->re[j], fold->im[j]);
        *(pel_lanes_loose *)&out->fold[at] = height->im[j];
    }
}

PEL_CLONES static void store_velocity(const struct pel_evolve_work *work, int b,
                                      float (*velocity)[4])
{
    const struct pel_fft_strip *drift = &work->block[PAIR_DRIFT][b];
    const struct pel_fft_strip *heave = &work->block[PAIR_HEAVE][b];
    for (int j = 0; j < N; j++) {
        pel_lanes_store4(&velocity[j * N + b * LANES], drift->re[j],
                         drift->im[j], heave->re[j], heave->im[j]);
    }
}

PEL_CLONES static void store_pair(const struct pel_evolve_work *work, int b,
                                  enum pair pair, float (*to)[2])
{
    const struct pel_fft_strip *from = &work->block[pair][b];
    for (int j = 0; j < N; j++) {
        pel_lanes_store2(&to[j * N + b * LANES], from->re[j], from->im[j]);
    }
}

static void evolve_pairs(const struct pel_cascades *all, int index,
                         double time_s, struct range range,
                         struct pel_evolve_work *work)
{
    for (int j = 0; j < N; j += LANES) {
        bool any = all->cascade[index].modes->strip[j / LANES].any;
        if (any) {
            put_strip(all, index, j, time_s, range, work->strip);
        }
        for (int p = range.first; p < range.end; p++) {
            if (any) {
                pel_fft_strip(&work->strip[p]);
                lay_rows(&work->strip[p], j, work->block[p]);
            } else {
                pel_lanes_lay_none(j, work->block[p]);
            }
        }
    }
}

void pel_evolve(const struct pel_cascades *all, int index, double time_s,
                struct pel_evolve_work *work,
                const struct pel_evolve_target *out)
{
    struct range range = { out->displacement ? PAIR_SHIFT
                           : out->velocity   ? PAIR_DRIFT
                           : out->surge      ? PAIR_SURGE
                                             : PAIR_BREAKING,
                           out->breaking   ? PAIRS
                           : out->surge    ? PAIR_BREAKING
                           : out->velocity ? PAIR_SURGE
                                           : PAIR_DRIFT };
    evolve_pairs(all, index, time_s, range, work);
    for (int b = 0; b < N / LANES; b++) {
        for (int p = range.first; p < range.end; p++) {
            pel_fft_strip(&work->block[p][b]);
        }
        if (out->displacement) {
            store_rest(work, b, out);
        }
        if (out->velocity) {
            store_velocity(work, b, out->velocity);
        }
        if (out->surge) {
            store_pair(work, b, PAIR_SURGE, out->surge);
        }
        if (out->breaking) {
            store_pair(work, b, PAIR_BREAKING, out->breaking);
        }
    }
}

/* The order of the sum is that of shaders/fft_mips.comp. */
void pel_evolve_halve(const float *from, int n, int channels, float *to)
{
    int half = n / 2;
    for (int y = 0; y < half; y++) {
        const float *a = from + (size_t)(2 * y * n) * (size_t)channels;
        const float *b = a + (size_t)n * (size_t)channels;
        float *out = to + (size_t)(y * half) * (size_t)channels;
        for (int x = 0; x < half; x++) {
            if (channels <= 2) {
                for (int k = 0; k < channels; k++) {
                    int at = 2 * x * channels + k;
                    out[x * channels + k] = 0.25f * (a[at] + a[at + channels] +
                                                     b[at] + b[at + channels]);
                }
                continue;
            }
            texel t[4];
            memcpy(t, a + 8 * (size_t)x, 2 * sizeof *t);
            memcpy(t + 2, b + 8 * (size_t)x, 2 * sizeof *t);
            t[0] = 0.25f * (t[0] + t[1] + t[2] + t[3]);
            memcpy(out + 4 * (size_t)x, t, sizeof *t);
        }
    }
}
