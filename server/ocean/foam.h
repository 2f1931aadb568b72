/* Whitecaps: how much of the sea is foam, and where, by statistics of the
 * displacement's Jacobian (Dupuy and Bruneton 2012), for either synthesiser.
 *
 * The horizontal displacement D of waves, with every chop 1, has the Jacobian
 * det(I + ∇D) = 1 − X to first order, X = −∇·D = Σ k h cos φ, which is also the
 * downward acceleration at the surface over g: the water breaks where X exceeds
 * a threshold (Phillips 1958; Snyder and Kennedy 1983). X is a sum of many
 * waves and normal, and so is Y = Σ k h sin φ, what X was a quarter of a period
 * ago. With z = X + i Y, a water particle at phase arg z passed through its
 * last crest, of height |z|, arg z / −ω̄ ago: so its foam and the foam's age are
 * functions of z, and of z alone (no history). Waves shorter than
 * PEL_FOAM_SHORTEST_M, slower than 2.4 m/s, break without drawing in air that
 * is seen (Kleiss and Melville 2010).
 *
 * A footprint resolves a part of z; of what it leaves the variance is known.
 * The expected foam is tabulated over the resolved part and the share left: its
 * mean over any footprints is the same by construction.
 *
 * Twin of shaders/lib/foam.glsl. Immutable once built; any thread. */
#pragma once

#include <stdbool.h>

#include "base/err.h"
#include "ocean/filter.h"
#include "ocean/sea.h"
#include "shaders/lib/blocks.h"

/* Waves that break, longer than PEL_FOAM_SHORTEST_M, are those of the first two
 * cascades. */
#define PEL_FOAM_CASCADES 2
/* Seas with less foam than this have none. */
#define PEL_FOAM_LEAST 1e-5
/* e-folding time of foam on salt water (Monahan 1971). */
#define PEL_FOAM_LIFE_S 3.85
/* What is counted as whitecaps reflects 0.22 of the light, dense foam 0.55: it
 * is dense foam on this share, water on the rest (Koepke 1984). */
#define PEL_FOAM_DENSE 0.4
#define PEL_FOAM_FRESH 0.88 /* dense share where water breaks: it has holes */

struct pel_wash; /* wash.h */

struct pel_foam {
    double coverage;   /* mean share of the sea, 0..1 */
    double deviation;  /* of X, with what is never resolved */
    double threshold;  /* of X over the deviation */
    double omega;      /* ω̄, rad/s */
    double spread;     /* share of `coverage` that no crest carries, 0..1 */
    double drawn_out;  /* its structure, along the wind, times */
    double thinning_s; /* e-folding time of the dense share of what is left */
    double blown;      /* into spray, 0..1 */
    /* S⁻¹ of the share of the water that dense foam hides, by the share left, Y
     * and X, from (−REACH, −REACH) in deviations. */
    float table[PEL_FOAM_LEVELS][PEL_FOAM_SIDE][PEL_FOAM_SIDE];
};

/* Share of the sea under whitecaps at a wind at 10 m of wind_mps: the geometric
 * mean of Monahan and O'Muircheartaigh 1980, 3.84e-6 U^3.41, and Callaghan, de
 * Leeuw, Cohen and O'Dowd 2008, 3.18e-5 (U − 3.70)³ and from 10.18 m/s on
 * 4.82e-6 (U + 1.98)³. 0 up to 3.70 m/s. */
double pel_foam_of_wind(double wind_mps);

/* The foam of a built sea, desc.whitecaps times pel_foam_of_wind and what rain
 * leaves of it (ringwaves.h), 0.6 at most;
 * *out NULL: none. NO_MEMORY. About 10 ms. */
PEL_CHECK enum pel_err pel_foam_create(const struct pel_sea *sea,
                                       struct pel_foam **out);

/* Extinction of the spray between an eye at height_m > 0 above the sea and the
 * surface, its mean over any way there, 1/m: exponential over
 * PEL_SPRAY_HEIGHT_M, by the cube of the wind beyond PEL_SPRAY_FROM. */
double pel_foam_spray(const struct pel_foam *foam, double height_m);

/* Whether it is long enough to break. */
bool pel_foam_breaks(const struct pel_wave *wave);

/* Share of z's variance that a footprint leaves, PEL_FOAM_ALWAYS_LEFT..1. */
double pel_foam_left(const struct pel_sea *sea, const struct pel_filter *filter,
                     double footprint_m);

/* S, the shaders' distribution function, nearly the normal one, and its
 * inverse, for 0 < p < 1. */
double pel_foam_share(double x);
double pel_foam_share_inverse(double p);

/* Share of the water that dense foam hides where z over its deviation is (x, y)
 * and the share `left` of its variance is not resolved. */
double pel_foam_at(const struct pel_foam *foam, double x, double y,
                   double left);

/* The same before S: where foam's structure is below it, foam is. */
double pel_foam_bound(const struct pel_foam *foam, double x, double y,
                      double left);

/* Sets samples[i].foam, from the place of rest: the mean share, before foam's
 * structure, of water whose waves are all resolved; whitecaps, surf and the
 * wash together. Of samples at time_s (NULL: no wash). Any thread; on an FFT
 * sea the first of a moment computes its PEL_FIELDS_BREAKING, and aborts
 * without memory. */
void pel_foam_query(const struct pel_sea *sea, const struct pel_wash *wash,
                    size_t n, double time_s,
                    struct pel_surface_sample *samples);

/* Where z is known: how long ago it broke, s; < 0: it did not. */
double pel_foam_age(const struct pel_foam *foam, double x, double y);

/* X, Y of trochoids over their deviation, as a footprint resolves them. */
struct pel_vec2 pel_foam_trochoids(const struct pel_sea *sea,
                                   const struct pel_filter *filter,
                                   double footprint_m, struct pel_vec2 at,
                                   double time_s);

/* Structure of foam: a tile of PEL_FOAM_GRAIN² numbers, normal with mean 0 and
 * variance 1, low where foam lasts longest. Made while the program is built
 * (server/tables.c), since it takes 0.1 s of a core. */
extern const float pel_foam_grain[PEL_FOAM_GRAIN * PEL_FOAM_GRAIN];

/* The same, made anew; false without memory. */
PEL_CHECK bool pel_foam_grain_make(float *out);
