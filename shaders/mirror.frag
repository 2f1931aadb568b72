#version 450 core
// The light of an object in the mirrored view, and that it is there.
#include "lib/blocks.h"
#include "lib/sky.glsl"
#include "lib/clouds.glsl"
#include "lib/fog.glsl"
#include "lib/beam.glsl"
#include "lib/ray.glsl"
#include "lib/water.glsl"
#include "lib/shaded.glsl"
#include "lib/haze.glsl"
// The view shows more of a hull below its waterline than waves let be seen:
// wet, that would count as band.
#define PEL_DRY_HULLS
#include "lib/objects.glsl"

layout(location = 0) out vec4 light_out;
layout(location = 1) out vec2 away_out;

void main()
{
    uvec2 seen = texelFetch(objects, ivec2(gl_FragCoord.xy), 0).rg;
    int entity = int(seen.x) - 1;
    int first = entity * PEL_OBJECT_PLACE_TEXELS + 8;
    vec3 forward = texelFetch(object_places, first).xyz;
    vec4 across = texelFetch(object_places, first + 1);
    vec3 upward = texelFetch(object_places, first + 2).xyz;
    vec4 window_ = texelFetch(object_places, first + 3);
    vec2 tangents = window_.xy + gl_FragCoord.xy / (window_.zw * vec2(PEL_MIRROR_WIDTH, PEL_MIRROR_HEIGHT));
    vec3 way = forward + tangents.x * across.xyz + tangents.y * upward;
    vec3 from = vec3(0.0, 0.0, across.w);
    object_point_seen s = cut_object(from, way, seen);
    object_lit light = object_light(s, entity, s.place + from, normalize(way));
    light_out = vec4(min((light.by_lights + light.by_sky) * dusk.x, vec3(6e4)), 1.0);
    // Along the view's axis, from the object's middle.
    away_out = vec2(dot(s.place, forward) - texelFetch(object_places, first + 6).x, 1.0);
}
