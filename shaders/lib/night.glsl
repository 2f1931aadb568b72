// What the night's light is in a direction more than its mean around the
// horizon, which the sky table has (optics/nightsky.h), and the stars.
layout(binding = PEL_UNIT_NIGHT) uniform sampler2D night_map;

vec2 night_uv(vec2 dir, float angle)
{
    float row = sqrt(clamp(angle * (2.0 / PI), 0.0, 1.0)) * float(PEL_NIGHT_MAP_ROWS - 1);
    return vec2(atan(dir.y, dir.x) / (2.0 * PI), (row + 0.5) / float(PEL_NIGHT_MAP_ROWS));
}

vec3 night_off(vec2 dir, float angle)
{
    return textureLod(night_map, night_uv(dir, angle), 0.0).rgb;
}
