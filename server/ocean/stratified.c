#include "ocean/stratified.h"

#include <stdlib.h>

#include "ocean/bins.h"
#include "ocean/hash.h"
#include "ocean/wander.h"

#define CUT PEL_DIRECTIONAL_CUT
#define DIRECTIONS 512
#define DIRECTION_TRIES 32

/* Cumulative energy and slope variance over ln k, by node. */
struct band {
    double energy[CUT + 1], slope[CUT + 1], measure[CUT + 1];
    double peak; /* rad/s */
};

struct stratum {
    double k, energy;
    double k_lo, k_hi;     /* of the bin */
    double c2, s2, s1, c1; /* moments of the spreading there */
    double cumulative[DIRECTIONS + 1];
    double angle, aside; /* aside: of the sector */
};

struct work {
    struct band band;
    struct stratum strata[PEL_SEA_MAX_WAVES];
};

static double node_k(const struct pel_directional *d, double place)
{
    return exp(d->log_k0 + d->step * place);
}

static void band_fill(const struct pel_directional *d, struct band *b)
{
    double e0 = 0, s0 = 0;
    b->energy[0] = b->slope[0] = b->peak = 0;
    double most = 0;
    for (int i = 0; i <= CUT; i++) {
        struct pel_node_moments at;
        pel_directional_node(d, i, &at);
        double k = node_k(d, i), s1 = k * k * at.energy;
        double omega = pel_dispersion_depth(k, d->depth_m);
        if (at.energy / omega > most) {
            most = at.energy / omega;
            b->peak = omega;
        }
        if (i > 0) {
            b->energy[i] = b->energy[i - 1] + 0.5 * d->step * (e0 + at.energy);
            b->slope[i] = b->slope[i - 1] + 0.5 * d->step * (s0 + s1);
        }
        e0 = at.energy;
        s0 = s1;
    }
}

static void directions_fill(const struct pel_directional *d, struct stratum *s)
{
    s->cumulative[0] = 0;
    s->c1 = s->s1 = s->c2 = s->s2 = 0;
    for (int i = 0; i < DIRECTIONS; i++) {
        double a =
            d->wind_to_rad + 2.0 * PEL_PI * ((i + 0.5) / DIRECTIONS - 0.5);
        double w = pel_directional_density(d, s->k * cos(a), s->k * sin(a));
        s->cumulative[i + 1] = s->cumulative[i] + w;
        s->c1 += w * cos(a);
        s->s1 += w * sin(a);
        s->c2 += w * cos(2.0 * a);
        s->s2 += w * sin(2.0 * a);
    }
    double all = s->cumulative[DIRECTIONS];
    double over = all > 0 ? 1.0 / all : 0;
    s->c1 *= over;
    s->s1 *= over;
    s->c2 *= over;
    s->s2 *= over;
}

static double direction(const struct pel_directional *d,
                        const struct stratum *s, double u)
{
    double target = u * s->cumulative[DIRECTIONS];
    int lo = 0, hi = DIRECTIONS;
    while (hi - lo > 1) {
        int mid = (lo + hi) / 2;
        if (s->cumulative[mid] <= target) {
            lo = mid;
        } else {
            hi = mid;
        }
    }
    double span = s->cumulative[hi] - s->cumulative[lo];
    double f = span > 0 ? (target - s->cumulative[lo]) / span : 0.5;
    return d->wind_to_rad + 2.0 * PEL_PI * ((lo + f) / DIRECTIONS - 0.5);
}

/* A golden-ratio sequence, as in sea.c. */
static void draw_directions(const struct pel_directional *d, struct stratum *s,
                            int n, uint32_t seed, double offset)
{
    for (int i = 0; i < n; i++) {
        double jitter = pel_hash01(seed, PEL_STREAM_DIRECTION, (uint32_t)i);
        double u = offset + 0.61803398874989485 * i + 2.0 * (jitter - 0.5) / n;
        u -= floor(u);
        s[i].angle = direction(d, &s[i], u);
        s[i].aside =
            pel_sector_aside(direction(d, &s[i], fmax(u - PEL_SECTOR_SIDE, 0)),
                             direction(d, &s[i], fmin(u + PEL_SECTOR_SIDE, 1)));
    }
}

/* How far the drawn directions are from the spreading's own moments. */
static double direction_error(const struct stratum *s, int n)
{
    double e = 0, v = 0, sum[6] = { 0 };
    for (int i = 0; i < n; i++) {
        double slope = s[i].k * s[i].k * s[i].energy;
        double c2 = cos(2.0 * s[i].angle) - s[i].c2;
        double s2 = sin(2.0 * s[i].angle) - s[i].s2;
        e += s[i].energy;
        v += slope;
        sum[0] += s[i].energy * (cos(s[i].angle) - s[i].c1);
        sum[1] += s[i].energy * (sin(s[i].angle) - s[i].s1);
        sum[2] += s[i].energy * c2;
        sum[3] += s[i].energy * s2;
        sum[4] += slope * c2;
        sum[5] += slope * s2;
    }
    double error = 0;
    for (int i = 0; i < 6; i++) {
        error += fabs(sum[i]) / (i < 4 ? e : v);
    }
    return error;
}

static void cut_bins(const struct pel_directional *d, const struct band *b,
                     struct stratum *s, int n, uint32_t seed)
{
    double from = pel_bins_bound(b->measure, CUT, n, 0, seed), spent = 0;
    for (int i = 0; i < n; i++) {
        double to = pel_bins_bound(b->measure, CUT, n, i + 1, seed);
        s[i].k_lo = node_k(d, from);
        s[i].k_hi = node_k(d, to);
        s[i].k = 0.5 * (s[i].k_lo + s[i].k_hi);
        s[i].energy = pel_bins_at(b->energy, CUT, to) - spent;
        spent += s[i].energy;
        directions_fill(d, &s[i]);
        from = to;
    }
}

static void choose_directions(const struct pel_directional *d,
                              struct stratum *s, int n, uint32_t seed)
{
    double best = INFINITY, chosen = 0;
    for (uint32_t t = 0; t < DIRECTION_TRIES; t++) {
        double offset = pel_hash01(seed, PEL_STREAM_OFFSET, t);
        draw_directions(d, s, n, seed, offset);
        double error = direction_error(s, n);
        if (error < best) {
            best = error;
            chosen = offset;
        }
    }
    draw_directions(d, s, n, seed, chosen);
}

enum pel_err pel_sea_add_spectrum(struct pel_sea *sea,
                                  const struct pel_directional *spectrum)
{
    struct work *w = malloc(sizeof *w);
    if (!w) {
        return PEL_ERR_NO_MEMORY;
    }
    band_fill(spectrum, &w->band);
    struct band *band = &w->band;
    uint32_t seed = sea->desc.seed;
    int n = sea->desc.wave_count - sea->count;
    if (w->band.energy[CUT] > 0) {
        pel_bins_measure(band->energy, band->slope, CUT, band->measure);
        cut_bins(spectrum, band, w->strata, n, seed);
        choose_directions(spectrum, w->strata, n, seed);
        for (int i = 0; i < n; i++) {
            const struct stratum *s = &w->strata[i];
            struct pel_cell cell = { s->k_lo,   s->k_hi,   s->angle,
                                     s->aside,  s->energy, spectrum->depth_m,
                                     band->peak };
            sea->waves[sea->count++] = pel_wave_of_cell(
                &cell, seed, PEL_STREAM_PHASE, 3u * (uint32_t)i);
        }
    }
    free(w);
    return PEL_OK;
}
