#version 450 core
// An entity as the eye's image in the sea sees it, what is above the sea.
#include "lib/blocks.h"
#include "lib/model.glsl"

layout(location = 0) uniform ivec2 drawn; // entity, first triangle

out gl_PerVertex {
    vec4 gl_Position;
    float gl_ClipDistance[1];
};
flat out uvec2 number;
#ifdef PEL_HOLES
out vec2 painted_at;
flat out uint material;
#endif

const float NEAR = 0.05;

void main()
{
    int triangle = drawn.y + gl_VertexID / 3;
    uint corner = texelFetch(object_triangles, triangle)[gl_VertexID % 3];
    placed o = placed_object(drawn.x);
    int first = drawn.x * PEL_OBJECT_PLACE_TEXELS + 8;
    vec3 model = texelFetch(object_vertices, int(corner) * PEL_OBJECT_VERTEX_TEXELS).xyz;
    vec4 forward = texelFetch(object_places, first);
    vec4 across = texelFetch(object_places, first + 1);
    vec4 upward = texelFetch(object_places, first + 2);
    vec4 window_ = texelFetch(object_places, first + 3);
    vec3 way = object_point(o, model) - vec3(0.0, 0.0, across.w);
    float depth = dot(way, forward.xyz);
    vec2 place = (vec2(dot(way, across.xyz), dot(way, upward.xyz)) - window_.xy * depth) * window_.zw;
    gl_Position = vec4(place * 2.0 - depth, NEAR, depth);
    float below = texelFetch(object_places, first + 8).w;
    gl_ClipDistance[0] = o.origin.z + o.x.z * model.x + o.y.z * model.y + o.z.z * model.z + below;
    number = uvec2(drawn.x + 1, triangle);
#ifdef PEL_HOLES
    painted_at = texelFetch(object_vertices, int(corner) * PEL_OBJECT_VERTEX_TEXELS + 1).zw;
    material = texelFetch(object_triangles, triangle).w;
#endif
}
