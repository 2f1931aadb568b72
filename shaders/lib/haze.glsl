// The air between the eye and a surface: towards its equilibrium radiance.
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
    air *= cloud_light.x;
#endif
    return through;
}
