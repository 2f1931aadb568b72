#version 450 core
// Rasterises the mesh as strips between rings, one instance a strip. What is
// kept of a triangle is its number: the sea shader intersects it again, so
// that a pixel does not depend on how its picture was rasterised.
#include "lib/blocks.h"

#include "lib/vertex.glsl"

layout(std430, binding = PEL_STORE_VERTICES) readonly buffer vertices_block { vertex vertices[]; };

layout(location = 0) uniform ivec4 block; // first ring, rings, first column, columns
layout(location = 1) uniform int base;

flat out uint triangle;

const float MARGIN = float(PEL_RASTER_MARGIN); // px

void main()
{
    int index = base + (gl_InstanceID + (gl_VertexID & 1)) * block.w + (gl_VertexID >> 1);
    vec3 p = vertices[index].position.xyz;
    vec3 c = vec3(dot(p, right.xyz), dot(p, up.xyz), -dot(p, back.xyz));
    const float NEAR = 0.05;
    vec2 place = vec2(c.x, -c.y) / pixel.xy;
    vec2 clip;
    // The viewport reaches MARGIN beyond the picture: a rasteriser that clips
    // at its edges (llvmpipe) moves what it clips by up to 1/256 pixel.
    vec2 corner = pixel.zw - MARGIN;
    vec2 scale = 2.0 / (size.xy + 2.0 * MARGIN);
    if (c.z > NEAR) {
        // Rounded to 1/256 pixel of the lattice, so that pictures that share a
        // lattice share the coverage of every pixel.
        place = floor(place / c.z * 256.0 + 0.5) / 256.0;
        clip = ((place - corner) * scale - 1.0) * c.z;
    } else {
        clip = (place - corner * c.z) * scale - c.z;
    }
    gl_Position = vec4(clip, NEAR, c.z);
    // 0 means sky. The last vertex of a triangle provokes; its inner ring numbers
    // it.
    int outer = gl_VertexID & 1;
    triangle = uint(index - outer * block.w) * 2u + uint(outer) + 1u;
}
