#version 450 core
// What surrounds an object on the sea, without the lights' discs: the sky of sea
// level above, the mean sea with all of its slopes below, as a map of directions
// (Praun and Hoppe 2003).
#include "lib/blocks.h"
#include "lib/sky.glsl"
#include "lib/clouds.glsl"
#include "lib/fog.glsl"
#include "lib/beam.glsl"
#include "lib/ross.glsl"
#include "lib/water.glsl"
#include "lib/shade.glsl"

layout(local_size_x = PEL_GROUP_SIDE, local_size_y = PEL_GROUP_SIDE) in;
layout(binding = PEL_UNIT_REFLECTION) uniform sampler2D reflection_map;
layout(binding = PEL_UNIT_SKY_TABLE) uniform sampler2DArray sky_table;
layout(binding = PEL_IMAGE_SURROUNDINGS, rgba16f) writeonly uniform image2D map;

vec3 mean_sea(vec3 dir)
{
    const vec3 n = vec3(0.0, 0.0, 1.0);
    const vec2 level = vec2(0.0);
    vec3 v = -dir;
    vec3 leaving = vec3(0.0);
    for (int i = 0; i < PEL_LIT; i++) {
        leaving += leaving_water(i, water_place(v, n, light_above(i, level)), 1e5);
    }
    lit parts = sea_radiance(reflection_map, v, level, n, wind.zw, leaving, vec3(0.0), NOT_PRESSED, 0.0);
    return parts.sun + parts.sky + parts.water;
}

vec3 above_sea(vec3 dir)
{
#if defined(PEL_CLOUDS) || defined(PEL_FOG)
    vec2 place = dir.xy / (1.0 + max(dir.z, 0.0)) * (0.5 / PEL_REFLECTION_HALF_WIDTH) + 0.5;
    return textureLod(reflection_map, place, 0.0).rgb;
#else
    return sky_light(sky_table, dir.xy, asin(min(dir.z, 1.0)));
#endif
}

void main()
{
#if defined(PEL_CLOUDS) || defined(PEL_FOG)
    veil_lights_evenly();
#endif
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    vec2 e = (vec2(at) + 0.5) * (2.0 / float(PEL_SURROUNDINGS_SIZE)) - 1.0;
    vec3 dir = vec3(e, 1.0 - abs(e.x) - abs(e.y));
    float fold = max(-dir.z, 0.0);
    dir.xy -= vec2(dir.x >= 0.0 ? fold : -fold, dir.y >= 0.0 ? fold : -fold);
    dir = normalize(dir);
    vec3 light = dir.z < 0.0 ? mean_sea(vec3(dir.xy, min(dir.z, -1e-3)))
                             : above_sea(dir);
    imageStore(map, at, vec4(min(light * dusk.x, vec3(6e4)), 1.0));
}
