#version 450 core
// An entity as its Sun sees it.
#include "lib/blocks.h"
#include "lib/model.glsl"

layout(location = 0) uniform ivec2 drawn; // entity, first triangle

#ifdef PEL_HOLES
out vec2 painted_at;
flat out uint material;
#endif

void main()
{
    uint corner = texelFetch(object_triangles, drawn.y + gl_VertexID / 3)[gl_VertexID % 3];
    placed o = placed_object(drawn.x);
    vec3 p = texelFetch(object_vertices, int(corner) * PEL_OBJECT_VERTEX_TEXELS).xyz;
    vec4 d = vec4(o.x * p.x + o.y * p.y + o.z * p.z, 1.0);
    int first = drawn.x * PEL_OBJECT_PLACE_TEXELS + 5;
    vec3 at = vec3(dot(texelFetch(object_places, first), d), dot(texelFetch(object_places, first + 1), d),
                   dot(texelFetch(object_places, first + 2), d));
#ifdef PEL_HOLES
    painted_at = texelFetch(object_vertices, int(corner) * PEL_OBJECT_VERTEX_TEXELS + 1).zw;
    material = texelFetch(object_triangles, drawn.y + gl_VertexID / 3).w;
#endif
    gl_Position = vec4(at.xy * 2.0 - 1.0, at.z, 1.0);
}
