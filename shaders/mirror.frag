#version 450 core
// The light of an object in the mirrored view, and that it is there.
#include "lib/blocks.h"
#include "lib/sky.glsl"
#include "lib/ray.glsl"
#include "lib/water.glsl"
#include "lib/shaded.glsl"
#include "lib/haze.glsl"
#include "lib/objects.glsl"

in vec3 way;
flat in uvec2 number;
in float away;
layout(location = 0) out vec4 light_out;
layout(location = 1) out vec2 away_out;

void main()
{
    int entity = int(number.x) - 1;
    vec3 from = vec3(0.0, 0.0, texelFetch(object_places, entity * PEL_OBJECT_PLACE_TEXELS + 9).w);
    object_point_seen s = cut_object(from, way, number);
    object_lit light = object_light(s, entity, s.place + from, normalize(way));
    light_out = vec4(min(light.by_lights + light.by_sky, vec3(6e4)), 1.0);
    away_out = vec2(away, 1.0);
}
