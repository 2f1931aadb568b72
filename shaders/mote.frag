#version 450 core
// What a particle in the water covers of a pixel, blended over what is behind.
#define PEL_UNDER
#include "lib/blocks.h"
#include "lib/sky.glsl"
#include "lib/ray.glsl"
#ifdef PEL_OBJECTS
#include "lib/model.glsl"
layout(binding = PEL_UNIT_OBJECTS) uniform usampler2D objects;
#endif
#include "lib/underlens.glsl"

layout(binding = PEL_UNIT_UNDER_FOUND) uniform sampler2D under_found; // of under_find.frag
flat in vec4 disc, light_of;
layout(location = 0) out vec4 light;

#ifdef PEL_OBJECTS
// How far away the nearest triangle of a pixel is, by its plane.
float hull_distance(uvec2 number, vec3 sight)
{
    uvec4 corners = texelFetch(object_triangles, int(number.y));
    placed o = placed_object(int(number.x) - 1);
    vec3 a = object_point(o, texelFetch(object_vertices, int(corners.x) * PEL_OBJECT_VERTEX_TEXELS).xyz);
    vec3 b = object_point(o, texelFetch(object_vertices, int(corners.y) * PEL_OBJECT_VERTEX_TEXELS).xyz);
    vec3 c = object_point(o, texelFetch(object_vertices, int(corners.z) * PEL_OBJECT_VERTEX_TEXELS).xyz);
    vec3 n = cross(b - a, c - a);
    float along = dot(n, sight);
    return along == 0.0 ? 0.0 : dot(n, a) / along;
}
#endif

void main()
{
    ivec2 at = ivec2(gl_FragCoord.xy);
    vec3 sight = normalize(pixel_ray(lattice(at)));
    float behind = texelFetch(under_found, at, 0).x;
#ifdef PEL_OBJECTS
    uvec2 number = texelFetch(objects, at, 0).rg;
    behind = number.x != 0u ? min(behind, hull_distance(number, sight)) : behind;
#endif
    if (light_of.w > behind) {
        discard;
    }
    vec2 wet = under_cover(sight);
    float off = length(lattice(at) - disc.xy);
    float covers = min(disc.w * clamp((disc.z + 0.7 - off) * (1.0 / 1.4), 0.0, 1.0), 1.0) * wet.x * (1.0 - wet.y);
    light = vec4(light_of.rgb * covers, covers);
}
