/* How one trochoid stands for its cell of the directional spectrum, a bin of
 * frequencies and a sector of directions. A wave of one wave vector would leave
 * the rest of its cell empty: lines in a time series, crests straight for ever
 * and a lattice where a few of them cross. So its wave vector wanders to and
 * fro along the cell's diagonal, evenly, in space; its frequency wanders with
 * it by the dispersion relation (to first order: the pattern travels at the
 * group velocity): phase = k·x − ω t + swing · G(s),   s = m·x − rate · t +
 * start, G = r − 2 r |r|,   r = fract(s) − ½, whose derivatives are K = k +
 * swing · G' · m,   Ω = ω + swing · G' · rate,   G' = 1 − 4 |r|. G' is spread
 * evenly over −1..1, so each part of the cell gets its share of the wave's
 * energy. Height stays; k and ω are the cell's middle. A function of place and
 * time like the rest, so nothing remembers anything. */
#pragma once

#include <math.h>

#include "base/vec.h"
#include "ocean/directional.h"
#include "ocean/hash.h"
#include "ocean/sea.h"

/* A wander is periodic, so a cell holds so many spectral lines; no record
 * shorter than 1/rate can tell them apart. At least as many: */
#define PEL_WANDER_LINES 4.0
/* Up to four peak frequencies, where gauges look, 1/rate is at least so many
 * periods of the peak. Shorter waves wander within fewer wavelengths, because
 * pictures of them would show a lattice otherwise. */
#define PEL_WANDER_PEAKS 75.0

/* A sector has this share of the spreading on either side of its middle: five
 * waves that follow each other by the golden ratio cover all, with overlap. */
#define PEL_SECTOR_SIDE 0.15
/* The half width of sectors at most, where spreadings have tails, rad. */
#define PEL_SECTOR_MOST 0.5

/* Half width of the sector whose sides are at these angles, rad. */
static inline double pel_sector_aside(double from, double to)
{
    return fmin(0.5 * fabs(to - from), PEL_SECTOR_MOST);
}

/* A cell of the spectrum. */
struct pel_cell {
    double k_lo, k_hi;   /* rad/m */
    double angle, aside; /* directions angle ± aside, rad */
    double energy;       /* m² */
    double depth_m;      /* of the dispersion, 0: deep */
    double peak;         /* of the whole spectrum, rad/s */
};

/* A whole number, for the shaders. */
static inline double pel_wander_lines(double lo, double hi, double peak)
{
    double beyond = fmax(0.5 * (lo + hi) / (4.0 * peak), 1.0);
    return rint(fmax(PEL_WANDER_PEAKS * (hi - lo) / (peak * pow(beyond, 3.0)),
                     PEL_WANDER_LINES));
}

/* The wave of a cell, its frequency in the middle of the cell's; its phase, and
 * where and along which diagonal it begins, by the seed, the stream and number
 * `at` and the two that follow. */
static inline struct pel_wave pel_wave_of_cell(const struct pel_cell *c,
                                               uint32_t seed, uint32_t stream,
                                               uint32_t at)
{
    double lo = pel_dispersion_depth(c->k_lo, c->depth_m);
    double hi = pel_dispersion_depth(c->k_hi, c->depth_m);
    double omega = 0.5 * (lo + hi), k = pel_dispersion_k(omega, c->depth_m);
    /* A chord for an arc: the mean square over it is k² along the sector. */
    k *= 1.0 - c->aside * c->aside / 6.0;
    struct pel_wave w = {
        .kx = k * cos(c->angle),
        .ky = k * sin(c->angle),
        .amplitude = sqrt(2.0 * c->energy),
        .omega = omega,
        .phase = 2.0 * PEL_PI * pel_hash01(seed, stream, at),
        .chop = 1.0,
    };
    if (hi > lo) {
        w.swing = PEL_PI * pel_wander_lines(lo, hi, c->peak);
        double on = 0.5 * (c->k_hi - c->k_lo) / k / w.swing;
        double aside = c->aside / w.swing;
        aside = pel_hash01(seed, stream, at + 1) < 0.5 ? -aside : aside;
        w.wander_x = w.kx * on - w.ky * aside;
        w.wander_y = w.ky * on + w.kx * aside;
        w.wander_rate = 0.5 * (hi - lo) / w.swing;
        w.wander_start = pel_hash01(seed, stream, at + 2);
    }
    return w;
}

/* The phase at a place and time, and the wave vector there. */
struct pel_wave_phase {
    double phase, kx, ky;
};

static inline struct pel_wave_phase
pel_wave_at(const struct pel_wave *w, double x, double y, double time_s)
{
    double s = w->wander_x * x + w->wander_y * y +
               remainder(w->wander_start - w->wander_rate * time_s, 1.0);
    double r = s - floor(s) - 0.5;
    double swung = w->swing * (r - 2.0 * r * fabs(r));
    double u = w->swing * (1.0 - 4.0 * fabs(r));
    return (struct pel_wave_phase){
        w->kx * x + w->ky * y +
            remainder(w->phase - w->omega * time_s, 2.0 * PEL_PI) + swung,
        w->kx + u * w->wander_x, w->ky + u * w->wander_y
    };
}

/* The frequency there, rad/s, and its change, rad/s². */
struct pel_wave_rate {
    double omega, faster;
};

static inline struct pel_wave_rate
pel_wave_rate_at(const struct pel_wave *w, double x, double y, double time_s)
{
    double s = w->wander_x * x + w->wander_y * y +
               remainder(w->wander_start - w->wander_rate * time_s, 1.0);
    double r = s - floor(s) - 0.5, rate = w->swing * w->wander_rate;
    return (struct pel_wave_rate){ w->omega + rate * (1.0 - 4.0 * fabs(r)),
                                   copysign(4.0 * rate * w->wander_rate, r) };
}

/* Mean over the cell of the wave vector's products with itself. */
struct pel_wave_square {
    double xx, xy, yy;
};

static inline struct pel_wave_square pel_wave_square(const struct pel_wave *w)
{
    double third = w->swing * w->swing / 3.0;
    return (struct pel_wave_square){
        w->kx * w->kx + third * w->wander_x * w->wander_x,
        w->kx * w->ky + third * w->wander_x * w->wander_y,
        w->ky * w->ky + third * w->wander_y * w->wander_y
    };
}
