// What an outline makes of the light of three neighbours.

// The parts that the neighbours below and above have in it; of each the fourth
// component of its radiance, PEL_SHOWS_*.
vec2 parts_mixed(uvec2 edge, float own, float lower, float upper)
{
    vec2 parts = unpackUnorm2x16(edge.y);
    // Land hides waves and their outlines; samples antialias objects.
    bool clear = abs(own) == 1.0;
    parts.x = clear && lower == PEL_SHOWS_SEA ? parts.x : 0.0;
    parts.y = own == PEL_SHOWS_SEA && abs(upper) == 1.0 ? parts.y : 0.0;
    return parts;
}

vec3 mixed_light(vec2 parts, vec3 own, vec3 lower, vec3 upper)
{
    vec3 light = (1.0 - parts.x - parts.y) * own;
    light += parts.y > 0.0 ? parts.y * upper : vec3(0.0);
    light += parts.x > 0.0 ? parts.x * lower : vec3(0.0);
    return light;
}
