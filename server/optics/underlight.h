/* The water's light as an eye under water sees it: the answer of plane-parallel
 * water to a beam of light from any height, for lines of sight in every
 * direction at several depths, all orders of scattering (discrete ordinates,
 * optics/ordinates.h). As in optics/waterkernel.h the Sun is one such beam and
 * the sky is made of them; shaders/under_map.comp makes maps of them that
 * shaders/lib/underlight.glsl looks up. Of the Sun the first order is not in
 * them: it has a closed form with the phase function itself. Any thread. */
#pragma once

#include "base/err.h"
#include "optics/waterbody.h"
#include "shaders/lib/blocks.h"

#define PEL_UNDER_NODES PEL_WATER_NODES

/* What there is for a level, a mode and a beam, of the values at a line of
 * sight of row 0 .. 2 PEL_UNDER_ROWS - 1 (up first): the radiance that the
 * water alone sends along it, times e^(fall z) at depth z, of sights up over
 * the share of the way to the surface that is opaque, 1 - e^(-c z / sine), for
 * a unit of irradiance normal to the refracted beam [1/sr]; Σ_m r_m cos mφ, φ
 * the azimuth of the sight from the light's. By wavelength and 0. */
struct pel_under_kernel {
    /* Scattered twice and more, and once more: all, for the sky's beams. */
    float sun[PEL_UNDER_LEVELS][PEL_UNDER_MODES][PEL_UNDER_NODES]
             [2 * PEL_UNDER_ROWS][4];
    float sky[PEL_UNDER_LEVELS][PEL_UNDER_MODES][PEL_UNDER_NODES]
             [2 * PEL_UNDER_ROWS][4];
    /* Irradiance of level planes, from above and below, scaled alike: without
     * the unscattered beam, and with it. */
    float flux[PEL_UNDER_LEVELS][PEL_UNDER_NODES][2][4];
    float flux_sky[PEL_UNDER_LEVELS][PEL_UNDER_NODES][2][4];
};

/* What the maps are made by, of a water whatever its depth. */
struct pel_under_medium {
    double scaled[PEL_WATER_WAVELENGTHS]; /* extinction without the peak, 1/m */
    double full[PEL_WATER_WAVELENGTHS];   /* extinction, 1/m */
    double fall[PEL_WATER_WAVELENGTHS];   /* 1/m */
    double peak[PEL_WATER_WAVELENGTHS];   /* share of the forward peak */
    double peak_rad;                      /* its angle, of the second */
    double peak_square;    /* variance along an axis of what it turns, rad² */
    double step_m, last_m; /* of levels: near the surface, of the last */
    /* As of the block `under`. */
    struct pel_vec4 turns[PEL_UNDER_TURNS + 1];
};

/* Depths down to deepest_m matter. Some 10 ms. NO_MEMORY. */
PEL_CHECK enum pel_err pel_under_medium_make(const struct pel_water_body *body,
                                             double deepest_m,
                                             struct pel_under_medium *out);

/* Depth of a level [m]: step (2^(i q) - 1). */
double pel_under_level(const struct pel_under_medium *m, int i);

/* Sine of the elevation of a row, 0 < x ≤ 1; the same down. */
double pel_under_row(int row);

/* The answer of water depth_m deep (what is asked below the bottom is the
 * bottom's, falling off). Some 60 ms. NO_MEMORY. */
PEL_CHECK enum pel_err
pel_under_kernel_build(const struct pel_water_body *body,
                       const struct pel_under_medium *medium, double depth_m,
                       struct pel_under_kernel *out);
