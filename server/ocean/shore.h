/* Waves over a bottom that they feel: they slow down, bend towards the shore,
 * grow, and break where they are too high for the depth.
 *
 * Long waves are put into a few bands of like direction and length, each with a
 * mean wave vector k of the sea far out. On a grid over the bottom is solved,
 * once a sea,
 *     |k̂ + ∇s| = n,  n = k(d) / k  by  ω² = g k tanh(k d)     (eikonal)
 *     ∇·(E c_g p̂) = 0,  p̂ = (k̂ + ∇s) / n                      (action)
 * by fast sweeping (Zhao 2005) and upwind in the order of arrival. A band's
 * waves are read at X = u + s k̂ where water rests at u: their phase there is
 * that of the sea far out at X. Heights are times a = √(E/E₀), no higher than
 * PEL_SHORE_BREAKS of the depth; horizontal displacements times b = min(a,
 * 1/n), so that nothing folds that did not. One wave alone is exact; of others
 * in its band the direction's cosine scales s. No diffraction; a place has the
 * waves that come first.
 *
 * Where no band feels the bottom, on its way or there, s = 0 and a = b = 1
 * exactly. Over the outermost cells a band that was changed fades out and comes
 * again as it is far out. Twin of shaders/lib/shore.glsl. Immutable; any
 * thread. */
#pragma once

#include <stdint.h>

#include "ocean/sea.h"

#define PEL_SHORE_BREAKS 0.78 /* of the depth (McCowan 1894) */
#define PEL_SHORE_CELLS 320   /* of a side of the grid at most */

/* A bottom: heights above any zero at nodes, rows from south; its sea's mean
 * level above the same zero; what lies beyond it. */
struct pel_shore_bottom {
    int columns, rows; /* >= 2 */
    double west_m, south_m, spacing_m;
    const float *height_m;
    double level_m;
    double beyond_m; /* depth, > 0 */
};

struct pel_shore_band {
    double x, y;   /* k̂ */
    double k;      /* rad/m */
    double energy; /* m² */
};

/* What a band's waves are at a place of rest, and the derivatives by it. */
struct pel_shored {
    double s, a, b; /* b of horizontal displacements */
    double sx, sy, ax, ay, bx, by;
    double breaks; /* how much breaks there, of all bands, 0..1 */
};

struct pel_shore {
    uint64_t serial; /* no two of a process have the same */
    int columns, rows;
    double west_m, south_m, spacing_m; /* of the first node */
    int bands;
    struct pel_shore_band band[PEL_SHORE_BANDS];
    /* The band of each trochoid, or PEL_SHORE_BANDS: none. Of cascades the
     * coarser ones are bands, in their order. */
    uint8_t of_wave[PEL_SEA_MAX_WAVES];
    /* (s, a − 1, b − 1, breaking) of each band, one grid after the other, as a
     * uniform cubic B-spline's nodes. Breaking is that of all bands, 0..1. */
    float (*nodes)[4];
    uint8_t *changed; /* a node each: some spline near it is not all zero */
    double reach_m;   /* how far around a node that is told */
    double highest;   /* of all a */
};

/* The shore of a built sea over a bottom; *out NULL: nothing feels it.
 * NO_MEMORY. Some tenths of a second. */
PEL_CHECK enum pel_err pel_shore_create(const struct pel_sea *sea,
                                        const struct pel_shore_bottom *bottom,
                                        struct pel_shore **out);
void pel_shore_destroy(struct pel_shore *shore); /* NULL: none */

/* Whether waves about this place are those of the sea far out. */
bool pel_shore_far(const struct pel_shore *shore, double x_m, double y_m);

void pel_shore_at(const struct pel_shore *shore, int band, double x_m,
                  double y_m, struct pel_shored *out);
