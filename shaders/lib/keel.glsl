// Hulls under the surface, seen through it.

// A hull's maps (render/hullmap.h), and the side of it that a ray can meet.
struct hull_maps {
    vec4 plan;
    int below, sides; // layers
    float low; // the hull's lowest point
    float side; // 1 starboard, -1 port
};

// Height of a hull's lowest surface over a place of its plan; none, or above the
// waterline: 0.
float hull_bottom(hull_maps h, vec2 at)
{
    vec2 texel = clamp((at - h.plan.xy) * h.plan.zw, 0.0, 1.0) * vec2(PEL_HULL_LENGTH, PEL_HULL_BREADTH);
    ivec2 i = min(ivec2(texel), ivec2(PEL_HULL_LENGTH - 1, PEL_HULL_BREADTH - 1));
    return min(texelFetch(object_hulls, ivec3(i, h.below), 0).r, 0.0);
}

// Half breadth on that side, over x and z.
float hull_side(hull_maps h, float x, float z)
{
    vec2 size_ = vec2(PEL_HULL_LENGTH, PEL_HULL_ROWS);
    vec2 texel = vec2((x - h.plan.x) * h.plan.z, 1.0 - z / h.low) * size_ - 0.5;
    texel = clamp(texel, vec2(0.0), size_ - 1.001);
    ivec2 i = ivec2(texel);
    vec2 f = texel - vec2(i);
    i.y += h.side > 0.0 ? 0 : PEL_HULL_ROWS;
    vec2 low = vec2(texelFetch(object_hulls, ivec3(i, h.sides), 0).r,
                    texelFetch(object_hulls, ivec3(i.x + 1, i.y, h.sides), 0).r);
    vec2 high = vec2(texelFetch(object_hulls, ivec3(i.x, i.y + 1, h.sides), 0).r,
                     texelFetch(object_hulls, ivec3(i + 1, h.sides), 0).r);
    vec2 column = mix(low, high, f.y);
    return mix(column.x, column.y, f.x);
}

// Above the lowest surface beside it, and within the side.
bool within_hull(hull_maps h, vec3 q)
{
    vec4 near = textureGather(object_hulls, vec3((q.xy - h.plan.xy) * h.plan.zw, float(h.below)));
    float bottom = min(min(near.x, near.y), min(near.z, near.w));
    return q.z > bottom && h.side * q.y > hull_side(h, q.x, q.z);
}

// Where the ray d from p, in the model's axes, goes into the hull; negative:
// nowhere. A march over its plan, then halving.
float hull_distance(hull_maps h, vec3 p, vec3 d)
{
    const int STEPS = 10;
    vec2 inverse = 1.0 / mix(vec2(1e-6), d.xy, greaterThan(abs(d.xy), vec2(1e-6)));
    vec2 a = (h.plan.xy - p.xy) * inverse;
    vec2 b = (h.plan.xy + 1.0 / h.plan.zw - p.xy) * inverse;
    vec2 first = min(a, b);
    vec2 last = max(a, b);
    float from = max(max(first.x, first.y), 0.0);
    float to = min(min(last.x, last.y), (h.low - p.z) / min(d.z, -1e-3));
    if (to <= from) {
        return -1.0;
    }
    float step_ = (to - from) / float(STEPS);
    float t = from;
    for (int i = 0; i < STEPS; i++) {
        if (within_hull(h, p + (t + step_) * d)) {
            break;
        }
        t += step_;
    }
    if (t >= to - 0.5 * step_) {
        return -1.0;
    }
    for (int i = 0; i < 5; i++) {
        step_ *= 0.5;
        t += within_hull(h, p + (t + step_) * d) ? 0.0 : step_;
    }
    return t + step_;
}

// Outward, in the model's axes: of the map in which the surface is less steep.
vec3 hull_normal(hull_maps h, vec3 q)
{
    vec2 apart = 2.0 / (h.plan.zw * vec2(PEL_HULL_LENGTH, PEL_HULL_BREADTH));
    vec2 x = vec2(apart.x, 0.0);
    vec2 y = vec2(0.0, apart.y);
    vec2 bottom = vec2(hull_bottom(h, q.xy + x) - hull_bottom(h, q.xy - x),
                       hull_bottom(h, q.xy + y) - hull_bottom(h, q.xy - y)) / (2.0 * apart);
    float row = h.low / float(PEL_HULL_ROWS);
    float z = clamp(q.z, h.low - 1.5 * row, 1.5 * row);
    vec2 side = vec2(hull_side(h, q.x + 0.5 * apart.x, z) - hull_side(h, q.x - 0.5 * apart.x, z),
                     hull_side(h, q.x, z - row) - hull_side(h, q.x, z + row)) / vec2(apart.x, -2.0 * row);
    return normalize(dot(side, side) < dot(bottom, bottom) ? vec3(side.x, -h.side, side.y) : vec3(bottom, -1.0));
}

// `leaving` where hulls stand in the water behind the facet n: what is left of
// the water's light, which gathers over the way to them, and theirs, matt in
// what is left of the light at their depth, which comes into the water beside
// them. Twin of none; the reference is tests/validate/shiptrace.
vec3 leaving_with_hull(int i, vec3 d, vec3 to, vec3 leaving)
{
    const float eta = 1.0 / PEL_WATER_INDEX;
    vec4 box = place_texel(i, 17); // on the lattice
    if (any(lessThan(sea_pixel, box.xy)) || any(greaterThan(sea_pixel, box.zw))) {
        return leaving;
    }
    vec4 fade = place_texel(i, 15); // 1/m; the hull's lowest point
    vec4 paint = place_texel(i, 16);
    int layer = int(object_facts(i).z);
    placed o = placed_object(i);
    vec3 p = into_model(o, sea_place);
    vec3 ray = vec3(dot(d, o.x), dot(d, o.y), dot(d, o.z));
    hull_maps h = hull_maps(place_texel(i, 4), layer,
                            layer + textureSize(object_hulls, 0).z / 2, fade.w, ray.y < 0.0 ? -1.0 : 1.0);
    float way = hull_distance(h, p, ray);
    if (way < 0.0) {
        return leaving;
    }
    vec3 m = hull_normal(h, p + way * ray);
    vec3 normal = o.x * m.x + o.y * m.y + o.z * m.z;
    float deep = -way * d.z;
    vec3 beam = vec3(-to.xy * eta, -sqrt(1.0 - eta * eta * (1.0 - to.z * to.z))); // downward
    float lit = sun_on_sea(sea_place + way * d + (deep / beam.z) * beam);
    vec3 direct = beam_there(PEL_LIGHT_FIRST) * max(to.z, 0.0) * (1.0 - facet_reflectance(max(to.z, 0.0))) *
                  (max(-dot(beam, normal), 0.0) / -beam.z * lit) * exp(fade.rgb * (deep / beam.z));
    // Of uniform light from the cone into which the sky is refracted; 6 %
    // too little on a wall.
    float from_above = abs(normal.z) < eta ? (normal.z + eta) * (normal.z + eta) / (4.0 * eta) : max(normal.z, 0.0);
    vec3 diffuse = 0.93 * skies[PEL_LIGHT_FIRST].rgb * from_above * exp(-1.2 * fade.rgb * deep);
    vec3 upward = PI * PEL_WATER_INDEX * PEL_WATER_INDEX * leaving * (0.5 - 0.5 * normal.z);
    vec3 hull = paint.rgb * (1.0 / PI) * (direct + diffuse + upward) * (eta * eta) * exp(-fade.rgb * way);
    leaving = leaving * (1.0 - exp(-fade.rgb * way * (1.0 + d.z / beam.z))) + hull;
    return leaving;
}

// Of the facet n.
vec3 leaving_with_hulls(vec3 v, vec3 n, vec3 to, vec3 leaving)
{
    const float eta = 1.0 / PEL_WATER_INDEX;
    float facing = max(dot(n, v), 1e-3);
    vec3 d = n * (eta * facing - sqrt(1.0 - eta * eta * (1.0 - facing * facing))) - eta * v;
    EACH_OBJECT(objects_near.z) {
        leaving = leaving_with_hull(findLSB(rest), d, to, leaving);
    }
    return leaving;
}
