/* Single values of the water's light from the maps that colour the picture,
 * for a unit of sunlight and no sky: what pel_transport_leaving computes in C.
 * Render thread only. */
#pragma once

#include <epoxy/gl.h>

#include "render/waterlight.h"

/* Zeroed before its first use. */
struct pel_water_prober {
    struct pel_water_light light;
    GLuint program, unit, black; /* block `light`, a sky without light */
};

/* Radiance just above a level sea [1/sr], by part and wavelength. */
struct pel_water_parts {
    double part[PEL_WATER_PARTS][PEL_WATER_WAVELENGTHS];
};

void pel_water_prober_finish(struct pel_water_prober *p);

/* Looks into water from `count` zeniths and azimuths (both in radians, azimuth
 * as pel_geometry's), the Sun at one zenith: out[count]. `depths` as in
 * pel_environment, `depth_m` where to look it up. Makes the programs at first
 * use: GPU when one does not compile. */
PEL_CHECK enum pel_err
pel_water_prober_run(struct pel_water_prober *p, const char *shader_dir,
                     const struct pel_water_body *body,
                     const struct pel_water_depths *depths, double depth_m,
                     enum pel_water_orders orders, double sun_zenith_rad,
                     const double (*views)[2], int count,
                     struct pel_water_parts *out, struct pel_fault *fault);
