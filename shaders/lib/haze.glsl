// The air between the eye and a surface: towards its equilibrium radiance.
#ifdef PEL_CLOUDS
#include "lib/cloudfield.glsl"
#endif
layout(binding = PEL_UNIT_EYE_HAZE) uniform sampler2D eye_haze;

// What comes through of light from `range` m along the unit direction; `air`:
// what the air adds.
vec3 haze(vec3 dir, float range, out vec3 air)
{
    vec2 table = vec2(textureSize(eye_haze, 0));
    float angle = min(angle_above_horizon(dir), -1e-7);
    vec2 uv = sky_uv(azimuth_from(0, dir.xy), angle, table); // whichever: all azimuths are alike
    vec3 through = exp(-(textureLod(eye_haze, uv, 0.0).rgb + lut.z) * (range * (1.0 - water.w)));
    air = sky_light(eye_table, dir.xy, angle) * (1.0 - through);
#ifdef PEL_CLOUDS
    air *= air_below_clouds(eye.x);
#endif
#ifdef PEL_FOG
    fogged fog = fog_toward(vec3(0.0, 0.0, eye.x), dir, range);
    float left = water.w > 0.5 ? 1.0 : exp(-fog.tau);
    // The air before it.
    vec3 before = pow(through, vec3(fog.mean / max(range, 1e-3)));
    vec3 air_before = air * ((1.0 - before) / max(1.0 - through, vec3(1e-6)));
    air = air * left + (air_before + before * (fog.source + fog.single)) * (1.0 - left);
    through *= left;
#endif
    return through;
}
