#include "ocean/cascade.h"

#include <math.h>
#include <pthread.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "base/simd.h"
#include "ocean/directional.h"
#include "ocean/evenmodes.h"
#include "ocean/evolve.h"
#include "ocean/fields.h"
#include "ocean/hash.h"

#define N PEL_CASCADE_N
#define RINGS (PEL_CASCADE_HIGHEST + 1)
#define HIGHEST_SQUARE (PEL_CASCADE_HIGHEST * PEL_CASCADE_HIGHEST)
#define FOLD_STEPS PEL_DIRECTIONAL_NODES

/* Slopes along, across, mixed, and nothing. */
typedef double lanes4 __attribute__((vector_size(32), aligned(16)));

/* Angles of the grids: no two are near a multiple of each other's symmetry. */
static const double turns_rad[PEL_CASCADES] = { 0.111, 0.577, 1.013, 1.417 };

/* Of the two shears of a cascade: the direction across which it runs, from the
 * tile's u, and its period in tiles. So one tile on, either way or both, each
 * is somewhere else. */
static const double shear_from_u_rad[2] = { 0.55, 0.55 + 0.5 * PEL_PI };
static const double shear_tiles[2] = { 2.37, 2.37 / PEL_SHEAR_RATIO };
/* Greatest shear against the next coarser cascade: as little as hides the
 * tiles, for the longest waves, which cross a whole picture, least. */
static const double shears[PEL_CASCADES] = { 0.07, 0.09, 0.12, 0.12 };

/* A band's modes are those of m_lo ≤ |m| < PEL_CASCADE_HIGHEST. */
struct ring {
    double lo, hi; /* of |m| */
};

/* --- fold guard ------------------------------------------------------------
 */

/* chop over ln k: the continuous form of the trochoids' (sea.h). With
 * B = 5.5 √(slope variance of all longer waves) kept at f(B), chop² is
 * d f² / d B² = f f' / B. */
struct fold {
    double chop[FOLD_STEPS];
};

static void fold_fill(const struct pel_directional *d, struct fold *out)
{
    double variance = 0, before = 0;
    for (int i = 0; i < FOLD_STEPS; i++) {
        struct pel_node_moments at;
        pel_directional_node(d, i, &at);
        double k = exp(d->log_k0 + d->step * i);
        double slope = k * k * at.energy;
        variance += i > 0 ? 0.5 * d->step * (before + slope) : 0;
        before = slope;
        for (int j = 0; j < d->line_count; j++) {
            double kl = hypot(d->line[j].kx, d->line[j].ky);
            bool here =
                kl >= k * exp(-0.5 * d->step) && kl < k * exp(0.5 * d->step);
            variance += here ? kl * kl * d->line[j].energy : 0;
        }
        double bound = PEL_SEA_FOLD_SIGMAS * sqrt(variance);
        out->chop[i] = 1;
        if (bound > 0.7) {
            double e = exp(-(bound - 0.7) / 0.28);
            out->chop[i] = sqrt((0.7 + 0.28 * (1.0 - e)) * e / bound);
        }
    }
}

static double fold_chop(const struct pel_directional *d, const struct fold *f,
                        double k)
{
    double place = (log(k) - d->log_k0) / d->step;
    place = pel_clamp(place, 0, FOLD_STEPS - 1.001);
    int i = (int)place;
    return f->chop[i] + (place - i) * (f->chop[i + 1] - f->chop[i]);
}

/* --- modes ------------------------------------------------------------------
 */

struct builder { /* of one cascade */
    struct pel_cascades *all;
    int index;
    const struct pel_sea_desc *desc;
    const struct pel_directional *spectrum;
    struct fold fold;
    struct ring rings[RINGS];
    /* Of the modes at a squared distance from the middle; there are ten times
     * fewer of these than modes. */
    float known[HIGHEST_SQUARE][2]; /* as pel_cascade.mode; 0: not yet */
    lanes4 slopes[HIGHEST_SQUARE];  /* what the modes there carry */
    struct pel_slopes beyond[PEL_CASCADE_BOUNDS];
};

static int mode_number(int i)
{
    return i < N / 2 ? i : i - N;
}

static double radius_of(int i, int j)
{
    int m = mode_number(i), n = mode_number(j);
    return sqrt(m * m + n * n);
}

/* Samples along the edge of a mode's cell: many where the spectrum is narrow
 * against it. */
static int samples(double m)
{
    return m < 6 ? 16 : m < 16 ? 6 : m < 40 ? 2 : 1;
}

/* Energy of the cell of the wave-vector plane around (m, n). */
static double cell_energy(const struct builder *b, const struct pel_cascade *c,
                          int m, int n)
{
    double step = 2.0 * PEL_PI / c->length_m;
    int q = samples(sqrt(m * m + n * n));
    double sum = 0;
    for (int j = 0; j < q; j++) {
        for (int i = 0; i < q; i++) {
            double u = step * (m + (i + 0.5) / q - 0.5);
            double v = step * (n + (j + 0.5) / q - 0.5);
            double kx = u * c->turn_cos - v * c->turn_sin;
            double ky = u * c->turn_sin + v * c->turn_cos;
            double k2 = kx * kx + ky * ky;
            if (k2 > 0) {
                sum += pel_directional_density(b->spectrum, kx, ky) / k2;
            }
        }
    }
    return sum * step * step / (q * q);
}

/* Least mode number of a cascade: the next coarser one has the others. */
static double lowest_mode(int index)
{
    return index == 0 ? 0.5 : PEL_CASCADE_HIGHEST / PEL_CASCADE_RATIO;
}

static int ring_of(double m, double m_lo)
{
    int r = (int)(m + 0.5), least = (int)(m_lo + 0.5);
    least = least < m_lo ? least + 1 : least;
    r = r < least ? least : r;
    return r > PEL_CASCADE_HIGHEST - 1 ? PEL_CASCADE_HIGHEST - 1 : r;
}

/* Rings of modes, one mode number wide: their energy is made exact. */
static void lay_rings(struct builder *b, double m_lo)
{
    for (int r = 0; r < RINGS; r++) {
        b->rings[r] = (struct ring){ r - 0.5, r + 0.5 };
    }
    int first = ring_of(m_lo, m_lo);
    b->rings[first].lo = m_lo > 1 ? m_lo : 0;
    b->rings[PEL_CASCADE_HIGHEST - 1].hi = PEL_CASCADE_HIGHEST;
}

/* Amplitudes by two hashed Gaussian numbers; sums what they carry. */
static void draw_modes(struct builder *b, struct pel_cascade *c, int index,
                       double m_lo)
{
    double step = 2.0 * PEL_PI / c->length_m;
    uint32_t stream = PEL_STREAM_CASCADE + (uint32_t)index;
    memset(b->known, 0, sizeof b->known);
    for (int j = 0; j < N; j++) {
        for (int i = 0; i < N; i++) {
            int at = j * N + i;
            int m = mode_number(i), n = mode_number(j);
            int square = m * m + n * n;
            if (square < m_lo * m_lo || square >= HIGHEST_SQUARE) {
                continue;
            }
            float *known = b->known[square];
            if (!(known[0] > 0)) {
                double k = step * sqrt(square);
                double f = pel_dispersion_depth(k, b->desc->depth_m);
                known[0] = (float)(f / (2.0 * PEL_PI));
                known[1] = (float)fold_chop(b->spectrum, &b->fold, k);
            }
            c->mode[at][0] = known[0];
            c->mode[at][1] = known[1];
            double energy = cell_energy(b, c, m, n);
            if (!(energy > 0)) {
                continue;
            }
            uint32_t place = 2u * (uint32_t)((n + N) * 2 * N + m + N);
            double u = 1.0 - pel_hash01(b->desc->seed, stream, place);
            double turn =
                2.0 * PEL_PI * pel_hash01(b->desc->seed, stream, place + 1);
            double size = 0.5 * sqrt(-2.0 * log(u) * energy);
            c->h0[at][0] = (float)(size * cos(turn));
            c->h0[at][1] = (float)(size * sin(turn));
        }
    }
}

/* Factor of a ring's energies, α + β cos 2θ from the wind, that gives it the
 * spectrum's energy and anisotropy. */
struct ring_fit {
    double s0, s2, s22; /* Σ p, Σ p cos 2θ, Σ p cos² 2θ as drawn */
    double alpha, beta;
};

/* Twice the angle from the wind's axis to the grid's: cosine and sine. */
struct twice {
    double cosine, sine;
};

static struct twice twice_from_wind(const struct pel_cascade *c,
                                    double wind_rad)
{
    double to_wind = atan2(c->turn_sin, c->turn_cos) - wind_rad;
    return (struct twice){ cos(2 * to_wind), sin(2 * to_wind) };
}

/* cos 2θ of a mode. */
static double cos_2(const struct twice *t, int i, int j)
{
    double m = mode_number(i), n = mode_number(j);
    return ((m * m - n * n) * t->cosine - 2 * m * n * t->sine) /
           (m * m + n * n);
}

/* The same, continuous in the spectrum: β/α is held within ±0.8, and goes to 0
 * where the modes that there are say too little of it. */
static void fit_steadily(double m0, double e2, struct ring_fit *f)
{
    double det = f->s0 * f->s22 - f->s2 * f->s2;
    double up = e2 * f->s0 - m0 * f->s2;
    double down = m0 * f->s22 - e2 * f->s2;
    double known = pel_clamp(det / (f->s0 * f->s0) / 4e-3 - 0.25, 0, 1);
    /* Where up is 0 down is not below 0. */
    double ratio = up / fmax(fmax(down, fabs(up) / 0.8), 1e-300);
    ratio *= known * known * (3 - 2 * known);
    f->alpha = m0 / (f->s0 + ratio * f->s2);
    f->beta = ratio * f->alpha;
}

static void fit_ring(const struct builder *b, double step, int r,
                     struct ring_fit *f)
{
    struct pel_band_moments exact;
    pel_directional_continuous(b->spectrum, step * b->rings[r].lo,
                               step * b->rings[r].hi, &exact);
    double slopes = exact.along + exact.cross;
    if (!(f->s0 > 0) || !(slopes > 0)) {
        return;
    }
    double e2 = exact.m0 * (exact.along - exact.cross) / slopes;
    if (b->desc->steady) {
        fit_steadily(exact.m0, e2, f);
        return;
    }
    double det = f->s0 * f->s22 - f->s2 * f->s2;
    f->alpha = (exact.m0 * f->s22 - e2 * f->s2) / det;
    f->beta = (e2 * f->s0 - exact.m0 * f->s2) / det;
    /* A few modes all one way cannot be turned. */
    if (!(det > 1e-3 * f->s0 * f->s0) || fabs(f->beta) > 0.8 * f->alpha) {
        f->alpha = exact.m0 / f->s0;
        f->beta = 0;
    }
}

/* Gives each ring the spectrum's energy and its slopes along and across the
 * wind; the amplitudes' scatter then only moves them within a ring. */
static void scale_rings(struct builder *b, struct pel_cascade *c, double m_lo)
{
    double step = 2.0 * PEL_PI / c->length_m;
    const struct twice t = twice_from_wind(c, b->spectrum->wind_to_rad);
    struct ring_fit fits[RINGS] = { 0 };
    for (int at = 0; at < N * N; at++) {
        const float *h = c->h0[at];
        double p = 2.0 * ((double)h[0] * h[0] + (double)h[1] * h[1]);
        if (p > 0) {
            int i = at % N, j = at / N;
            double c2 = cos_2(&t, i, j);
            double radius = radius_of(i, j);
            struct ring_fit *f = &fits[ring_of(radius, m_lo)];
            f->s0 += p;
            f->s2 += p * c2;
            f->s22 += p * c2 * c2;
        }
    }
    for (int r = ring_of(m_lo, m_lo); r < PEL_CASCADE_HIGHEST; r++) {
        fit_ring(b, step, r, &fits[r]);
    }
    for (int at = 0; at < N * N; at++) {
        float *h = c->h0[at];
        if (h[0] != 0 || h[1] != 0) {
            int i = at % N, j = at / N;
            double radius = radius_of(i, j);
            const struct ring_fit *f = &fits[ring_of(radius, m_lo)];
            double g = sqrt(f->alpha + f->beta * cos_2(&t, i, j));
            h[0] = (float)(g * h[0]);
            h[1] = (float)(g * h[1]);
        }
    }
}

/* Single waves go to the mode nearest to their wave vector: they run straight
 * over the tile's edges, up to half a mode from their wavelength, with their
 * own period. */
static void add_singles(const struct builder *b, struct pel_cascade *c)
{
    double step = 2.0 * PEL_PI / c->length_m;
    for (int i = 0; i < b->spectrum->line_count; i++) {
        const struct pel_directional_line *l = &b->spectrum->line[i];
        double k = hypot(l->kx, l->ky);
        if (!(k >= c->k_lo && k < c->k_hi)) {
            continue;
        }
        double u = (l->kx * c->turn_cos + l->ky * c->turn_sin) / step;
        double v = (l->ky * c->turn_cos - l->kx * c->turn_sin) / step;
        int m = (int)lround(u), n = (int)lround(v);
        int at = (n + N) % N * N + (m + N) % N;
        int opposite = (N - n) % N * N + (N - m) % N;
        double size = sqrt(0.5 * l->energy);
        /* Texels stand half a texel from the origin (cascade.h). */
        double phase = b->desc->single[i].phase_rad + PEL_PI * (m + n) / N;
        c->h0[at][0] += (float)(size * cos(phase));
        c->h0[at][1] += (float)(size * sin(phase));
        if (!(c->mode[at][0] > 0)) { /* just outside the rounded band */
            float chop = (float)fold_chop(b->spectrum, &b->fold, k);
            c->mode[at][1] = c->mode[opposite][1] = chop;
        }
        double f = pel_dispersion_depth(k, b->desc->depth_m);
        c->mode[at][0] = c->mode[opposite][0] = (float)(f / (2.0 * PEL_PI));
    }
}

static void mirror_modes(struct pel_cascade *c)
{
    for (int j = 0; j < N; j++) {
        for (int i = 0; i < N; i++) {
            const float *there = c->h0[(N - j) % N * N + (N - i) % N];
            c->h0[j * N + i][2] = there[0];
            c->h0[j * N + i][3] = -there[1];
        }
    }
}

/* --- statistics --------------------------------------------------------------
 */

/* Mean over a texel of level l of a_l(x) conj a_{l+d}(x), d = 0 or 1, for a
 * wave of q radians for each texel of level 0 along one axis: a_l is level l of
 * the mipmap, interpolated linearly. Both are linear between multiples of half
 * a texel of level l, so Simpson's rule is exact. */
static double box(double q, int level)
{
    double s = sin(0.5 * q);
    int n = 1 << level;
    return fabs(s) < 1e-9 ? 1.0 : sin(0.5 * q * n) / (n * s);
}

/* Level l's interpolant at x (texels of level 0), over e^{iqx}: (re, im). */
static void level_at(double q, int level, double x, double out[2])
{
    double size = 1 << level;
    double place = x / size - 0.5, below = floor(place), f = place - below;
    double gain = box(q, level);
    double a = q * size * (below + 0.5), b = a + q * size;
    out[0] = gain * ((1 - f) * cos(a) + f * cos(b));
    out[1] = gain * ((1 - f) * sin(a) + f * sin(b));
}

static double level_product(double q, int a, int b)
{
    double size = 1 << a, sum = 0;
    enum { PIECES = 4 }; /* halves of the two texels of b's one */
    for (int i = 0; i < PIECES; i++) {
        for (int j = 0; j < 3; j++) {
            double u[2], v[2];
            /* just inside the piece: at its ends floor() could fall on
             * either side by rounding */
            double at = pel_clamp(0.5 * j, 1e-9, 1 - 1e-9);
            double x = 0.5 * size * (i + at);
            level_at(q, a, x, u);
            level_at(q, b, x, v);
            sum += (j == 1 ? 4.0 : 1.0) * (u[0] * v[0] + u[1] * v[1]);
        }
    }
    return sum / (6.0 * PIECES);
}

/* What of a slope texture's variance each level, and each pair of
 * neighbouring levels, keeps along one axis, by mode number; and the directions
 * from which sectors go on. */
struct tables {
    double same[PEL_CASCADE_LEVELS][N], next[PEL_CASCADE_LEVELS][N];
    double edge[PEL_CASCADE_SECTORS][2];
};

static struct tables tables;
static pthread_once_t tables_once = PTHREAD_ONCE_INIT;

static void tables_fill(void)
{
    struct tables *g = &tables;
    for (int i = 0; i < PEL_CASCADE_SECTORS; i++) {
        g->edge[i][0] = cos(PEL_PI * i / PEL_CASCADE_SECTORS);
        g->edge[i][1] = sin(PEL_PI * i / PEL_CASCADE_SECTORS);
    }
    for (int l = 0; l < PEL_CASCADE_LEVELS; l++) {
        for (int i = 0; i < N; i++) {
            double q = 2.0 * PEL_PI * mode_number(i) / N;
            double first = (2.0 + cos(q)) / 3.0; /* slope_gain's square, over */
            g->same[l][i] = level_product(q, l, l) / first;
            g->next[l][i] = l + 1 < PEL_CASCADE_LEVELS
                                ? level_product(q, l, l + 1) / first
                                : 0;
        }
    }
}

static void add_slopes(struct pel_slopes *to, const double s[3], double weight)
{
    to->along += weight * s[0];
    to->cross += weight * s[1];
    to->mixed += weight * s[2];
}

/* Slopes of the modes of a squared radius, which stand for one mode number's
 * width of |k|, into the bins there; summed up when all cascades are drawn. */
static void count_modes(struct builder *b, const struct pel_cascades *all,
                        const struct pel_cascade *c, int square)
{
    const lanes4 *s = &b->slopes[square];
    double step = 2.0 * PEL_PI / c->length_m;
    double radius = sqrt(square);
    double lo = fmax(radius - 0.5, c->k_lo / step);
    double hi = fmin(radius + 0.5, PEL_CASCADE_HIGHEST);
    int pieces = radius < 40 ? 64 / (int)(radius + 1) + 4 : 4;
    for (int i = 0; i < pieces; i++) {
        double k = step * (lo + (hi - lo) * (i + 0.5) / pieces);
        double place = (log(k) - all->log_k0) / all->step;
        int at = (int)pel_clamp(place, 0, PEL_CASCADE_BOUNDS - 2);
        const double add[3] = { (*s)[0], (*s)[1], (*s)[2] };
        add_slopes(&b->beyond[at], add, 1.0 / pieces);
    }
}

/* Variance of one sector at the levels and between neighbours. */
struct sector_sums {
    lanes4 same[PEL_CASCADE_LEVELS], next[PEL_CASCADE_LEVELS];
};

/* Between two levels the texture is their mean, weighted. */
static void blend_levels(const struct sector_sums *sum,
                         struct pel_slopes kept[PEL_CASCADE_LODS])
{
    for (int i = 0; i < PEL_CASCADE_LODS; i++) {
        int l = i / PEL_CASCADE_LOD_STEPS;
        double f = (double)(i % PEL_CASCADE_LOD_STEPS) / PEL_CASCADE_LOD_STEPS;
        int m = l + 1 < PEL_CASCADE_LEVELS ? l + 1 : l;
        lanes4 v = (1 - f) * (1 - f) * sum->same[l] +
                   2 * f * (1 - f) * sum->next[l] + f * f * sum->same[m];
        kept[i] = (struct pel_slopes){ v[0], v[1], v[2] };
    }
}

/* The sector of half a turn, from the wind, that a wave vector is in. */
PEL_INLINE int sector_of(double along, double cross)
{
    int sector = 0;
    double side = cross < 0 || (cross == 0 && along < 0) ? -1 : 1;
    for (int i = 1; i < PEL_CASCADE_SECTORS; i++) {
        sector +=
            side * (cross * tables.edge[i][0] - along * tables.edge[i][1]) >= 0;
    }
    return sector;
}

PEL_CLONES
static void fill_kept(struct builder *b, struct pel_cascade *c)
{
    const struct tables *g = &tables;
    struct sector_sums sums[PEL_CASCADE_SECTORS];
    memset(sums, 0, sizeof sums);
    memset(b->slopes, 0, sizeof b->slopes);
    double step = 2.0 * PEL_PI / c->length_m;
    double wx = cos(b->spectrum->wind_to_rad);
    double wy = sin(b->spectrum->wind_to_rad);
    for (int j = 0; j < N; j++) {
        for (int i = 0; i < N; i++) {
            const float *h = c->h0[j * N + i];
            double p = 2.0 * ((double)h[0] * h[0] + (double)h[1] * h[1]);
            if (!(p > 0)) {
                continue;
            }
            int m = mode_number(i), n = mode_number(j);
            double u = step * m, v = step * n;
            double kx = u * c->turn_cos - v * c->turn_sin;
            double ky = u * c->turn_sin + v * c->turn_cos;
            double along = kx * wx + ky * wy, cross = ky * wx - kx * wy;
            lanes4 s = { p * along * along, p * cross * cross,
                         p * along * cross, 0 };
            c->m0 += p;
            int square = m * m + n * n;
            b->slopes[square < HIGHEST_SQUARE ? square : HIGHEST_SQUARE - 1] +=
                s;
            struct sector_sums *to = &sums[sector_of(along, cross)];
            for (int l = 0; l < PEL_CASCADE_LEVELS; l++) {
                to->same[l] += s * (g->same[l][i] * g->same[l][j]);
                to->next[l] += s * (g->next[l][i] * g->next[l][j]);
            }
        }
    }
    for (int i = 0; i < PEL_CASCADE_SECTORS; i++) {
        blend_levels(&sums[i], c->kept[i]);
    }
}

/* From bins to sums of all beyond each bound. */
static void sum_beyond(struct pel_cascades *c,
                       const struct pel_directional *spectrum,
                       const struct pel_slopes *rest)
{
    struct pel_cascade_beyond sum = { 0, *rest };
    for (int i = PEL_CASCADE_BOUNDS - 1; i >= 0; i--) {
        const struct pel_slopes *s = &c->beyond[i].slopes;
        const double add[3] = { s->along, s->cross, s->mixed };
        double k = exp(c->log_k0 + c->step * i);
        struct pel_band_moments bin;
        if (i < PEL_CASCADE_BOUNDS - 1) { /* the rings have just this energy */
            pel_directional_moments(spectrum, i > 0 ? k : 0,
                                    exp(c->log_k0 + c->step * (i + 1)), &bin);
            sum.m0 += bin.m0;
        }
        add_slopes(&sum.slopes, add, 1);
        c->beyond[i] = sum;
    }
}

struct pel_cascade_beyond pel_cascades_below(const struct pel_cascades *c,
                                             double wavelength_m)
{
    double place = (log(2.0 * PEL_PI / wavelength_m) - c->log_k0) / c->step;
    place = pel_clamp(place, 0, PEL_CASCADE_BOUNDS - 1.001);
    int i = (int)place;
    double f = place - i;
    const struct pel_cascade_beyond *a = &c->beyond[i], *b = a + 1;
    return (struct pel_cascade_beyond){
        a->m0 + f * (b->m0 - a->m0),
        { a->slopes.along + f * (b->slopes.along - a->slopes.along),
          a->slopes.cross + f * (b->slopes.cross - a->slopes.cross),
          a->slopes.mixed + f * (b->slopes.mixed - a->slopes.mixed) },
    };
}

static struct pel_slopes kept_of_sector(const struct pel_cascade *c, int sector,
                                        double lod)
{
    double place = pel_clamp(lod, 0, PEL_CASCADE_LEVELS - 1);
    place = fmin(place * PEL_CASCADE_LOD_STEPS, PEL_CASCADE_LODS - 1.001);
    int i = (int)place;
    double f = place - i;
    const struct pel_slopes *a = &c->kept[sector][i], *b = a + 1;
    return (struct pel_slopes){
        a->along + f * (b->along - a->along),
        a->cross + f * (b->cross - a->cross),
        a->mixed + f * (b->mixed - a->mixed),
    };
}

struct pel_slopes pel_cascade_kept(const struct pel_cascade *c, double lod)
{
    struct pel_slopes sum = { 0 };
    for (int i = 0; i < PEL_CASCADE_SECTORS; i++) {
        struct pel_slopes s = kept_of_sector(c, i, lod);
        sum.along += s.along;
        sum.cross += s.cross;
        sum.mixed += s.mixed;
    }
    return sum;
}

struct pel_slopes pel_cascades_left(const struct pel_cascades *c,
                                    double footprint_m, double bias)
{
    struct pel_slopes left = c->total;
    double level = log2(footprint_m) + bias;
    for (int s = 0; s < PEL_CASCADE_SECTORS; s++) {
        for (int i = 0; i < PEL_CASCADES; i++) {
            struct pel_slopes kept = kept_of_sector(
                &c->cascade[i], s, level - log2(c->cascade[i].texel_m));
            left.along -= kept.along;
            left.cross -= kept.cross;
            left.mixed -= kept.mixed;
        }
    }
    left.along = fmax(left.along, 0);
    left.cross = fmax(left.cross, 0);
    return left;
}

/* --- the whole
 * ---------------------------------------------------------------- */

static void fill_gains(struct pel_cascades *c)
{
    for (int i = 0; i < N; i++) {
        double q = 2.0 * PEL_PI * mode_number(i) / N;
        /* Mean square over a texel of B-splines of order 1 and 3: samples of
         * those of order 3 and 7. */
        double linear = (2.0 + cos(q)) / 3.0;
        double cubic = (2416.0 + 2382.0 * cos(q) + 240.0 * cos(2.0 * q) +
                        2.0 * cos(3.0 * q)) /
                       5040.0;
        c->slope_gain[i] = (float)(1.0 / sqrt(linear));
        c->displacement_gain[i] = (float)(1.0 / sqrt(cubic));
    }
}

static bool allocate(struct pel_cascades *c)
{
    bool whole = pel_fields_cache_init(&c->cache);
    for (int i = 0; i < PEL_CASCADES; i++) {
        c->cascade[i].h0 = calloc(PEL_CASCADE_MODES, sizeof *c->cascade[i].h0);
        c->cascade[i].mode =
            calloc(PEL_CASCADE_MODES, sizeof *c->cascade[i].mode);
        whole = whole && c->cascade[i].h0 && c->cascade[i].mode;
    }
    return whole;
}

static void place_cascade(struct pel_cascade *c, int index)
{
    c->length_m = PEL_CASCADE_HIGHEST * PEL_SEA_SHORTEST_M *
                  pow(PEL_CASCADE_RATIO, PEL_CASCADES - 1 - index);
    c->texel_m = c->length_m / N;
    c->turn_cos = cos(turns_rad[index]);
    c->turn_sin = sin(turns_rad[index]);
    c->k_lo = 2.0 * PEL_PI / c->length_m * lowest_mode(index);
    c->k_lo = index == 0 ? 0 : c->k_lo;
    c->k_hi = 2.0 * PEL_PI / c->length_m * PEL_CASCADE_HIGHEST;
}

static void place_shears(struct pel_cascades *all)
{
    for (int i = 0; i < PEL_SHEARS; i++) {
        const struct pel_cascade *c = &all->cascade[i / 2];
        double angle = turns_rad[i / 2] + shear_from_u_rad[i % 2];
        double period = shear_tiles[i % 2] * c->length_m;
        const double f[2] = { cos(angle) / period, sin(angle) / period };
        const double v[2] = { -shears[i / 2] * period * sin(angle),
                              shears[i / 2] * period * cos(angle) };
        all->shears.fx[i] = f[0];
        all->shears.fy[i] = f[1];
        for (int j = 0; j < 2; j++) {
            all->shears.v[i][j] = v[j];
            all->shears.turn[i][2 * j] = v[j] * f[0];
            all->shears.turn[i][2 * j + 1] = v[j] * f[1];
        }
    }
}

static void *build_cascade(void *argument)
{
    struct builder *b = argument;
    struct pel_cascade *c = &b->all->cascade[b->index];
    double m_lo = lowest_mode(b->index);
    place_cascade(c, b->index);
    lay_rings(b, m_lo);
    draw_modes(b, c, b->index, m_lo);
    scale_rings(b, c, m_lo);
    if (!b->desc->steady) {
        pel_cascade_even(b->spectrum, b->desc, b->index, c);
    }
    add_singles(b, c);
    mirror_modes(c);
    c->modes = pel_evolve_modes_create(c);
    fill_kept(b, c);
    for (int i = 0; i < HIGHEST_SQUARE; i++) {
        if (b->slopes[i][0] + b->slopes[i][1] > 0) {
            count_modes(b, b->all, c, i);
        }
    }
    return NULL;
}

/* Each on a thread of its own, summed in order: the same bits always. */
static void build_cascades(struct builder *builders, struct pel_cascades *all)
{
    pthread_t threads[PEL_CASCADES];
    bool running[PEL_CASCADES];
    for (int i = 0; i < PEL_CASCADES; i++) {
        running[i] =
            i + 1 < PEL_CASCADES &&
            pthread_create(&threads[i], NULL, build_cascade, &builders[i]) == 0;
        if (!running[i]) {
            build_cascade(&builders[i]);
        }
    }
    for (int i = 0; i < PEL_CASCADES; i++) {
        if (running[i]) {
            pthread_join(threads[i], NULL);
        }
        all->m0 += all->cascade[i].m0;
        for (int j = 0; j < PEL_CASCADE_BOUNDS; j++) {
            const struct pel_slopes *from = &builders[i].beyond[j];
            const double add[3] = { from->along, from->cross, from->mixed };
            add_slopes(&all->beyond[j].slopes, add, 1);
        }
    }
}

enum pel_err pel_cascades_create(const struct pel_sea_desc *desc,
                                 struct pel_cascades **out)
{
    struct pel_directional *spectrum = NULL;
    enum pel_err err = pel_directional_create(desc, &spectrum);
    if (err) {
        return err;
    }
    struct pel_cascades *c = calloc(1, sizeof *c);
    struct builder *b = calloc(PEL_CASCADES, sizeof *b);
    if (!c || !b || !allocate(c)) {
        err = PEL_ERR_NO_MEMORY;
        goto done;
    }
    fold_fill(spectrum, &b->fold);
    for (int i = 0; i < PEL_CASCADES; i++) {
        b[i].fold = b->fold;
        b[i].all = c;
        b[i].index = i;
        b[i].desc = desc;
        b[i].spectrum = spectrum;
    }
    pthread_once(&tables_once, tables_fill);
    fill_gains(c);
    double longest = 2.0 * PEL_CASCADE_HIGHEST * PEL_SEA_SHORTEST_M *
                     pow(PEL_CASCADE_RATIO, PEL_CASCADES - 1);
    c->log_k0 = log(2.0 * PEL_PI / longest);
    c->step = log(longest / PEL_SEA_SHORTEST_M) / (PEL_CASCADE_BOUNDS - 1);
    build_cascades(b, c);
    place_shears(c);
    for (int i = 0; i < PEL_CASCADES; i++) {
        if (!c->cascade[i].modes) {
            err = PEL_ERR_NO_MEMORY;
            goto done;
        }
    }
    struct pel_band_moments below;
    pel_directional_moments(spectrum, 2.0 * PEL_PI / PEL_SEA_SHORTEST_M,
                            INFINITY, &below);
    struct pel_slopes rest = { below.along, below.cross, below.mixed };
    sum_beyond(c, spectrum, &rest);
    c->total = c->beyond[0].slopes;
    *out = c;
    c = NULL;
done:
    free(b);
    pel_cascades_destroy(c);
    pel_directional_destroy(spectrum);
    return err;
}

void pel_cascades_destroy(struct pel_cascades *c)
{
    if (!c) {
        return;
    }
    for (int i = 0; i < PEL_CASCADES; i++) {
        free(c->cascade[i].h0);
        free(c->cascade[i].mode);
        pel_evolve_modes_destroy(c->cascade[i].modes);
    }
    pel_fields_cache_finish(c->cache);
    free(c);
}
