#include "optics/lightreport.h"

#include <math.h>
#include <stdlib.h>

#include "optics/airkept.h"
#include "optics/brdf.h"
#include "optics/facets.h"
#include "optics/light.h"

void pel_brdf_terms(struct pel_vec3 view, struct pel_vec3 light, double var_x,
                    double var_y, double n, struct pel_brdf_terms *out)
{
    struct pel_vec3 h = pel_vec3_normalize(pel_vec3_add(view, light));
    double z = fmax(h.z, 1e-9);
    const double radius = pel_light_bodies[PEL_LIGHT_SUN].angular_radius_rad;
    double glitter =
        pel_glitter(view, light, var_x, var_y, radius * radius / 16.0, n, 0);
    *out = (struct pel_brdf_terms){
        .half_cosine = h.z,
        .slope_density =
            pel_ross_slope_density(-h.x / z, -h.y / z, var_x, var_y),
        .lambda_view = pel_ross_lambda(pel_ross_a(view, var_x, var_y)),
        .lambda_light = pel_ross_lambda(pel_ross_a(light, var_x, var_y)),
        .fresnel = pel_fresnel_exact(pel_vec3_dot(view, h), n),
        .mean_fresnel = pel_mean_fresnel(view, var_x, var_y, n),
        .seen_fresnel = pel_facet_fresnel(view, var_x, var_y, n),
        .brdf = glitter / fmax(light.z, 1e-9),
        .reflected_sun = glitter,
    };
}

enum pel_err pel_sky_terms(double visibility_m, double height_m,
                           struct pel_vec3 dir, struct pel_vec3 sun,
                           struct pel_sky_terms *out)
{
    const struct pel_atmosphere *air = NULL;
    enum pel_err err = pel_air_take(visibility_m, NULL, NULL, &air);
    if (err != PEL_OK) {
        return err;
    }
    struct pel_rgb light = pel_atmosphere_sun_irradiance(air, height_m, sun);
    struct pel_rgb above = air->solar_irradiance;
    *out = (struct pel_sky_terms){
        .radiance = pel_atmosphere_sky(air, height_m, dir, sun),
        .transmittance = pel_atmosphere_transmittance(air, height_m, dir.z),
        .sun_transmittance = { light.r / above.r, light.g / above.g,
                               light.b / above.b },
    };
    pel_air_give(air);
    return PEL_OK;
}
