// Shades a pixel of an object from the number of its triangle.
#include "lib/model.glsl"
#include "lib/shadow.glsl"
#include "lib/samples.glsl"
#include "lib/wet.glsl"
#include "lib/lampbeam.glsl"
#ifdef PEL_TEXTURED
#include "lib/paint.glsl"
#endif

layout(binding = PEL_UNIT_OBJECT_MATERIALS) uniform samplerBuffer object_materials;
layout(binding = PEL_UNIT_SURROUNDINGS) uniform sampler2D surrounding_map;

layout(binding = PEL_UNIT_OBJECTS) uniform usampler2D objects;
layout(binding = PEL_UNIT_OBJECT_COVER) uniform usampler2D object_cover;

struct object_point_seen {
    vec3 place;  // from the eye
    vec3 normal; // towards the eye
    float t;     // distance, in lengths of the ray
    vec4 open_;  // of openness
#ifdef PEL_TEXTURED
    vec2 uv;
    float per_m; // of uv
#endif
    uint material;
};

vec3 octahedral(vec2 e)
{
    vec3 n = vec3(e, 1.0 - abs(e.x) - abs(e.y));
    float fold = max(-n.z, 0.0);
    n.xy -= vec2(n.x >= 0.0 ? fold : -fold, n.y >= 0.0 ? fold : -fold);
    return normalize(n);
}

vec2 octahedral_place(vec3 n)
{
    vec2 e = n.xy / (abs(n.x) + abs(n.y) + abs(n.z));
    vec2 folded = (1.0 - abs(e.yx)) * vec2(e.x >= 0.0 ? 1.0 : -1.0, e.y >= 0.0 ? 1.0 : -1.0);
    return 0.5 + 0.5 * (n.z >= 0.0 ? e : folded);
}

// Of a vertex: shares of what comes from above and below that nothing of the
// model hides; reflectance that the rest meets there, by its share of all.
vec4 openness(float packed_)
{
    uint bits = floatBitsToUint(packed_);
    return vec4(vec3(uvec3(bits, bits >> 8u, bits >> 16u) & 255u) * (1.0 / 255.0), float((bits >> 24u) - 1u) * (1.0 / 125.0));
}

// `from`: where the ray begins, from the eye.
object_point_seen cut_object(vec3 from, vec3 ray, uvec2 seen)
{
    placed o = placed_object(int(seen.x) - 1);
    uvec4 corners = texelFetch(object_triangles, int(seen.y));
    vec3 p[3];
    vec4 texels[3];
    vec3 normals[3];
    vec2 uvs[3];
    vec4 open_[3];
    for (int i = 0; i < 3; i++) {
        int first = int(corners[i]) * PEL_OBJECT_VERTEX_TEXELS;
        vec4 place = texelFetch(object_vertices, first);
        p[i] = object_point(o, place.xyz) - from;
        open_[i] = openness(place.w);
        vec4 more = texelFetch(object_vertices, first + 1);
        normals[i] = octahedral(more.xy);
        uvs[i] = more.zw;
    }
    vec3 weight = vec3(dot(ray, cross(p[1], p[2] - p[1])), dot(ray, cross(p[2], p[0] - p[2])),
                       dot(ray, cross(p[0], p[1] - p[0])));
    float sum = weight.x + weight.y + weight.z;
    weight = clamp(sum == 0.0 ? vec3(1.0 / 3.0) : weight / sum, 0.0, 1.0);
    weight /= weight.x + weight.y + weight.z;
    object_point_seen s;
    s.place = weight.x * p[0] + weight.y * p[1] + weight.z * p[2];
    s.t = -dot(s.place, back.xyz);
    s.open_ = weight.x * open_[0] + weight.y * open_[1] + weight.z * open_[2];
    vec3 n = weight.x * normals[0] + weight.y * normals[1] + weight.z * normals[2];
    n = normalize(o.x * n.x + o.y * n.y + o.z * n.z);
    // A wall of one skin shows both sides.
    vec3 face = cross(p[1] - p[0], p[2] - p[0]);
    face *= dot(face, ray) > 0.0 ? -1.0 : 1.0;
    s.normal = dot(n, face) < 0.0 ? -n : n;
    s.material = corners.w;
#ifdef PEL_TEXTURED
    vec2 along = uvs[1] - uvs[0];
    vec2 across = uvs[2] - uvs[0];
    s.uv = uvs[0] + weight.y * along + weight.z * across;
    s.per_m = sqrt(abs(along.x * across.y - along.y * across.x) * inversesqrt(max(dot(face, face), 1e-20)));
#endif
    return s;
}

// Light that falls on a surface from all around, over pi, and from below the
// horizon alone.
vec3 light_by_normal(int first, vec3 n)
{
    return ambient[first].rgb + ambient[first + 1].rgb * n.y + ambient[first + 2].rgb * n.z +
           ambient[first + 3].rgb * n.x + ambient[first + 4].rgb * (n.x * n.y) + ambient[first + 5].rgb * (n.y * n.z) +
           ambient[first + 6].rgb * (3.0 * n.z * n.z - 1.0) + ambient[first + 7].rgb * (n.x * n.z) +
           ambient[first + 8].rgb * (n.x * n.x - n.y * n.y);
}

// The same where the model's own form hides a part: there is its paint instead,
// below the light of a deck, above that of walls to all sides. `lit`: share of
// the Sun on what lies before the surface.
vec3 ambient_light(vec3 n, vec4 open_, float lit)
{
    vec3 all = max(light_by_normal(0, n), vec3(0.0));
    vec3 below = clamp(light_by_normal(PEL_SURROUNDINGS_TERMS, n), vec3(0.0), all);
    vec3 to = lights[PEL_LIGHT_FIRST].direction.xyz;
    vec3 sun = beam_there(PEL_LIGHT_FIRST) * (1.0 / PI);
    vec3 deck = ambient[0].rgb + ambient[2].rgb + 2.0 * ambient[6].rgb + sun * (max(to.z, 0.0) * lit);
    vec3 wall = ambient[0].rgb - ambient[6].rgb + sun * (sqrt(max(1.0 - to.z * to.z, 0.0)) * lit / PI);
    return open_.x * (all - below) + open_.y * below + open_.z * wall + open_.w * deck;
}

vec3 schlick(vec3 f0, float cosine)
{
    float m = 1.0 - cosine;
    float m2 = m * m;
    return f0 + (1.0 - f0) * (m2 * m2 * m);
}

// Microfacets of Walter et al. 2007 (GGX), Smith's shadow as Hammon 2017 has
// it, for a beam of irradiance 1.
vec3 gloss_of_light(vec3 f0, float alpha, vec3 n, vec3 v, vec3 to)
{
    vec3 h = normalize(v + to);
    float nl = max(dot(n, to), 0.0);
    float nv = max(dot(n, v), 1e-3);
    float nh = dot(n, h);
    float a2 = alpha * alpha;
    float d = nh * nh * (a2 - 1.0) + 1.0;
    float shadow = 0.5 / mix(2.0 * nl * nv, nl + nv, alpha);
    return schlick(f0, max(dot(v, h), 0.0)) * (a2 / (PI * d * d) * shadow * nl);
}

// What a rough surface reflects of its surroundings: share of f0 and of 1
// (Karis 2014's fit).
vec2 gloss_share(float rough, float nv)
{
    vec4 r = rough * vec4(-1.0, -0.0275, -0.572, 0.022) + vec4(1.0, 0.0425, 1.04, -0.04);
    float a = min(r.x * r.x, exp2(-9.28 * nv)) * r.x + r.y;
    return vec2(-1.04, 1.04) * a + r.zw;
}

struct object_lit {
    vec3 by_lights, by_sky, matt;
};

// What a point sends against the unit direction `dir`; `place`: of it, from the
// eye.
object_lit object_light(object_point_seen s, int entity, vec3 place, vec3 dir)
{
    placed o = placed_object(entity);
    vec3 d = from_object(o, place);
    vec4 paint = texelFetch(object_materials, int(s.material) * PEL_OBJECT_MATERIAL_TEXELS);
    vec4 finish = texelFetch(object_materials, int(s.material) * PEL_OBJECT_MATERIAL_TEXELS + 1);
    float metal = paint.w;
    float rough = max(finish.x, 0.05);
    vec3 n = s.normal;
    vec3 v = -dir;
    float nv = max(dot(n, v), 1e-3);
#ifdef PEL_TEXTURED
    if (finish.w > 0.0) {
        paint.rgb = paint_at(finish.zw, s.uv, s.per_m * length(place) * pixel.y * inversesqrt(nv)).rgb;
    }
#endif
    vec3 f0 = mix(vec3(0.04), paint.rgb, metal);
    vec3 matt = paint.rgb * (1.0 - metal);
    object_lit result = object_lit(vec3(0.0), vec3(0.0), matt);
#ifndef PEL_DRY_HULLS
    float deviation = place_texel(entity, 18).x; // negative: nothing washes over it
    float wet = deviation < 0.0 ? 0.0 : wet_share(dot(d, o.z), deviation);
    matt = mix(matt, wet_reflectance(matt), wet);
    rough = mix(rough, min(rough, PEL_WET_ROUGH), wet);
#endif
    float lit = lit_share(entity, d, n) * lit_by_others(entity, place);
#if defined(PEL_CLOUDS) || defined(PEL_FOG)
    veil_lights(place.xy, eye.x + place.z + 0.5 * dot(place.xy, place.xy) / planet.x, length(place) * pixel.y);
#endif
    for (int i = 0; i < PEL_LIT; i++) {
        vec3 to = lights[i].direction.xyz;
        vec3 beam = beam_there(i) * (i == PEL_LIGHT_FIRST ? lit : 1.0);
        result.by_lights +=
            beam * (matt * (max(dot(n, to), 0.0) / PI) + gloss_of_light(f0, rough * rough, n, v, to));
    }
#ifdef PEL_LAMPS
    // Nothing but the face itself is in their way.
    for (int i = 0; i < lamps_known(); i++) {
        vec3 to;
        vec3 beam = lamp_falling(i, place, to);
        result.by_lights +=
            beam * (matt * (max(dot(n, to), 0.0) / PI) + gloss_of_light(f0, rough * rough, n, v, to));
    }
#endif
    vec2 share = gloss_share(rough, nv);
    float level = log2(max(rough * rough * float(PEL_SURROUNDINGS_SIZE) * 0.5, 1.0));
    vec3 away = reflect(dir, n);
    vec3 mirrored = textureLod(surrounding_map, octahedral_place(away), level).rgb * dusk.y;
    mirrored *= mix(s.open_.y, s.open_.x, clamp(0.5 + 2.0 * away.z, 0.0, 1.0));
    lit *= step(0.0, dot(n, lights[PEL_LIGHT_FIRST].direction.xyz));
    result.by_sky = matt * ambient_light(n, s.open_, lit) + (f0 * share.x + share.y) * mirrored;
    return result;
}

shaded shade_object(vec3 ray, uvec2 seen)
{
    float ray_length = length(ray);
    vec3 dir = ray / ray_length;
    object_point_seen s = cut_object(vec3(0.0), ray, seen);
    int entity = int(seen.x) - 1;
    object_lit light = object_light(s, entity, s.place, dir);
    float range = s.t * ray_length;
    vec3 air;
    vec3 through = haze(dir, range, air);
    shaded result = only_light((light.by_lights + light.by_sky) * through + air);
#ifdef PEL_LAYERS
    result.depth = range;
    result.normal = s.normal;
    vec4 facts = object_facts(entity);
    result.id = facts.x + 1.0;
    result.class_ = facts.y + 1.0;
    result.albedo = light.matt;
    result.sun = light.by_lights * through;
    result.sky = light.by_sky * through;
    result.air = air;
#endif
    return result;
}

// Whether the object is one that no land hides.
bool object_in_sight(vec3 ray, uvec2 seen)
{
    if (seen.x == 0u) {
        return false;
    }
#ifdef PEL_LAND
    float ray_length = length(ray);
    float range = cut_object(vec3(0.0), ray, seen).t * ray_length;
    return seabed_distance(ray / ray_length, range) < 0.0;
#else
    return true;
#endif
}

// The light of a pixel's samples that show objects, each triangle shaded once
// where its samples lie, and their share of the pixel.
shaded shade_samples(ivec2 at, out float cover)
{
    const float SHARE = 1.0 / float(PEL_SAMPLES);
    shaded sum = only_light(vec3(0.0));
    cover = 0.0;
    uint left = texelFetch(object_cover, at, 0).r;
    // Software devices turn once in any loop, so it asks at its end.
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
        float weight = object_in_sight(ray, seen) ? SHARE * place.z : 0.0;
        add_light(sum, shade_object(ray, seen), weight);
        cover += weight;
    } while (left != 0u);
    return sum;
}
