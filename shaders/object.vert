#version 450 core
// Rasterises an entity's triangles. What is kept is the entity's place in the
// list and the triangle's number: shading cuts it by the pixel's ray again, so
// that a pixel does not depend on how its picture was rasterised.
#include "lib/blocks.h"
#include "lib/model.glsl"

layout(location = 0) uniform ivec2 drawn;  // entity, first triangle
layout(location = 1) uniform vec3 window_; // place on the lattice of its corner, 1 / half its side

flat out uvec2 number;
flat out vec4 plane; // of the triangle, from the eye
flat out vec2 reach; // its nearest and farthest corner along the axis

const float NEAR = 0.05;

vec3 from_camera(vec3 p)
{
    return vec3(dot(p, right.xyz), -dot(p, up.xyz), -dot(p, back.xyz));
}

void main()
{
    int triangle = drawn.y + gl_VertexID / 3;
    uvec4 corners = texelFetch(object_triangles, triangle);
    placed o = placed_object(drawn.x);
    vec3 p[3];
    for (int i = 0; i < 3; i++) {
        p[i] = object_point(o, texelFetch(object_vertices, int(corners[i]) * PEL_OBJECT_VERTEX_TEXELS).xyz);
    }
    vec3 normal = cross(p[1] - p[0], p[2] - p[0]);
    vec3 along = -vec3(dot(p[0], back.xyz), dot(p[1], back.xyz), dot(p[2], back.xyz));
    vec3 c = from_camera(p[gl_VertexID % 3]);
    vec2 place = c.xy / pixel.xy;
    vec2 clip;
    if (c.z > NEAR) {
        // Rounded as the sea's vertices are, in a window that all pictures of
        // the lattice share: what it clips is clipped alike.
        place = floor(place / c.z * 256.0 + 0.5) / 256.0;
        clip = ((place - window_.xy) * window_.z - 1.0) * c.z;
    } else {
        clip = (place - window_.xy * c.z) * window_.z - c.z;
    }
    gl_Position = vec4(clip, NEAR, c.z);
    number = uvec2(drawn.x + 1, triangle);
    plane = vec4(normal, dot(normal, p[0]));
    reach = vec2(max(min(along.x, min(along.y, along.z)), NEAR),
                 max(along.x, max(along.y, along.z)));
}
