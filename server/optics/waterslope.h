/* The light of water over a sloping bottom, from the maps of level water at
 * several depths. Twin of seabed_light in shaders/lib/seabed.glsl;
 * docs/physics/bottom.md compares it with the Monte Carlo. Any thread. */
#pragma once

#include "optics/waterkernel.h"

/* A point of the bottom in view. */
struct pel_slope_place {
    double depth_m; /* of the water there, > 0 */
    double under_m; /* where its line of sight enters the water, ≥ 0 */
    double slope;   /* tangent of the bottom's slope there, ≥ 0 */
    double gain;    /* cosine between the refracted Sun and the bottom's normal,
                       over that to the vertical; 0: it faces away */
    double lit;     /* of the Sun's beam that no other bottom hides, 0..1 */
};

/* How the light at a sloping place differs from that of level water of the same
 * depth, at one wavelength: the depths of level water whose scattered light it
 * has, and the share of the gain that light scattered on its way to the bottom
 * keeps. With other orders than ALL depths are the place's and `kept` is 1. */
struct pel_slope_change {
    double volume_m, bottom_m; /* light that never and that did touch it */
    double kept;
};
struct pel_slope_change pel_slope_change(const struct pel_medium *medium,
                                         enum pel_water_orders orders,
                                         const struct pel_slope_place *place);

/* Radiance just above the surface for unit sunlight and no sky. */
struct pel_slope_light {
    double volume; /* never touched the bottom */
    double bottom; /* I eq. 9 with cos γ, and what was scattered as well */
};

/* All orders, as a pixel finds them: `levels` what pel_water_kernel_build made
 * for `depths` (two or more); out[PEL_WATER_WAVELENGTHS]. */
void pel_slope_light(const struct pel_water_body *body,
                     const struct pel_water_depths *depths,
                     const struct pel_water_kernel *levels,
                     const struct pel_geometry *geometry,
                     const struct pel_slope_place *place,
                     struct pel_slope_light *out);
