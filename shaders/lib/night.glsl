// What the night's light is in a direction more than its mean around the
// horizon, which the sky table has (optics/nightsky.h).
layout(binding = PEL_UNIT_NIGHT) uniform sampler2D night_map;

vec3 night_off(vec3 dir)
{
    return textureLod(night_map, 0.5 + dir.xy * (0.5 * inversesqrt(1.0 + max(dir.z, 0.0))), 0.0).rgb;
}
