// The light that leaves the water, from the maps that water_map.comp fills for
// the lights, their skies and the water of the frame.
//
// water_map is a texture array of pictures over the refracted line of sight
// (optics/watertable.h), one for each light, each part of its light and each
// depth: layer (light · PEL_WATER_LAYERS + part) · levels + level. Depths lie evenly
// on a logarithmic scale; `frame.water` has x the number of levels, y log2 of
// the first depth in m, z levels an octave. A flat sea has one level and any
// depth finds it:
//
//     vec3 light = (1 − F̄) · Σ leaving_water(i, water_place(v, n, dir_i), depth)
//
// mixes the two levels around a depth, and holds the first and the last beyond
// them. Over a height field lib/seabed.glsl reads them by itself.

layout(binding = PEL_UNIT_WATER) uniform sampler2DArray water_map;

const float WATER_TOTAL = 0.0; // parts, in the order of the layers
const float WATER_SINGLE = 1.0 + float(PEL_PART_SINGLE);
const float WATER_SECOND = 1.0 + float(PEL_PART_SECOND);
const float WATER_HIGHER = 1.0 + float(PEL_PART_HIGHER);
const float WATER_BOTTOM = 1.0 + float(PEL_PART_BOTTOM);

struct water_light {
    vec3 single, second, higher, bottom;
};

// Layer of a part of a light, at the first depth.
float water_layer(int light, float part)
{
    return (float(light * PEL_WATER_LAYERS) + part) * water.x;
}

// Where on the maps of a light the line of sight towards v lies that leaves the
// water through a facet n: refracted there, the part of it along the surface.
vec2 water_place(vec3 v, vec3 n, vec3 light_dir)
{
    float facing = max(dot(n, v), 0.0);
    const float eta = 1.0 / PEL_WATER_INDEX;
    vec2 line = n.xy * (eta * facing - sqrt(1.0 - eta * eta * (1.0 - facing * facing))) - eta * v.xy;
    float sine = length(line);
    float across = length(light_dir.xy) * sine;
    float cosine = across > 1e-6 ? dot(line, light_dir.xy) / across : 0.0;
    vec2 size = vec2(textureSize(water_map, 0).xy);
    vec2 place = clamp(vec2(0.5 + 0.5 * cosine, PEL_WATER_INDEX * sine), 0.0, 1.0);
    return (0.5 + place * (size - 1.0)) / size;
}

vec3 water_part(int light, vec2 place, float part, float depth)
{
    float first = water_layer(light, part);
    if (water.x < 1.5) {
        return textureLod(water_map, vec3(place, first), 0.0).rgb;
    }
    float level = clamp((log2(max(depth, 1e-6)) - water.y) * water.z, 0.0, water.x - 1.0);
    float below = min(floor(level), water.x - 2.0);
    return mix(textureLod(water_map, vec3(place, first + below), 0.0).rgb,
               textureLod(water_map, vec3(place, first + below + 1.0), 0.0).rgb, level - below);
}

// At a place of the maps, over water of this depth, before the facet's own
// Fresnel factor: L_sea of Bruneton et al. 2010, eq. 28.
vec3 leaving_water(int light, vec2 place, float depth)
{
    return water_part(light, place, WATER_TOTAL, depth);
}

// leaving_water over the deepest water that there are maps for.
vec3 leaving_deep_water(int light, vec2 place)
{
    float layer = water_layer(light, WATER_TOTAL) + water.x - 1.0;
    return textureLod(water_map, vec3(place, layer), 0.0).rgb;
}

// leaving_water taken apart, times `factor`.
water_light water_parts(int light, vec2 place, float depth, vec3 factor)
{
    return water_light(factor * water_part(light, place, WATER_SINGLE, depth),
                       factor * water_part(light, place, WATER_SECOND, depth),
                       factor * water_part(light, place, WATER_HIGHER, depth),
                       factor * water_part(light, place, WATER_BOTTOM, depth));
}
