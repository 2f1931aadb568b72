#include "ocean/sea.h"

#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "ocean/bins.h"
#include "ocean/cascade.h"
#include "ocean/directional.h"
#include "ocean/foam.h"
#include "ocean/hash.h"
#include "ocean/shore.h"
#include "ocean/spectrum.h"
#include "ocean/stratified.h"
#include "ocean/wander.h"
#include "shaders/lib/blocks.h"

#define SWELL_WAVES 8
#define SWELL_WAVES_CALM 16
/* Relative width of a swell's Gaussian in frequency. */
#define SWELL_BANDWIDTH 0.06
/* Share of its energy beyond the bounds at either end. */
#define SWELL_TAIL 0.01

#define GRID 2048      /* points of the cumulative measures over ln ω */
#define DIRECTIONS 256 /* steps of the cumulative spreading over [0, π] */
#define DIRECTION_TRIES 32

/* --- wind sea ------------------------------------------------------------ */

/* Cumulative energy [m²] and slope variance of the band over ln ω. */
struct band {
    double log_lo, step;
    double energy[GRID + 1];
    double slope[GRID + 1];
    double measure[GRID + 1];
};

static void band_fill(const struct pel_sea_desc *d, double lo, double hi,
                      struct band *b)
{
    b->log_lo = log(lo);
    b->step = log(hi / lo) / GRID;
    b->energy[0] = b->slope[0] = 0;
    double e0 = 0, s0 = 0;
    for (int i = 0; i <= GRID; i++) {
        double omega = exp(b->log_lo + b->step * i);
        double k = omega * omega / PEL_GRAVITY;
        double e1 = omega * pel_spectrum_wind(d, omega);
        double s1 = k * k * e1;
        if (i > 0) {
            b->energy[i] = b->energy[i - 1] + 0.5 * b->step * (e0 + e1);
            b->slope[i] = b->slope[i - 1] + 0.5 * b->step * (s0 + s1);
        }
        e0 = e1;
        s0 = s1;
    }
    /* The bins share out the exact energy, not the trapezia's. */
    double scale = pel_spectrum_m0(d, lo, hi) / b->energy[GRID];
    for (int i = 0; i <= GRID; i++) {
        b->energy[i] *= scale;
        b->slope[i] *= scale;
    }
    pel_bins_measure(b->energy, b->slope, GRID, b->measure);
}

/* Inverse cumulative of cos^{2s}(θ/2), as a table over [0, π]. */
struct spreading {
    double cumulative[DIRECTIONS + 1];
};

static void spreading_fill(double s, struct spreading *out)
{
    double before = 1;
    out->cumulative[0] = 0;
    for (int i = 1; i <= DIRECTIONS; i++) {
        double c = fmax(cos(0.5 * PEL_PI * i / DIRECTIONS), 0);
        double after = pow(c, 2.0 * s);
        out->cumulative[i] = out->cumulative[i - 1] + 0.5 * (before + after);
        before = after;
    }
}

static double spreading_invert(const struct spreading *t, double u)
{
    double side = u < 0.5 ? -1.0 : 1.0;
    double target = fabs(2.0 * u - 1.0) * t->cumulative[DIRECTIONS];
    int lo = 0, hi = DIRECTIONS;
    while (hi - lo > 1) {
        int mid = (lo + hi) / 2;
        if (t->cumulative[mid] <= target) {
            lo = mid;
        } else {
            hi = mid;
        }
    }
    double span = t->cumulative[hi] - t->cumulative[lo];
    double f = span > 0 ? (target - t->cumulative[lo]) / span : 0;
    return side * PEL_PI * (lo + f) / DIRECTIONS;
}

struct wind_wave {
    double k_lo, k_hi, k, energy, spreading;
    struct spreading table;
    double angle, aside; /* from the wind; of the sector */
};

/* A golden-ratio sequence: waves near in wavelength run far apart in angle,
 * and any stretch of them covers the spreading evenly. */
static void wind_directions(struct wind_wave *w, int n, uint32_t seed,
                            double offset)
{
    for (int i = 0; i < n; i++) {
        double jitter =
            pel_hash01(seed, PEL_STREAM_DIRECTION, (uint32_t)i) - 0.5;
        double u = offset + 0.61803398874989485 * i + 2.0 * jitter / n;
        u -= floor(u);
        w[i].angle = spreading_invert(&w[i].table, u);
        w[i].aside = pel_sector_aside(
            spreading_invert(&w[i].table, fmax(u - PEL_SECTOR_SIDE, 0)),
            spreading_invert(&w[i].table, fmin(u + PEL_SECTOR_SIDE, 1)));
    }
}

/* How far the drawn directions are from the spreading's own moments: mean
 * direction and anisotropy, of energy and of slope variance. */
static double direction_error(const struct wind_wave *w, int n)
{
    double e = 0, s = 0, mean = 0, e_c2 = 0, e_s2 = 0, s_c2 = 0, s_s2 = 0;
    for (int i = 0; i < n; i++) {
        double a = w[i].angle, p = w[i].spreading;
        double slope = w[i].k * w[i].k * w[i].energy;
        double c2 = cos(2 * a) - p * (p - 1) / ((p + 1) * (p + 2));
        e += w[i].energy;
        s += slope;
        mean += w[i].energy * sin(a);
        e_c2 += w[i].energy * c2;
        e_s2 += w[i].energy * sin(2 * a);
        s_c2 += slope * c2;
        s_s2 += slope * sin(2 * a);
    }
    return (fabs(mean) + fabs(e_c2) + fabs(e_s2)) / e +
           (fabs(s_c2) + fabs(s_s2)) / s;
}

static void choose_directions(struct wind_wave *w, int n, uint32_t seed)
{
    double best = INFINITY, chosen = 0;
    for (uint32_t t = 0; t < DIRECTION_TRIES; t++) {
        double offset = pel_hash01(seed, PEL_STREAM_OFFSET, t);
        wind_directions(w, n, seed, offset);
        double error = direction_error(w, n);
        if (error < best) {
            best = error;
            chosen = offset;
        }
    }
    wind_directions(w, n, seed, chosen);
}

/* Cuts the band into n bins and puts one wave into each. */
static void wind_bins(const struct pel_sea_desc *d, const struct band *b,
                      struct wind_wave *w, int n)
{
    double from = pel_bins_bound(b->measure, GRID, n, 0, d->seed), spent = 0;
    for (int i = 0; i < n; i++) {
        double to = pel_bins_bound(b->measure, GRID, n, i + 1, d->seed);
        double lo = exp(b->log_lo + b->step * from);
        double hi = exp(b->log_lo + b->step * to), omega = 0.5 * (lo + hi);
        double s =
            fmax(pel_spectrum_spreading(d, omega), PEL_SEA_SPREADING_FLOOR);
        w[i].k_lo = lo * lo / PEL_GRAVITY;
        w[i].k_hi = hi * hi / PEL_GRAVITY;
        w[i].k = omega * omega / PEL_GRAVITY;
        w[i].energy = pel_bins_at(b->energy, GRID, to) - spent;
        spent += w[i].energy;
        w[i].spreading = s;
        spreading_fill(s, &w[i].table);
        from = to;
    }
}

struct wind_work {
    struct band band;
    struct wind_wave waves[PEL_SEA_MAX_WAVES];
};

static enum pel_err add_wind_sea(struct pel_sea *sea, int n)
{
    const struct pel_sea_desc *d = &sea->desc;
    double peak = pel_spectrum_peak(d);
    double lo = peak / sqrt(PEL_SEA_LONGEST);
    double hi = sqrt(PEL_GRAVITY * 2.0 * PEL_PI / PEL_SEA_SHORTEST_M);
    if (!(peak > 0) || lo >= 0.5 * hi) {
        return PEL_OK; /* under 0.15 m/s: ripples below the shortest wave */
    }
    struct wind_work *work = malloc(sizeof *work);
    if (!work) {
        return PEL_ERR_NO_MEMORY;
    }
    band_fill(d, lo, hi, &work->band);
    wind_bins(d, &work->band, work->waves, n);
    choose_directions(work->waves, n, d->seed);
    for (int i = 0; i < n; i++) {
        const struct wind_wave *w = &work->waves[i];
        struct pel_cell cell = {
            w->k_lo, w->k_hi, d->direction_rad + w->angle, w->aside, w->energy,
            0,       peak
        };
        sea->waves[sea->count++] = pel_wave_of_cell(
            &cell, d->seed, PEL_STREAM_PHASE, 3u * (uint32_t)i);
    }
    free(work);
    return PEL_OK;
}

/* --- swell --------------------------------------------------------------- */

/* Inverse of the normal distribution, by bisection on erfc. */
static double normal_quantile(double p)
{
    double lo = -6, hi = 6;
    for (int i = 0; i < 60; i++) {
        double mid = 0.5 * (lo + hi);
        if (0.5 * erfc(-mid / sqrt(2.0)) < p) {
            lo = mid;
        } else {
            hi = mid;
        }
    }
    return 0.5 * (lo + hi);
}

/* Equal energies: frequencies by strata of a Gaussian around the peak,
 * directions by strata of a Gaussian taken in another order. */
static void add_swell(struct pel_sea *sea, int index, int n)
{
    const struct pel_swell_desc *s = &sea->desc.swell[index];
    uint32_t seed = sea->desc.seed;
    uint32_t stream = PEL_STREAM_SWELL + (uint32_t)index;
    double offset = pel_hash01(seed, stream, 1000);
    for (int i = 0; i < n; i++) {
        double v = offset + 0.61803398874989485 * i +
                   0.3 * (pel_hash01(seed, stream, 4u * (uint32_t)i) - 0.5) / n;
        v = pel_clamp(v - floor(v), 0.02, 0.98);
        double from = 2.0 * PEL_PI / s->period_s, to = from;
        struct pel_cell cell = { .angle = s->direction_rad,
                                 .peak = from,
                                 .energy =
                                     s->height_m * s->height_m / 16.0 / n };
        if (n > 1) {
            double lo = fmax((double)i / n, SWELL_TAIL);
            double hi = fmin((i + 1.0) / n, 1.0 - SWELL_TAIL);
            from *= 1.0 + SWELL_BANDWIDTH * normal_quantile(lo);
            to *= 1.0 + SWELL_BANDWIDTH * normal_quantile(hi);
            cell.angle += s->spread_rad * normal_quantile(v);
            cell.aside = s->spread_rad *
                         pel_sector_aside(
                             normal_quantile(fmax(v - PEL_SECTOR_SIDE, 0.02)),
                             normal_quantile(fmin(v + PEL_SECTOR_SIDE, 0.98)));
        }
        cell.k_lo = from * from / PEL_GRAVITY;
        cell.k_hi = to * to / PEL_GRAVITY;
        sea->waves[sea->count++] =
            pel_wave_of_cell(&cell, seed, stream, 4u * (uint32_t)i + 1);
    }
}

static void add_swells(struct pel_sea *sea)
{
    const struct pel_sea_desc *d = &sea->desc;
    bool calm = !(d->wind_mps > 0);
    int trains = 0;
    for (int i = 0; i < d->swell_count; i++) {
        trains += d->swell[i].height_m > 0;
    }
    if (trains == 0) {
        return;
    }
    int left = d->wave_count - sea->count;
    int each = (calm ? left : left / 2) / trains;
    int most = calm ? SWELL_WAVES_CALM : SWELL_WAVES;
    each = each > most ? most : each < 1 ? 1 : each;
    for (int i = 0; i < d->swell_count; i++) {
        if (d->swell[i].height_m > 0) {
            add_swell(sea, i, each);
        }
    }
}

/* --- the whole ----------------------------------------------------------- */

static double wavenumber(const struct pel_wave *w)
{
    return sqrt(w->kx * w->kx + w->ky * w->ky);
}

static void sort_longest_first(struct pel_sea *sea)
{
    for (int i = 1; i < sea->count; i++) {
        struct pel_wave w = sea->waves[i];
        double k = wavenumber(&w);
        int j = i;
        while (j > 0 && wavenumber(&sea->waves[j - 1]) > k) {
            sea->waves[j] = sea->waves[j - 1];
            j--;
        }
        sea->waves[j] = w;
    }
}

/* f(B) of sea.h: the identity, bending to stay below 0.98. */
static double fold_limit(double bound)
{
    const double free = 0.7, room = 0.28;
    return bound <= free ? bound
                         : free + room * (1.0 - exp(-(bound - free) / room));
}

struct pel_folding pel_sea_folding(const struct pel_sea *sea)
{
    double variance = sea->slope_variance_along + sea->slope_variance_cross;
    double bound = PEL_SEA_FOLD_SIGMAS * sqrt(variance);
    if (bound <= 0.7) {
        return (struct pel_folding){ 1.0, 0.0 };
    }
    double kept = fold_limit(bound) / bound;
    double finest = kept * exp(-(bound - 0.7) / 0.28);
    return (struct pel_folding){ finest, (kept * kept - finest) / variance };
}

static void limit_folding(struct pel_sea *sea)
{
    double sum = 0, before = 0, kept_before = 0;
    for (int i = 0; i < sea->count; i++) {
        struct pel_wave *w = &sea->waves[i];
        double steepness = wavenumber(w) * w->amplitude;
        sum += 0.5 * steepness * steepness;
        double bound = PEL_SEA_FOLD_SIGMAS * sqrt(sum);
        double kept = fold_limit(bound);
        double whole = bound * bound - before * before;
        double allowed = kept * kept - kept_before * kept_before;
        w->chop = bound <= 0.7 || !(whole > 0)
                      ? 1.0
                      : sqrt(pel_clamp(allowed / whole, 0, 1));
        w->chop = floor(w->chop * PEL_CHOP_STEPS) / PEL_CHOP_STEPS;
        before = bound;
        kept_before = kept;
    }
}

/* Eq. 4's terms of one wave, in wind axes. */
static void add_slopes(const struct pel_sea *sea, const struct pel_wave *w,
                       struct pel_slopes *to)
{
    double c = cos(sea->desc.direction_rad);
    double s = sin(sea->desc.direction_rad);
    double ckh = w->chop * wavenumber(w) * w->amplitude;
    double square = w->amplitude * w->amplitude / (1.0 + sqrt(1.0 - ckh * ckh));
    struct pel_wave_square k = pel_wave_square(w);
    to->along += square * (c * c * k.xx + 2.0 * c * s * k.xy + s * s * k.yy);
    to->cross += square * (s * s * k.xx - 2.0 * c * s * k.xy + c * c * k.yy);
    to->mixed += square * (c * s * (k.yy - k.xx) + (c * c - s * s) * k.xy);
}

/* Totals of eq. 4 and the heights. */
static void sum_up(struct pel_sea *sea)
{
    struct pel_slopes total = { 0 };
    for (int i = 0; i < sea->count; i++) {
        const struct pel_wave *w = &sea->waves[i];
        add_slopes(sea, w, &total);
        sea->m0 += 0.5 * w->amplitude * w->amplitude;
        sea->max_height_m += w->amplitude;
        sea->max_shift_m += w->chop * w->amplitude;
    }
    sea->slope_variance_along = total.along;
    sea->slope_variance_cross = total.cross;
    sea->slope_covariance = total.mixed;
}

void pel_sea_add_singles(struct pel_sea *sea)
{
    const struct pel_sea_desc *d = &sea->desc;
    for (int i = 0; i < d->single_count; i++) {
        const struct pel_single_desc *w = &d->single[i];
        double omega = 2.0 * PEL_PI / w->period_s;
        double k = pel_dispersion_k(omega, d->depth_m);
        if (w->height_m > 0) {
            sea->waves[sea->count++] = (struct pel_wave){
                .kx = k * cos(w->direction_rad),
                .ky = k * sin(w->direction_rad),
                .amplitude = 0.5 * w->height_m,
                .omega = omega,
                .phase = w->phase_rad,
                .chop = 1.0,
            };
        }
    }
}

/* Crests of a Gaussian sea pass six standard deviations once in 6e7 waves. */
#define HIGHEST_SIGMAS 6.0

static enum pel_err build_cascades(struct pel_sea *sea)
{
    struct pel_cascades *c;
    enum pel_err err = pel_cascades_create(&sea->desc, &c);
    if (err) {
        return err;
    }
    sea->cascades = c;
    sea->m0 = sea->spectrum_m0 = c->m0;
    sea->slope_variance_along = c->total.along;
    sea->slope_variance_cross = c->total.cross;
    sea->slope_covariance = c->total.mixed;
    sea->max_height_m = sea->max_shift_m = HIGHEST_SIGMAS * sqrt(c->m0);
    return PEL_OK;
}

/* Trochoids of any spectrum but the two that have their own (add_wind_sea). */
static enum pel_err build_trochoids(struct pel_sea *sea)
{
    struct pel_directional *spectrum;
    enum pel_err err = pel_directional_create(&sea->desc, &spectrum);
    if (err) {
        return err;
    }
    pel_sea_add_singles(sea);
    err = pel_sea_add_spectrum(sea, spectrum);
    struct pel_band_moments all, below;
    pel_directional_moments(spectrum, 0, INFINITY, &all);
    pel_directional_moments(spectrum, 2.0 * PEL_PI / PEL_SEA_SHORTEST_M,
                            INFINITY, &below);
    pel_directional_destroy(spectrum);
    if (err) {
        return err;
    }
    sea->spectrum_m0 = all.m0;
    sea->below = (struct pel_slopes){ below.along, below.cross, below.mixed };
    sort_longest_first(sea);
    limit_folding(sea);
    sum_up(sea);
    sea->slope_variance_along += below.along;
    sea->slope_variance_cross += below.cross;
    sea->slope_covariance += below.mixed;
    return PEL_OK;
}

static enum pel_err build_waves(const struct pel_sea_desc *desc,
                                struct pel_sea *out)
{
    if (desc->synthesiser == PEL_SYNTHESISER_FFT) {
        return build_cascades(out);
    }
    if (!pel_spectrum_is_whole(desc)) {
        return build_trochoids(out);
    }
    pel_sea_add_singles(out);
    add_swells(out);
    enum pel_err err = add_wind_sea(out, desc->wave_count - out->count);
    if (err) {
        return err;
    }
    out->spectrum_m0 = pel_spectrum_m0(desc, 0, INFINITY);
    for (int i = 0; i < desc->swell_count; i++) {
        double h = desc->swell[i].height_m;
        out->spectrum_m0 += h * h / 16.0;
    }
    for (int i = 0; i < desc->single_count; i++) {
        double h = desc->single[i].height_m;
        out->spectrum_m0 += h * h / 8.0;
    }
    sort_longest_first(out);
    limit_folding(out);
    sum_up(out);
    return PEL_OK;
}

enum pel_err pel_sea_build(const struct pel_sea_desc *desc, struct pel_sea *out)
{
    if (!pel_sea_desc_ok(desc)) {
        return PEL_ERR_OUT_OF_RANGE;
    }
    memset(out, 0, sizeof *out);
    out->desc = *desc;
    out->desc.direction_rad = remainder(desc->direction_rad, 2.0 * PEL_PI);
    enum pel_err err = build_waves(desc, out);
    err = err ? err : pel_foam_create(out, &out->foam);
    if (err) {
        pel_sea_finish(out);
    }
    return err;
}

enum pel_err pel_sea_lay(struct pel_sea *sea,
                         const struct pel_shore_bottom *bottom)
{
    enum pel_err err = pel_shore_create(sea, bottom, &sea->shore);
    if (sea->shore) {
        sea->max_height_m *= sea->shore->highest;
        sea->max_shift_m *= sea->shore->highest;
    }
    return err;
}

void pel_sea_finish(struct pel_sea *sea)
{
    free(sea->foam);
    sea->foam = NULL;
    pel_shore_destroy(sea->shore);
    sea->shore = NULL;
    pel_cascades_destroy(sea->cascades);
    sea->cascades = NULL;
}

double pel_sea_rms_below(const struct pel_sea *sea, double wavelength_m)
{
    if (sea->cascades) {
        return sqrt(pel_cascades_below(sea->cascades, wavelength_m).m0);
    }
    double sum = 0;
    for (int i = sea->count - 1; i >= 0; i--) {
        const struct pel_wave *w = &sea->waves[i];
        if (wavenumber(w) * wavelength_m <= 2.0 * PEL_PI) {
            break;
        }
        sum += 0.5 * w->amplitude * w->amplitude;
    }
    return sqrt(sum);
}

struct pel_slopes pel_sea_slopes_below(const struct pel_sea *sea,
                                       double wavelength_m)
{
    if (sea->cascades) {
        return pel_cascades_below(sea->cascades, wavelength_m).slopes;
    }
    struct pel_slopes sum = sea->below;
    for (int i = sea->count - 1; i >= 0; i--) {
        const struct pel_wave *w = &sea->waves[i];
        if (wavenumber(w) * wavelength_m <= 2.0 * PEL_PI) {
            break;
        }
        add_slopes(sea, w, &sum);
    }
    return sum;
}

static double droppable_cascades(const struct pel_cascades *c, double rms_m)
{
    double m0 = rms_m * rms_m;
    if (c->m0 <= m0) {
        return DBL_MAX;
    }
    int lo = 0, hi = PEL_CASCADE_BOUNDS - 1;
    while (hi - lo > 1) { /* beyond[lo] > m0 >= beyond[hi] */
        int mid = (lo + hi) / 2;
        if (c->beyond[mid].m0 > m0) {
            lo = mid;
        } else {
            hi = mid;
        }
    }
    double f = (c->beyond[lo].m0 - m0) / (c->beyond[lo].m0 - c->beyond[hi].m0);
    return 2.0 * PEL_PI / exp(c->log_k0 + c->step * (lo + f));
}

double pel_sea_droppable(const struct pel_sea *sea, double rms_m)
{
    if (sea->cascades) {
        return droppable_cascades(sea->cascades, rms_m);
    }
    double below = 0, lambda_below = 0, sum = 0;
    for (int i = sea->count - 1; i >= 0; i--) {
        const struct pel_wave *w = &sea->waves[i];
        double lambda = 2.0 * PEL_PI / hypot(w->kx, w->ky);
        sum += 0.5 * w->amplitude * w->amplitude;
        double rms = sqrt(sum);
        if (rms > rms_m) {
            double f = (rms_m - below) / (rms - below);
            return lambda_below + f * (lambda - lambda_below);
        }
        below = rms;
        lambda_below = lambda;
    }
    return DBL_MAX;
}
