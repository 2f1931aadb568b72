#version 450 core
// Lists the pixels that outlines cut.
#include "lib/blocks.h"
#include "lib/sky.glsl"
#include "lib/ray.glsl"
#include "lib/cut.glsl"
#include "lib/triangles.glsl"
#include "lib/outline.glsl"
#include "lib/edge.glsl"

layout(local_size_x = PEL_GROUP_LINE) in;
// Of outline_find.comp.
layout(std430, binding = PEL_STORE_SUSPECTS) restrict readonly buffer suspects_block {
    uint suspect_groups[3];
    uint suspect_count;
    uint suspects[];
};
layout(std430, binding = PEL_STORE_EDGES) restrict buffer edges_block {
    uint groups[3]; // of outline_mix.comp
    uint count;
    uvec2 edges[];
};

void main()
{
    if (gl_GlobalInvocationID.x >= suspect_count) {
        return;
    }
    uint place = suspects[gl_GlobalInvocationID.x];
    ivec2 at = ivec2(place & 0xFFFFu, place >> 16);
    upright p = upright_at(at);
    vec2 parts = parts_of_neighbours(at, p);
    if (parts.x + parts.y > 0.0) {
        uint entry = atomicAdd(count, 1u);
        if (entry % uint(PEL_GROUP_LINE) == 0u) {
            atomicAdd(groups[0], 1u);
        }
        edges[entry] = edge_of(at, p.up, parts);
    }
}
