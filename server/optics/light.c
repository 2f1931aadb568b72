#include "optics/light.h"

const struct pel_light_body pel_light_bodies[PEL_LIGHTS] = {
    [PEL_LIGHT_SUN] = { .name = "sun",
                        .irradiance = PEL_SUN_IRRADIANCE,
                        .angular_radius_rad = PEL_SUN_ANGULAR_RADIUS,
                        .solid_angle_sr = PEL_SUN_SOLID_ANGLE,
                        .limb = { 0.43, 0.5, 0.6 } },
};

void pel_lights_of_sun(struct pel_vec3 direction,
                       struct pel_light out[PEL_LIGHTS])
{
    for (int i = 0; i < PEL_LIGHTS; i++) {
        out[i] = (struct pel_light){ { 0, 0, -1 }, 0.0 };
    }
    out[PEL_LIGHT_SUN] = (struct pel_light){ direction, 1.0 };
}
