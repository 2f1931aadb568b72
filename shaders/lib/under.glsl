// What an eye in the water sees in a pixel: the surface from below, the bottom,
// hulls, and the water before them.

#include "lib/underlens.glsl"
#include "lib/underlamps.glsl"

layout(binding = PEL_UNIT_SHAFTS) uniform sampler2DArray shafts;

// Light by its way.
struct under_light {
    vec3 sun;    // of the lights, through the surface or from hulls
    vec3 sky;    // likewise, of the sky
    vec3 once;   // scattered once in the water
    vec3 more;   // more often
    vec3 bottom;
};

under_light under_sum(under_light a, under_light b, vec3 by)
{
    return under_light(a.sun + by * b.sun, a.sky + by * b.sky, a.once + by * b.once, a.more + by * b.more,
                       a.bottom + by * b.bottom);
}

vec3 under_radiance(under_light l)
{
    return l.sun + l.sky + l.once + l.more + l.bottom;
}

const under_light UNDER_DARK =
    under_light(vec3(0.0), vec3(0.0), vec3(0.0), vec3(0.0), vec3(0.0));

// What waves focus at a place, from the eye's nadir, less its mean.
float under_focus(vec2 place, float z)
{
    vec3 to = under_beams[PEL_LIGHT_FIRST].xyz;
    vec2 off = place + to.xy * ((z - max(under_eye.x, 0.0)) / to.z);
    vec2 u = sqrt(min(abs(off) / PEL_SHAFT_REACH, vec2(1.0))) * sign(off);
    float seen = 1.0 - smoothstep(0.8, 0.96, max(abs(u.x), abs(u.y)));
    float level = clamp(log2(max(z, 1e-3) / PEL_SHAFT_FIRST) * PEL_SHAFT_STEPS, 0.0, float(PEL_SHAFT_DEPTHS) - 1.001);
    float below = floor(level);
    vec2 uv = 0.5 + 0.5 * u;
    vec3 upper = vec3(uv, below), lower = vec3(uv, below + 1.0);
    const float MEAN = float(PEL_SHAFT_MEAN);
    vec2 bright = vec2(textureLod(shafts, upper, 0.0).r, textureLod(shafts, lower, 0.0).r);
    vec2 mean = vec2(textureLod(shafts, upper, MEAN).r, textureLod(shafts, lower, MEAN).r);
    vec2 focus = bright / max(mean, vec2(0.1)) - 1.0;
    return under_lens.w * seen * mix(focus.x, focus.y, level - below) * clamp(z / PEL_SHAFT_FIRST, 0.0, 1.0);
}

// What the shafts of the first light add to its even light on the way: the
// water is cut where a quarter, a half … of what they add comes from.
vec3 under_shafts(vec3 sight, float s)
{
    const int STEPS = 24;
    vec4 to = under_beams[PEL_LIGHT_FIRST];
    vec3 rate = under_scaled.rgb * (1.0 - sight.z / to.z);
    float far = min(s, min(4.0 / max(under_scaled.g, 1e-3), 1.2 * PEL_SHAFT_REACH));
    vec3 sum = vec3(0.0);
    float from = 0.0;
    for (int i = 0; i < STEPS; i++) {
        float x = float(i + 1) / float(STEPS);
        float end = far * x * x;
        float at = 0.5 * (from + end);
        vec3 weight = exp(-rate * at) * (end - from);
        sum += weight * under_focus(at * sight.xy, under_depth() - at * sight.z);
        from = end;
    }
    return sum * under_beam(PEL_LIGHT_FIRST, under_depth()) * under_scatter.rgb * under_phase(dot(to.xyz, sight));
}

// Of what lies at the surface, s m away: the sight along which it is as far in
// a level sea. Waves raise it for near ones and lower it.
vec3 under_levelled(vec3 sight, float s)
{
    float up_ = clamp(max(under_depth(), 0.01) / max(s, 1e-3), 1e-3, 1.0);
    vec2 level = sight.xy * inversesqrt(max(dot(sight.xy, sight.xy), 1e-9));
    return vec3(level * sqrt(1.0 - up_ * up_), up_);
}

// From the depth z the water before what is s m away; with what shafts and lamps
// add.
under_light under_water(vec3 sight, float z, float s, under_light beyond, vec3 shafts_, vec3 lamps)
{
    under_light l = under_sum(UNDER_DARK, beyond, under_left(s));
    l.more += water_between(sight, z, s);
    l.once += max(suns_between(sight, z, s) + shafts_, vec3(0.0)) + lamps;
    return l;
}

vec3 lamps_on_face_below(vec3 place, vec3 n)
{
#ifdef PEL_LAMPS_BELOW
    return under_lamps_on_face(place, n);
#else
    return vec3(0.0);
#endif
}

// Light that falls on a face there, over pi; of the lights' beams, and the rest.
void under_falling(vec3 n, float z, float focus, vec3 lamps, out vec3 direct, out vec3 around)
{
    direct = vec3(0.0);
    for (int i = 0; i < PEL_LIT; i++) {
        vec3 one = under_beam(i, z) * (max(dot(n, under_beams[i].xyz), 0.0) / PI);
        direct += i == PEL_LIGHT_FIRST ? one * (1.0 + focus) : one;
    }
    around = (under_diffuse(n, z) + lamps) / PI;
}

vec3 under_bottom_normal(vec2 place, float footprint)
{
#ifdef PEL_SEABED
    return seabed_normal(bed_node(place), footprint);
#else
    return vec3(0.0, 0.0, 1.0);
#endif
}

// The bottom of a normal n at a depth.
under_light under_bottom(vec3 n, float z, float focus, vec3 lamps)
{
    vec3 direct, around;
    under_falling(n, z, focus, lamps, direct, around);
    under_light l = UNDER_DARK;
    l.bottom = under_ground.rgb * (direct + around);
    return l;
}

// A light's beam refracted by the facets of a surface of mean normal n, to an
// eye below that looks along `sight` (Walter et al. 2007, eq. 21).
vec3 under_glitter(int i, vec3 sight, vec3 n, vec3 tx, vec3 ty, vec2 variance)
{
    float index = sqrt(refraction.g);
    vec3 to = lights[i].direction.xyz;
    vec3 sum = index * sight - to;
    float size2 = dot(sum, sum);
    vec3 f = sum * inversesqrt(max(size2, 1e-12));
    float up_ = dot(f, n);
    float ci = dot(to, f), co = dot(sight, f);
    if (up_ < 0.05 || ci <= 0.0 || co <= 0.0) {
        return vec3(0.0);
    }
    vec2 slope = vec2(dot(f, tx), dot(f, ty)) / up_;
    float disc = lights[i].direction.w * (1.0 / (1.34 * 0.254));
    float density = slope_density(slope, variance + 0.25 * disc * disc) / (up_ * up_ * up_ * up_);
    return beam_there(i) * (1.0 - facet_reflectance(ci)) *
           (ci * co * index * index * density / (max(dot(sight, n), 0.05) * size2));
}

struct under_surface_seen {
    under_light light;
    vec3 mirrored; // mean share that the surface mirrors
    vec3 away;     // mean direction into which, unit, down
};

// The surface from below, `s` m away at `place` from the eye: n its mean normal
// in the pixel, variance the rest of its slopes. Light is refracted and mirrored
// by facets of that variance; the forward peak of what the water scatters on
// the way blurs it as more variance would. Without what it mirrors.
under_surface_seen under_surface(vec3 sight, vec3 place, float s, vec3 n, vec2 variance)
{
    const float STEP = 0.8;
    float index = sqrt(refraction.g);
    float peak = 1.0 - exp(-(under_full.g - under_scaled.g) * s);
    vec2 wide = max(variance, vec2(1e-6)) + under_drift.w * peak;
    vec3 along = vec3(wind.xy, 0.0);
    vec3 tx = normalize(along - n * dot(n, along));
    vec3 ty = cross(n, tx);
    vec2 level = vec2(dot(sight, tx), dot(sight, ty));
    float sine = length(level);
    vec2 toward = sine > 1e-4 ? level / sine : vec2(1.0, 0.0);
    vec2 conjugate = wide * toward;
    float s2 = dot(conjugate, toward);
    vec2 axis = conjugate * inversesqrt(s2);
    float cross2 = wide.x * wide.y / s2;
    float deviation = sqrt(s2);
    float all = 0.0;
    vec3 share = vec3(0.0), sky = vec3(0.0), away = vec3(0.0);
    const float TEXELS = 64.0 / PEL_REFLECTION_HALF_WIDTH;
    // As many as a uniform says: written out, software devices compile for long.
    int facets = int(under_drift.y);
    for (int i = 0; i < facets; i++) {
        float y = STEP * (float(i) - 0.5 * float(facets - 1));
        vec3 f = tx * (axis.x * y) + ty * (axis.y * y) + n;
        f *= inversesqrt(dot(f, f) + cross2);
        float c = dot(f, sight);
        float weight = exp(-0.5 * y * y) * max(c, 0.0);
        float k = 1.0 - refraction.g * (1.0 - c * c);
        float cosine = sqrt(max(k, 0.0));
        vec3 mirror = k > 0.0 ? facet_reflectance(cosine) : vec3(1.0);
        vec3 out_ = normalize(index * sight + (cosine - index * c) * f);
        float inverse = 1.0 / (1.0 + max(out_.z, 0.0));
        float bend = max(abs(index * c - cosine), 0.2);
        float texels = TEXELS * inverse * bend * max(sqrt(cross2), 0.5 * STEP * deviation);
        vec2 uv = out_.xy * inverse * (0.5 / PEL_REFLECTION_HALF_WIDTH) + 0.5;
        vec3 there = textureLod(reflection_map, uv, log2(max(texels, 1.0))).rgb;
        all += weight;
        sky += weight * (1.0 - mirror) * there;
        share += weight * mirror;
        away += weight * mirror.g * (sight - 2.0 * c * f);
    }
    under_surface_seen seen;
    float one = 1.0 / max(all, 1e-6);
    seen.mirrored = all > 1e-6 ? share * one : vec3(1.0);
    seen.light = UNDER_DARK;
    seen.light.sky = sky * (one * refraction.g);
#if defined(PEL_CLOUDS) || defined(PEL_FOG)
    float evenly[PEL_LIT] = lights_leave;
    veil_lights(place.xy, 0.0, 0.2 * s);
#endif
    for (int i = 0; i < PEL_LIT; i++) {
        vec3 sharp = under_glitter(i, sight, n, tx, ty, variance);
        vec3 blurred = under_glitter(i, sight, n, tx, ty, variance + under_drift.w);
        seen.light.sun += mix(sharp, blurred, peak);
    }
#if defined(PEL_CLOUDS) || defined(PEL_FOG)
    lights_leave = evenly;
#endif
    seen.away = normalize(away + vec3(0.0, 0.0, -1e-6));
    seen.away.z = min(seen.away.z, -0.02);
    seen.away = normalize(seen.away);
    return seen;
}

#if defined(PEL_OBJECTS)
// A hull under water, lit by the water's light.
under_light under_object(vec3 ray, uvec2 number, vec3 sight, out float s, out object_point_seen point, out vec3 matt)
{
    point = cut_object(vec3(0.0), ray, number);
    s = length(point.place);
    vec4 paint = texelFetch(object_materials, int(point.material) * PEL_OBJECT_MATERIAL_TEXELS);
#ifdef PEL_TEXTURED
    vec4 finish = texelFetch(object_materials, int(point.material) * PEL_OBJECT_MATERIAL_TEXELS + 1);
    if (finish.w > 0.0) {
        float nv = max(dot(point.normal, -sight), 1e-3);
        paint.rgb = paint_at(finish.zw, point.uv, point.per_m * s * pixel.y * inversesqrt(nv)).rgb;
    }
#endif
    // Of metal what it mirrors is as even as the light around.
    matt = wet_reflectance(paint.rgb);
    float z = under_eye.x - point.place.z;
    int entity = int(number.x) - 1;
    placed o = placed_object(entity);
    float lit = lit_share(entity, from_object(o, point.place), point.normal) * lit_by_others(entity, point.place);
    vec3 direct, around;
    under_falling(point.normal, max(z, 0.0), under_focus(point.place.xy, z),
                  lamps_on_face_below(point.place, point.normal), direct, around);
    under_light l = UNDER_DARK;
    l.sun = matt * direct * lit;
    l.sky = matt * around;
    return l;
}
#endif
