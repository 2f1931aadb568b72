// What a pixel shows that outlines cut: `parts` of it are of the neighbours
// below and above (parts_of_neighbours), the rest is its own. Light is mixed;
// other layers are the middle's, and are not written. Includers define
// triangle_at.

shaded shade_any(ivec2 at, uint triangle)
{
#ifdef PEL_LAND
    return shade_coast(at, triangle);
#else
    if (triangle == 0u) {
        return shade_backdrop(at);
    }
    return shade_sea(at, triangle);
#endif
}

shaded mixed(ivec2 at, vec2 parts)
{
    ivec2 up = upright_at(at).up;
#ifdef PEL_LAND
    // Land hides waves and their outlines.
    parts.x = parts.x > 0.0 && before_land(at - up, triangle_at(at - up)) ? parts.x : 0.0;
    parts.y = parts.y > 0.0 && before_land(at, triangle_at(at)) ? parts.y : 0.0;
#endif
    // Its own first, then those that there are: seldom both.
    ivec2 place = at;
    float weight = 1.0 - parts.x - parts.y;
    shaded sum = only_light(vec3(0.0));
    do {
        add_light(sum, shade_any(place, triangle_at(place)), weight);
        bool above = parts.y > 0.0;
        place = above ? at + up : at - up;
        weight = above ? parts.y : parts.x;
        parts = above ? vec2(parts.x, 0.0) : vec2(0.0);
    } while (weight > 0.0);
    return sum;
}
