#version 450 core
// What an eye in the water sees, over what one in the air would.
#define PEL_UNDER
#include "lib/blocks.h"
#include "lib/turns.glsl"
#ifdef PEL_AREAS
#include "lib/areas.glsl"
#endif
#include "lib/spline.glsl"
#ifdef PEL_SHORE
#include "lib/shore.glsl"
#endif
#ifdef PEL_FFT
#include "lib/cascades.glsl"
#else
#include "lib/waves.glsl"
#endif
#include "lib/filtered.glsl"
#include "lib/sky.glsl"
#include "lib/clouds.glsl"
#include "lib/fog.glsl"
#include "lib/beam.glsl"
#include "lib/variance.glsl"
#include "lib/ray.glsl"
#include "lib/ross.glsl"
#include "lib/water.glsl"
#include "lib/shaded.glsl"
#include "lib/haze.glsl"
#include "lib/seabed.glsl"
#include "lib/cut.glsl"
#include "lib/lamptowards.glsl"
#if defined(PEL_OBJECTS) || defined(PEL_ABOVE)
#include "lib/objects.glsl"
#endif
layout(binding = PEL_UNIT_REFLECTION) uniform sampler2D reflection_map;
#include "lib/underlight.glsl"
#include "lib/under.glsl"
#if defined(PEL_FOAM) || defined(PEL_WASH)
#include "lib/underfoam.glsl"
#endif
#include "lib/tone.glsl"
#include "lib/outputs.glsl"

layout(binding = PEL_UNIT_UNDER_FOUND) uniform sampler2D under_found; // of under_find.frag
layout(binding = PEL_UNIT_UNDER_NORMAL) uniform sampler2D under_normal; // of under_surface.frag
layout(binding = PEL_UNIT_UNDER_FOAM) uniform sampler2D under_foam;     // likewise
#if defined(PEL_FOAM) || defined(PEL_WASH)
layout(binding = PEL_UNIT_UNDER_BACK) uniform sampler2D under_back; // likewise
#endif
#ifdef PEL_LAMPS_BELOW
layout(binding = PEL_UNIT_UNDER_LAMPS) uniform sampler2D lamps_between; // of under_lamps.frag
layout(binding = PEL_UNIT_UNDER_LAMPS_ON) uniform sampler2D lamps_on;   // likewise
#endif

shaded as_shaded(under_light l)
{
    shaded result = only_light(under_radiance(l));
#ifdef PEL_LAYERS
    result.sun = l.sun;
    result.sky = l.sky;
    result.water = l.once + l.more + l.bottom;
#endif
#ifdef PEL_WATER_PARTS
    set_parts(result, water_light(l.once, vec3(0.0), l.more, l.bottom));
#endif
    return result;
}

// Of the surface in a pixel, as under_surface.frag has found it.
vec3 surface_normal(ivec2 at, out vec2 variance, out vec2 foam)
{
    vec4 normal = texelFetch(under_normal, at, 0), rest = texelFetch(under_foam, at, 0);
    variance = vec2(normal.w, rest.x);
    foam = rest.yz;
    return normal.xyz;
}

#ifdef PEL_ABOVE
layout(binding = PEL_UNIT_UNDER_ABOVE) uniform usampler2D objects_above; // of under_above.vert

// What a thing above the surface adds to the sky in whose place it is seen: where
// a level surface shows light of the direction that the waves here refract.
vec3 under_above(ivec2 at, vec3 ray, vec3 sight)
{
    vec4 found = texelFetch(under_found, at, 0);
    if (found.y != PEL_UNDER_SURFACE) {
        return vec3(0.0);
    }
    float s = found.x, index = sqrt(refraction.g);
    vec2 variance, foam;
    vec3 n = surface_normal(at, variance, foam);
    float c = dot(n, sight);
    float k = 1.0 - refraction.g * (1.0 - c * c);
    if (k <= 0.0) {
        return vec3(0.0);
    }
    float cosine = sqrt(k);
    vec3 out_ = normalize(index * sight + (cosine - index * c) * n);
    vec3 level = vec3(out_.xy / index, sqrt(1.0 - dot(out_.xy, out_.xy) / refraction.g));
    vec2 place = vec2(dot(level, right.xyz), -dot(level, up.xyz)) / (-dot(level, back.xyz) * pixel.xy) - pixel.zw;
    bool inside = dot(level, back.xyz) < 0.0 && all(greaterThanEqual(place, vec2(0.0))) &&
                  all(lessThan(place, size.xy));
    uvec2 number = texelFetch(objects_above, ivec2(inside ? place : vec2(0.0)), 0).rg;
    if (!inside || number.x == 0u || out_.z <= 0.0) {
        return vec3(0.0);
    }
    vec3 from = s * sight;
    object_point_seen point = cut_object(from, out_, number);
    object_lit light = object_light(point, int(number.x) - 1, from + point.place, out_);
    vec2 uv = out_.xy / (1.0 + out_.z) * (0.5 / PEL_REFLECTION_HALF_WIDTH) + 0.5;
    vec3 sky = textureLod(reflection_map, uv, 1.0).rgb;
    // Towards the window's edge the pixel's other facets show less of it.
    float shown = smoothstep(0.0, 0.3, k) * (1.0 - foam.x);
    return shown * under_left(s) * (1.0 - facet_reflectance(cosine)) * refraction.g * (light.by_lights + light.by_sky - sky);
}
#endif

#if !defined(PEL_OBJECTS) && !defined(PEL_ABOVE)
// Whatever lies there but objects, as under_find.frag has found it. The bottom that
// is seen and the one that the surface mirrors are shaded by the same text, and so
// is the water before each: software devices compile a second one for seconds.
shaded under_scene(ivec2 at, vec3 ray, vec3 sight)
{
    vec4 found = texelFetch(under_found, at, 0);
    float s = found.x;
    bool surface = found.y == PEL_UNDER_SURFACE, bottom = found.y == PEL_UNDER_BOTTOM;
    vec3 place = s * sight;
    shaded facts = only_light(vec3(0.0));
#ifdef PEL_LAMPS_BELOW
    vec3 between = texelFetch(lamps_between, at, 0).rgb, lamps = texelFetch(lamps_on, at, 0).rgb;
#else
    const vec3 between = vec3(0.0), lamps = vec3(0.0);
#endif
    under_surface_seen seen = under_surface_seen(UNDER_DARK, vec3(0.0), sight);
    vec2 variance = vec2(0.0), foam = vec2(0.0, 1.0);
    vec3 n = vec3(0.0, 0.0, 1.0), on_bottom = lamps;
    float z = under_eye.x - place.z, focus = found.z, mirrored_s = 0.0;
    if (surface) {
        vec3 facing = surface_normal(at, variance, foam);
        seen = under_surface(sight, place, s, facing, variance);
        z = found.w;
        mirrored_s = min(z / -seen.away.z, UNDER_FAR);
        vec2 there = place.xy + mirrored_s * seen.away.xy;
        focus = under_focus(there, z);
        on_bottom = lamps_on_face_below(vec3(there, under_eye.x - z), n);
#ifdef PEL_LAYERS
        facts.normal = facing;
        facts.fresnel = seen.mirrored.g;
        facts.slope_variance = variance;
        facts.foam = foam.x;
#endif
    } else if (bottom) {
        n = under_bottom_normal(place.xy, s * pixel.x * inversesqrt(max(-sight.z, 0.02)));
#ifdef PEL_LAYERS
        facts.normal = n;
        facts.albedo = under_ground.rgb;
#endif
    }
    under_light beyond = under_sum(UNDER_DARK, under_bottom(n, z, focus, on_bottom), vec3(surface || bottom ? 1.0 : 0.0));
    vec3 level = surface ? under_levelled(sight, s) : sight;
    vec3 shafts_ = under_shafts(level, s);
    // From what the surface mirrors to it, and from there to the eye.
    for (int way = surface ? 0 : 1; way < 2; way++) {
        bool last = way == 1;
        if (last && surface) {
            beyond = under_sum(seen.light, beyond, seen.mirrored);
#if defined(PEL_FOAM) || defined(PEL_WASH)
            cover_by_foam_below(foam, texelFetch(under_back, at, 0).rgb, lamps, beyond);
#endif
        }
        beyond = under_water(last ? level : seen.away, last ? under_depth() : 0.0, last ? s : mirrored_s, beyond,
                             last ? shafts_ : vec3(0.0), last ? between : vec3(0.0));
    }
    shaded result = as_shaded(beyond);
#ifdef PEL_LAYERS
    result.depth = surface || bottom ? s : uintBitsToFloat(0x7F800000u);
    result.normal = facts.normal;
    result.fresnel = facts.fresnel;
    result.slope_variance = facts.slope_variance;
    result.foam = facts.foam;
    result.albedo = facts.albedo;
#endif
    return result;
}
#elif defined(PEL_OBJECTS)
shaded under_hull(vec3 ray, uvec2 number, vec3 shafts_)
{
    vec3 sight = normalize(ray), matt;
    float s;
    object_point_seen point;
    under_light l = under_object(ray, number, sight, s, point, matt);
#ifdef PEL_LAMPS_BELOW
    vec3 between = under_lamps_between(sight, s);
#else
    const vec3 between = vec3(0.0);
#endif
    shaded result = as_shaded(under_water(sight, under_depth(), s, l, shafts_, between));
#ifdef PEL_LAYERS
    result.depth = s;
    result.normal = point.normal;
    vec4 facts = object_facts(int(number.x) - 1);
    result.id = facts.x + 1.0;
    result.class_ = facts.y + 1.0;
    result.albedo = matt;
#endif
    return result;
}

// As shade_samples of lib/objects.glsl.
shaded under_samples(ivec2 at, vec3 shafts_, out float cover)
{
    const float SHARE = 1.0 / float(PEL_SAMPLES);
    shaded sum = only_light(vec3(0.0));
    cover = 0.0;
    uint left = texelFetch(object_cover, at, 0).r;
    if (left != 0u) do {
        uvec2 seen = texelFetch(object_samples, at, findLSB(left)).rg;
        vec3 place = vec3(0.0);
        uint same = 0u;
        for (int i = 0; i < PEL_SAMPLES; i++) {
            bool alike = (left >> i & 1u) != 0u && texelFetch(object_samples, at, i).rg == seen;
            same |= alike ? 1u << i : 0u;
            place += alike ? vec3(sample_place(i), 1.0) : vec3(0.0);
        }
        left &= ~same;
        vec3 ray = pixel_ray(pixel.zw + vec2(at) + place.xy / place.z);
        seen.y &= ~SAMPLE_INNER;
        add_light(sum, under_hull(ray, seen, shafts_), SHARE * place.z);
        cover += SHARE * place.z;
    } while (left != 0u);
    return sum;
}
#endif

void main()
{
    ivec2 at = ivec2(gl_FragCoord.xy);
    vec3 ray = pixel_ray(lattice(at));
    float ray_length = length(ray);
    vec3 sight = ray / ray_length;
    vec2 wet = under_cover(sight);
    float cover = wet.x, rim = wet.y;
    veil_water();
    if (cover + rim < 1e-3) {
        discard;
    }
#ifdef PEL_OBJECTS
    uvec2 middle = texelFetch(objects, at, 0).rg;
    float hulls = 0.0;
    // Of all that a pixel shows, as far away as its first sample.
    uint any = texelFetch(object_cover, at, 0).r;
    uvec2 first = texelFetch(object_samples, at, findLSB(max(any, 1u))).rg;
    first.y &= ~SAMPLE_INNER;
    vec3 shafts_ = under_shafts(sight, any != 0u ? length(cut_object(vec3(0.0), ray, first).place) : 0.0);
    shaded s = under_samples(at, shafts_, hulls);
#ifdef PEL_LAYERS
    if (middle.x == 0u) {
        discard;
    }
    s = under_hull(ray, middle, shafts_);
#endif
    if (hulls == 0.0) {
        discard;
    }
#elif defined(PEL_ABOVE)
    const float hulls = 0.0;
    shaded s = only_light(under_above(at, ray, sight));
#else
    const float hulls = 1.0;
    shaded s = under_scene(at, ray, sight);
#endif
    float kept = under_lens.x > 0.5 ? cover * (1.0 - rim) : 1.0;
    s.radiance *= kept;
#ifdef PEL_LAYERS
    if (cover < 0.5) {
        discard;
    }
#endif
    // Blended by the last component where it is not 1.
    write_outputs(s, at, (under_lens.x > 0.5 ? max(cover, rim) : 1.0) * hulls);
}
