// The line that the surface draws on a dome before the lens.

// How far a pixel lies on the water's side of it, rad.
float under_line(vec3 sight)
{
    return under_eye.y / PEL_UNDER_DOME - sight.z + dot(under_eye.zw, sight.xy);
}

// How much of a pixel is in the water, and of that how much the meniscus along
// the line turns away; the lens is focused on what is far: its dome is blurred.
vec2 under_cover(vec3 sight)
{
    if (under_lens.x < 0.5) {
        return vec2(1.0, 0.0);
    }
    const float SOFT = 0.006;
    float line = under_line(sight);
    return vec2(smoothstep(-SOFT, SOFT, line), 0.55 * exp(-line * line * (0.5 / (0.012 * 0.012))));
}
