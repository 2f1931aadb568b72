// Areas of higher or lower short waves, twin of ocean/areas.h.

float corner_distance(vec2 p, int first, int corners)
{
    float least = 1e30;
    bool within = false;
    vec4 two = area_corners[(first + corners - 1) >> 1];
    vec2 b = ((first + corners - 1) & 1) == 0 ? two.xy : two.zw;
    for (int i = first; i < first + corners; i++) {
        two = area_corners[i >> 1];
        vec2 a = (i & 1) == 0 ? two.xy : two.zw;
        vec2 edge = b - a;
        vec2 w = p - a;
        vec2 off = w - clamp(dot(w, edge) / max(dot(edge, edge), 1e-6), 0.0, 1.0) * edge;
        least = min(least, dot(off, off));
        if ((a.y > p.y) != (b.y > p.y) && w.x < edge.x * w.y / edge.y) {
            within = !within;
        }
        b = a;
    }
    return within ? -sqrt(least) : sqrt(least);
}

// What short waves at x, the place at rest from the eye's nadir, are times. A
// footprint longer than an edge makes it softer.
float area_factor(vec2 x, float footprint)
{
    float product = 1.0;
    for (int i = 0; i < int(area_count.x); i++) {
        vec4 place = areas[i].place;
        vec4 shape = areas[i].shape;
        vec2 p = x - place.xy;
        float edge = max(place.w, footprint);
        float away = length(p) - place.z;
        if (shape.y > 0.0 && away < 0.5 * edge) {
            away = corner_distance(p, i * PEL_AREA_CORNERS, int(shape.y));
        }
        product *= 1.0 + shape.x * (1.0 - smoothstep(-0.5, 0.5, away / edge));
    }
    return min(product, PEL_AREA_FACTOR);
}

// Slope variance of which short waves are `up` times.
vec2 area_variance(vec2 variance, float up)
{
    return max(variance + (up * up - 1.0) * min(variance, area_count.zw), 0.0);
}

#ifdef PEL_WASH
#include "lib/wash.glsl"
#endif

// The same with the wash of ships; `washed`: of wash_at.
float short_waves(vec2 x, float footprint, out vec3 washed)
{
#ifdef PEL_WASH
    washed = wash_at(x, footprint);
    return min(area_factor(x, footprint) * washed.x, PEL_AREA_FACTOR);
#else
    washed = vec3(1.0, 0.0, 0.0);
    return area_factor(x, footprint);
#endif
}
