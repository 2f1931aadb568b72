#include "ocean/evenmodes.h"

#include <math.h>
#include <stdlib.h>

#include "base/simd.h"
#include "ocean/hash.h"

#define N PEL_CASCADE_N
/* Of the rings of cascade.c, one mode number wide; beyond, modes are close
 * enough: a bin has dozens. */
#define RINGS 32
#define EDGE (RINGS - 0.5)
#define PAIRS (RINGS * (2 * RINGS + 2))
#define PIECES_A_RING 32
#define PIECES (RINGS * PIECES_A_RING)

/* A mode and its opposite, which share a frequency. */
struct pair {
    int at, opposite;
    int square; /* of the mode number */
    double energy;
    double order; /* of those at one distance, which have no other */
};

static int by_radius(const void *a, const void *b)
{
    const struct pair *p = a, *q = b;
    if (p->square != q->square) {
        return p->square < q->square ? -1 : 1;
    }
    return (p->order > q->order) - (p->order < q->order);
}

static int gather(const struct pel_cascade *c, uint32_t seed, int index,
                  struct pair *out)
{
    uint32_t stream = PEL_STREAM_CASCADE + (uint32_t)index;
    int count = 0;
    for (int n = 0; n < RINGS; n++) {
        for (int m = n > 0 ? 1 - RINGS : 1; m < RINGS; m++) {
            int at = (n + N) % N * N + (m + N) % N;
            int opposite = (N - n) % N * N + (N - m) % N;
            const float *h = c->h0[at], *g = c->h0[opposite];
            double energy = (double)h[0] * h[0] + (double)h[1] * h[1] +
                            (double)g[0] * g[0] + (double)g[1] * g[1];
            if (energy > 0 && m * m + n * n < EDGE * EDGE) {
                /* draw_modes has the others of this stream */
                uint32_t place = ~(uint32_t)((n + N) * 2 * N + m + N);
                out[count++] =
                    (struct pair){ at, opposite, m * m + n * n, energy,
                                   pel_hash01(seed, stream, place) };
            }
        }
    }
    qsort(out, (size_t)count, sizeof *out, by_radius);
    return count;
}

/* The spectrum's energy from the band's begin, by mode number. */
struct sums {
    double lo, step;
    double sum[PIECES + 1];
    int at; /* where the last question ended */
};

static void sum_up(const struct pel_directional *spectrum, double k1, double lo,
                   struct sums *out)
{
    out->lo = lo;
    out->step = (EDGE - lo) / PIECES;
    out->sum[0] = 0;
    out->at = 0;
    for (int i = 0; i < PIECES; i++) {
        struct pel_band_moments piece;
        double from = lo + out->step * i;
        pel_directional_continuous(spectrum, k1 * from, k1 * (from + out->step),
                                   &piece);
        out->sum[i + 1] = out->sum[i] + piece.m0;
    }
}

/* Mode number at which the part `share` of the energy is reached; shares are
 * asked for in rising order. */
static double place_of(struct sums *s, double share)
{
    double want = share * s->sum[PIECES];
    while (s->at < PIECES - 1 && s->sum[s->at + 1] < want) {
        s->at++;
    }
    double below = s->sum[s->at], here = s->sum[s->at + 1] - below;
    double f = here > 0 ? pel_clamp((want - below) / here, 0, 1) : 0.5;
    return s->lo + s->step * (s->at + f);
}

void pel_cascade_even(const struct pel_directional *spectrum,
                      const struct pel_sea_desc *desc, int index,
                      struct pel_cascade *c)
{
    struct pair pairs[PAIRS]; /* with sums 93 KB of the stack */
    struct sums sums;
    double k1 = 2.0 * PEL_PI / c->length_m, whole = 0, before = 0;
    int count = gather(c, desc->seed, index, pairs);
    sum_up(spectrum, k1, c->k_lo / k1, &sums);
    for (int i = 0; i < count; i++) {
        whole += pairs[i].energy;
    }
    for (int i = 0; i < count; i++) {
        const struct pair *p = &pairs[i];
        double to = place_of(&sums, (before + 0.5 * p->energy) / whole);
        double radius = sqrt(p->square);
        before += p->energy;
        to = pel_clamp(to, radius - 0.5, radius + 0.5);
        double f = pel_dispersion_depth(k1 * to, desc->depth_m);
        c->mode[p->at][0] = c->mode[p->opposite][0] =
            (float)(f / (2.0 * PEL_PI));
    }
}
