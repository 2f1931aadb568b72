/* Brute force for fig. 10 of the 2010 paper: rays cut the full geometry of the
 * waves, every facet is a mirror, no BRDF anywhere. Flat Earth, no air. */
#pragma once

#include "optics/atmosphere.h"
#include "optics/watertable.h"
#include "render/renderer.h"

struct reference_light {
    struct pel_vec3 sun;
    struct pel_rgb sun_irradiance;       /* normal to the beam */
    struct pel_rgb sky_irradiance;       /* horizontal */
    const struct pel_water_table *water; /* of this Sun */
    double slope_sigma; /* for the environment below the horizon */
    double blur;        /* slopes: the Sun is widened by a Gaussian
                           of this standard deviation */
};

struct reference;

/* Tabulates the sky; NULL when out of memory. */
struct reference *reference_create(const struct pel_sea *sea, double time_s,
                                   double visibility_m,
                                   const struct reference_light *light);
void reference_destroy(struct reference *r);

/* Radiance the environment sends from a direction (z up), as the reflection
 * map of the renderer defines it below the horizon. */
struct pel_rgb reference_environment(const struct reference *r,
                                     struct pel_vec3 dir);

/* Adds one ray's reflected Sun, reflected sky and refracted light; false when
 * it meets no sea. */
struct reference_sample {
    struct pel_rgb sun, sky, water;
};
bool reference_trace(const struct reference *r, struct pel_vec3 eye,
                     struct pel_vec3 dir, struct reference_sample *out);
