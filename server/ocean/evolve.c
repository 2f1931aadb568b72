#include "ocean/evolve.h"

#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "base/simd.h"
#include "ocean/fft.h"

#define N PEL_CASCADE_N
#define LANES PEL_FFT_LANES
#define HIGHEST PEL_CASCADE_HIGHEST

_Static_assert(N == PEL_FFT_N, "the transform is made for the cascades");

typedef pel_lanes lanes;
typedef int32_t ints __attribute__((vector_size(4 * LANES)));
typedef double doubles __attribute__((vector_size(8 * LANES)));
typedef float texel __attribute__((vector_size(16)));

/* Two real fields ride in one complex transform, f + i g. */
enum pair {
    PAIR_SHIFT,  /* Dx, Dy */
    PAIR_HEIGHT, /* h, ∂Dx/∂y */
    PAIR_SLOPE,  /* ∂h/∂x, ∂h/∂y */
    PAIR_FOLD,   /* ∂Dx/∂x, ∂Dy/∂y */
    PAIR_DRIFT,  /* ∂Dx/∂t, ∂Dy/∂t */
    PAIR_HEAVE,  /* ∂h/∂t, 0 */
    PAIRS,
    PAIRS_AT_REST = PAIR_DRIFT, /* without velocity */
};

/* After the transform along the rows: blocks of LANES columns, each N rows of
 * LANES, so that a block is read straight by the transform down its columns. */
struct grid {
    lanes re[N / LANES][N], im[N / LANES][N];
};

struct pel_evolve_work {
    struct grid grid[PAIRS];
    struct pel_fft_strip strip[PAIRS];
};

struct pel_evolve_work *pel_evolve_work_create(void)
{
    return aligned_alloc(64, sizeof(struct pel_evolve_work));
}

void pel_evolve_work_destroy(struct pel_evolve_work *work)
{
    free(work);
}

/* --- modes -----------------------------------------------------------------
 */

PEL_INLINE lanes spread(float x)
{
    return x - (lanes){ 0 };
}

PEL_INLINE lanes choose(ints mask, lanes yes, lanes no)
{
    return (lanes)(((ints)yes & mask) | ((ints)no & ~mask));
}

/* cos and sin of 2π x, |x| ≤ 1/2: quarter turns apart, Taylor's polynomials of
 * what is left, within 1e-7. */
PEL_INLINE void turn(lanes x, lanes *cosine, lanes *sine)
{
    const float magic = 12582912.0f; /* 1.5 · 2²³ rounds to a whole number */
    lanes shifted = x * 4.0f + magic;
    ints quarter = (ints)shifted;
    lanes a = (x - (shifted - magic) * 0.25f) * 6.28318530718f;
    lanes b = a * a;
    lanes s =
        a + a * b *
                (-1.0f / 6 +
                 b * (1.0f / 120 + b * (-1.0f / 5040 + b * (1.0f / 362880))));
    lanes c =
        1.0f +
        b * (-0.5f + b * (1.0f / 24 + b * (-1.0f / 720 + b * (1.0f / 40320))));
    ints odd = -(quarter & 1);
    lanes first = choose(odd, s, c), second = choose(odd, c, s);
    *cosine = (lanes)((ints)first ^ (((quarter + 1) & 2) << 30));
    *sine = (lanes)((ints)second ^ ((quarter & 2) << 30));
}

/* Modes i of rows j … j + LANES − 1, side by side. */
struct bunch {
    lanes h0r, h0i, mr, mi, chop, turns;
};

PEL_INLINE struct bunch gather(const struct pel_cascade *c, int j, int i,
                               double time_s)
{
    struct bunch b;
    doubles turns;
    for (int l = 0; l < LANES; l++) {
        const float *h = c->h0[(j + l) * N + i];
        const float *m = c->mode[(j + l) * N + i];
        b.h0r[l] = h[0];
        b.h0i[l] = h[1];
        b.mr[l] = h[2];
        b.mi[l] = h[3];
        turns[l] = m[0];
        b.chop[l] = m[1];
    }
    turns *= time_s;
    const double magic = 6755399441055744.0; /* 1.5 · 2⁵² */
    turns -= (turns + magic) - magic;
    b.turns = __builtin_convertvector(turns, lanes);
    return b;
}

PEL_INLINE void put(struct pel_fft_strip *s, int i, lanes hr, lanes hi, lanes p,
                    lanes q)
{
    s->re[i] = hr * p - hi * q;
    s->im[i] = hr * q + hi * p;
}

PEL_INLINE lanes square_root(lanes x)
{
    for (int l = 0; l < LANES; l++) {
        x[l] = __builtin_sqrtf(x[l]);
    }
    return x;
}

/* One column of a strip of rows, all pairs (cascade.h). */
PEL_INLINE void put_bunch(const struct pel_cascades *all,
                          const struct pel_cascade *c, int j, int i,
                          double time_s, int pairs, struct pel_fft_strip *out)
{
    struct bunch b = gather(c, j, i, time_s);
    lanes cs, sn, n, rows_d, rows_s, omega;
    turn(b.turns, &cs, &sn);
    for (int l = 0; l < LANES; l++) {
        n[l] = (float)(j + l < N / 2 ? j + l : j + l - N);
        rows_d[l] = all->displacement_gain[j + l];
        rows_s[l] = all->slope_gain[j + l];
        omega[l] = 6.28318530718f * c->mode[(j + l) * N + i][0];
    }
    lanes ar = b.h0r * cs + b.h0i * sn, ai = b.h0i * cs - b.h0r * sn;
    lanes br = b.mr * cs - b.mi * sn, bi = b.mi * cs + b.mr * sn;
    lanes hr = ar + br, hi = ai + bi;
    float step = (float)(2.0 * PEL_PI / c->length_m);
    float tc = (float)c->turn_cos, ts = (float)c->turn_sin;
    float m = (float)(i < N / 2 ? i : i - N);
    lanes kx = (m * tc - n * ts) * step, ky = (m * ts + n * tc) * step;
    lanes k2 = kx * kx + ky * ky;
    ints none = (ints)(k2 == 0.0f);
    lanes k = square_root(choose(none, spread(1.0f), k2));
    lanes ux = b.chop * kx / k, uy = b.chop * ky / k;
    lanes gd = rows_d * all->displacement_gain[i];
    lanes gs = rows_s * all->slope_gain[i];
    lanes zero = { 0 };
    put(&out[PAIR_SHIFT], i, hr, hi, -gd * uy, gd * ux);
    put(&out[PAIR_HEIGHT], i, hr, hi, gd, -gs * ux * ky);
    put(&out[PAIR_SLOPE], i, hr, hi, -gs * ky, gs * kx);
    put(&out[PAIR_FOLD], i, hr, hi, -gs * ux * kx, -gs * uy * ky);
    if (pairs > PAIRS_AT_REST) {
        lanes vr = omega * (ai - bi), vi = omega * (br - ar);
        put(&out[PAIR_DRIFT], i, vr, vi, -gd * uy, gd * ux);
        put(&out[PAIR_HEAVE], i, vr, vi, gd, zero);
    }
}

PEL_CLONES static void put_strip(const struct pel_cascades *all, int index,
                                 int j, double time_s, int pairs,
                                 struct pel_fft_strip *out)
{
    const struct pel_cascade *c = &all->cascade[index];
    for (int p = 0; p < pairs; p++) {
        size_t none = sizeof(lanes) * (size_t)(N - 2 * HIGHEST - 1);
        memset(&out[p].re[HIGHEST + 1], 0, none);
        memset(&out[p].im[HIGHEST + 1], 0, none);
    }
    for (int i = 0; i < N; i++) {
        if (i <= HIGHEST || i >= N - HIGHEST) {
            put_bunch(all, c, j, i, time_s, pairs, out);
        }
    }
}

/* --- fields ----------------------------------------------------------------
 */

#define LOW(a, b) __builtin_shufflevector(a, b, 0, 8, 1, 9, 4, 12, 5, 13)
#define HIGH(a, b) __builtin_shufflevector(a, b, 2, 10, 3, 11, 6, 14, 7, 15)
#define LOW2(a, b) __builtin_shufflevector(a, b, 0, 1, 8, 9, 4, 5, 12, 13)
#define HIGH2(a, b) __builtin_shufflevector(a, b, 2, 3, 10, 11, 6, 7, 14, 15)
#define LEFT(a, b) __builtin_shufflevector(a, b, 0, 1, 2, 3, 8, 9, 10, 11)
#define RIGHT(a, b) __builtin_shufflevector(a, b, 4, 5, 6, 7, 12, 13, 14, 15)

/* out[i][l] = in[l][i] */
PEL_INLINE void turn_over(const lanes *in, lanes *out)
{
    lanes a0 = LOW(in[0], in[1]), a1 = HIGH(in[0], in[1]);
    lanes a2 = LOW(in[2], in[3]), a3 = HIGH(in[2], in[3]);
    lanes a4 = LOW(in[4], in[5]), a5 = HIGH(in[4], in[5]);
    lanes a6 = LOW(in[6], in[7]), a7 = HIGH(in[6], in[7]);
    lanes b0 = LOW2(a0, a2), b1 = HIGH2(a0, a2);
    lanes b2 = LOW2(a1, a3), b3 = HIGH2(a1, a3);
    lanes b4 = LOW2(a4, a6), b5 = HIGH2(a4, a6);
    lanes b6 = LOW2(a5, a7), b7 = HIGH2(a5, a7);
    out[0] = LEFT(b0, b4);
    out[1] = LEFT(b1, b5);
    out[2] = LEFT(b2, b6);
    out[3] = LEFT(b3, b7);
    out[4] = RIGHT(b0, b4);
    out[5] = RIGHT(b1, b5);
    out[6] = RIGHT(b2, b6);
    out[7] = RIGHT(b3, b7);
}

/* A strip of rows into the grid's blocks of columns. */
PEL_CLONES static void lay_rows(const struct pel_fft_strip *s, int j,
                                struct grid *g)
{
    for (int b = 0; b < N / LANES; b++) {
        turn_over(&s->re[b * LANES], &g->re[b][j]);
        turn_over(&s->im[b * LANES], &g->im[b][j]);
    }
}

/* LANES texels of four components. */
PEL_INLINE void store4(float (*to)[4], lanes x, lanes y, lanes z, lanes w)
{
    lanes a = LOW(x, y), b = HIGH(x, y), c = LOW(z, w), d = HIGH(z, w);
    lanes e = LOW2(a, c), f = HIGH2(a, c), g = LOW2(b, d), h = HIGH2(b, d);
    const lanes out[4] = { LEFT(e, f), LEFT(g, h), RIGHT(e, f), RIGHT(g, h) };
    memcpy(to, out, sizeof out);
}

PEL_CLONES static void store_columns(const struct pel_fft_strip *s, int i,
                                     const struct pel_evolve_target *out)
{
    const lanes zero = { 0 };
    for (int j = 0; j < N; j++) {
        int at = j * N + i;
        store4(&out->displacement[at], s[PAIR_SHIFT].re[j], s[PAIR_SHIFT].im[j],
               s[PAIR_HEIGHT].re[j], zero);
        store4(&out->slopes[at], s[PAIR_SLOPE].re[j], s[PAIR_SLOPE].im[j],
               s[PAIR_FOLD].re[j], s[PAIR_FOLD].im[j]);
        memcpy(&out->fold[at], &s[PAIR_HEIGHT].im[j], sizeof(lanes));
        if (out->velocity) {
            store4(&out->velocity[at], s[PAIR_DRIFT].re[j], s[PAIR_DRIFT].im[j],
                   s[PAIR_HEAVE].re[j], zero);
        }
    }
}

void pel_evolve(const struct pel_cascades *all, int index, double time_s,
                struct pel_evolve_work *work,
                const struct pel_evolve_target *out)
{
    int pairs = out->velocity ? PAIRS : PAIRS_AT_REST;
    for (int j = 0; j < N; j += LANES) {
        bool any = j <= HIGHEST || j + LANES > N - HIGHEST;
        if (any) {
            put_strip(all, index, j, time_s, pairs, work->strip);
        }
        for (int p = 0; p < pairs; p++) {
            struct grid *g = &work->grid[p];
            if (any) {
                pel_fft_strip(&work->strip[p]);
                lay_rows(&work->strip[p], j, g);
                continue;
            }
            for (int b = 0; b < N / LANES; b++) {
                memset(&g->re[b][j], 0, sizeof(lanes) * LANES);
                memset(&g->im[b][j], 0, sizeof(lanes) * LANES);
            }
        }
    }
    for (int b = 0; b < N / LANES; b++) {
        for (int p = 0; p < pairs; p++) {
            struct pel_fft_strip *s = &work->strip[p];
            memcpy(s->re, work->grid[p].re[b], sizeof s->re);
            memcpy(s->im, work->grid[p].im[b], sizeof s->im);
            pel_fft_strip(s);
        }
        store_columns(work->strip, b * LANES, out);
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
            if (channels == 1) {
                out[x] =
                    0.25f * (a[2 * x] + a[2 * x + 1] + b[2 * x] + b[2 * x + 1]);
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
