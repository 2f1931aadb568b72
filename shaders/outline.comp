#version 450 core
// Lists the pixels that outlines cut.
#include "lib/blocks.h"
#include "lib/together.glsl"
#include "lib/sky.glsl"
#include "lib/ray.glsl"
#include "lib/cut.glsl"
#include "lib/triangles.glsl"
#include "lib/outline.glsl"
#include "lib/edge.glsl"

layout(local_size_x = PEL_GROUP_LINE) in;
#ifdef PEL_TOGETHER
// Of outline_find.comp.
layout(std430, binding = PEL_STORE_SUSPECTS) restrict readonly buffer suspects_block {
    uint suspect_counts[PEL_TOGETHER_MOST];
    uint suspects[];
};
layout(std430, binding = PEL_STORE_EDGES) restrict buffer edges_block {
    uint counts[PEL_TOGETHER_MOST];
    uvec2 edges[];
};
#define suspect_count suspect_counts[gl_WorkGroupID.z]
#define count counts[gl_WorkGroupID.z]
#else
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
#endif

void follow(uint i)
{
    uint place = suspects[FIRST_PIXEL + i];
    ivec2 at = ivec2(place & 0xFFFFu, place >> 16);
    upright p = upright_at(at);
    vec2 parts = parts_of_neighbours(at, p);
    if (parts.x + parts.y > 0.0) {
        uint entry = atomicAdd(count, 1u);
#ifndef PEL_TOGETHER
        if (entry % uint(PEL_GROUP_LINE) == 0u) {
            atomicAdd(groups[0], 1u);
        }
#endif
        edges[FIRST_PIXEL + entry] = edge_of(at, p.up, parts);
    }
}

void main()
{
    take_view();
    uint all = gl_NumWorkGroups.x * uint(PEL_GROUP_LINE);
    for (uint i = gl_GlobalInvocationID.x; i < suspect_count; i += all) {
        follow(i);
    }
}
