// Hulls under the surface, seen through it.

// Height of a hull's lowest surface over a place of its plan; none, or above the
// waterline: 0.
float hull_bottom(vec4 plan, float layer, vec2 at)
{
    vec2 texel = clamp((at - plan.xy) * plan.zw, 0.0, 1.0) * vec2(PEL_HULL_LENGTH, PEL_HULL_BREADTH);
    ivec2 i = min(ivec2(texel), ivec2(PEL_HULL_LENGTH - 1, PEL_HULL_BREADTH - 1));
    return min(texelFetch(object_hulls, ivec3(i, int(layer)), 0).r, 0.0);
}

// Where the ray d from p, in the model's axes, goes into the hull; negative:
// nowhere. A march over its plan, then halving.
float hull_distance(vec4 plan, float layer, float low, vec3 p, vec3 d)
{
    const int STEPS = 10;
    vec2 inverse = 1.0 / mix(vec2(1e-6), d.xy, greaterThan(abs(d.xy), vec2(1e-6)));
    vec2 a = (plan.xy - p.xy) * inverse;
    vec2 b = (plan.xy + 1.0 / plan.zw - p.xy) * inverse;
    vec2 first = min(a, b);
    vec2 last = max(a, b);
    float from = max(max(first.x, first.y), 0.0);
    float to = min(min(last.x, last.y), (low - p.z) / min(d.z, -1e-3));
    if (to <= from) {
        return -1.0;
    }
    float step_ = (to - from) / float(STEPS);
    float t = from;
    for (int i = 0; i < STEPS; i++) {
        vec3 q = p + (t + step_) * d;
        if (q.z > hull_bottom(plan, layer, q.xy)) {
            break;
        }
        t += step_;
    }
    if (t >= to - 0.5 * step_) {
        return -1.0;
    }
    for (int i = 0; i < 5; i++) {
        step_ *= 0.5;
        vec3 q = p + (t + step_) * d;
        t += q.z > hull_bottom(plan, layer, q.xy) ? 0.0 : step_;
    }
    return t + step_;
}

// Outward, in the model's axes.
vec3 hull_normal(vec4 plan, float layer, vec2 at)
{
    vec2 apart = 2.0 / (plan.zw * vec2(PEL_HULL_LENGTH, PEL_HULL_BREADTH));
    vec2 x = vec2(apart.x, 0.0);
    vec2 y = vec2(0.0, apart.y);
    vec2 slope = vec2(hull_bottom(plan, layer, at + x) - hull_bottom(plan, layer, at - x),
                      hull_bottom(plan, layer, at + y) - hull_bottom(plan, layer, at - y)) / (2.0 * apart);
    return normalize(vec3(slope, -1.0));
}

// `leaving` where hulls stand in the water behind the facet n: what is left of
// the water's light, which gathers over the way to them, and theirs, matt in
// what is left of the light at their depth. Twin of none; the reference is
// tests/validate/shiptrace.
vec3 leaving_with_hulls(vec3 v, vec3 n, vec3 to, vec3 leaving)
{
    const float eta = 1.0 / PEL_WATER_INDEX;
    float facing = max(dot(n, v), 1e-3);
    vec3 d = n * (eta * facing - sqrt(1.0 - eta * eta * (1.0 - facing * facing))) - eta * v;
    for (int left = objects_near.z; left != 0; left &= left - 1) {
        int i = findLSB(left);
        int first = i * PEL_OBJECT_PLACE_TEXELS;
        vec4 box = texelFetch(object_places, first + 17); // on the lattice
        if (any(lessThan(sea_pixel, box.xy)) || any(greaterThan(sea_pixel, box.zw))) {
            continue;
        }
        vec4 fade = texelFetch(object_places, first + 15); // 1/m; the hull's lowest point
        vec4 paint = texelFetch(object_places, first + 16);
        vec4 plan = texelFetch(object_places, first + 4);
        float layer = object_facts(i).z;
        placed o = placed_object(i);
        vec3 p = into_model(o, sea_place);
        float way = hull_distance(plan, layer, fade.w, p, vec3(dot(d, o.x), dot(d, o.y), dot(d, o.z)));
        if (way < 0.0) {
            continue;
        }
        vec3 q = p + way * vec3(dot(d, o.x), dot(d, o.y), dot(d, o.z));
        vec3 m = hull_normal(plan, layer, q.xy);
        vec3 normal = o.x * m.x + o.y * m.y + o.z * m.z;
        float deep = -way * d.z;
        vec3 beam = vec3(-to.xy * eta, -sqrt(1.0 - eta * eta * (1.0 - to.z * to.z))); // downward
        vec3 direct = beams[PEL_LIGHT_SUN].rgb * max(to.z, 0.0) * (1.0 - facet_reflectance(max(to.z, 0.0))) *
                      (max(-dot(beam, normal), 0.0) / -beam.z * sea_lit) * exp(fade.rgb * (deep / beam.z));
        vec3 diffuse = 0.93 * skies[PEL_LIGHT_SUN].rgb * (0.5 + 0.5 * normal.z) * exp(-1.2 * fade.rgb * deep);
        vec3 upward = PI * PEL_WATER_INDEX * PEL_WATER_INDEX * leaving * (0.5 - 0.5 * normal.z);
        vec3 hull = paint.rgb * (1.0 / PI) * (direct + diffuse + upward) * (eta * eta) * exp(-fade.rgb * way);
        leaving = leaving * (1.0 - exp(-fade.rgb * way * (1.0 + d.z / beam.z))) + hull;
    }
    return leaving;
}
