/* Numbers of light on demand, of the reference; render/probe.h asks the shaders
 * the same. Any thread. */
#pragma once

#include "optics/atmosphere.h"

/* How a rough sea reflects, as it is drawn: terms of Ross's BRDF. Densities and
 * Λ are dimensionless, the last two 1/sr. */
struct pel_brdf_terms {
    double half_cosine;   /* of the facets that mirror the light to the eye */
    double slope_density; /* eq. 7 at their slope */
    double lambda_view, lambda_light; /* eq. 8 */
    double fresnel;                   /* at them */
    double mean_fresnel;              /* F̄, eq. 24: Smith's masking */
    double seen_fresnel;  /* F̄ over the facets seen, as it is drawn */
    double brdf;          /* reflected_sun over the cosine of the light */
    double reflected_sun; /* as drawn, for an irradiance of 1: pel_glitter */
};

/* view and light: unit, in the tangent frame (z up, x along the wind), view
 * with z ≥ 0; n the index of refraction at 550 nm. With the light below the
 * surface the last two are 0. */
void pel_brdf_terms(struct pel_vec3 view, struct pel_vec3 light, double var_x,
                    double var_y, double n, struct pel_brdf_terms *out);

struct pel_sky_terms {
    struct pel_rgb radiance; /* without the disc, W m⁻² sr⁻¹ nm⁻¹ */
    struct pel_rgb transmittance;     /* in the direction, to space */
    struct pel_rgb sun_transmittance; /* less what of the disc has set */
};

/* From an eye at height_m ≥ 0 in the unit direction `dir`; about 40 ms for the
 * tables of the air. PEL_ERR_NO_MEMORY. */
PEL_CHECK enum pel_err pel_sky_terms(double visibility_m, double height_m,
                                     struct pel_vec3 dir, struct pel_vec3 sun,
                                     struct pel_sky_terms *out);
