#version 450 core
// Lists the pixels that outlines cut.
#include "lib/blocks.h"
#include "lib/sky.glsl"
#include "lib/ray.glsl"
#include "lib/cut.glsl"
#include "lib/triangles.glsl"
#include "lib/outline.glsl"

layout(local_size_x = PEL_GROUP_LINE) in;
// Of outline_find.comp.
layout(std430, binding = PEL_STORE_SUSPECTS) restrict readonly buffer suspects_block {
    uint suspect_groups[3];
    uint suspect_count;
    uint suspects[];
};
layout(std430, binding = PEL_STORE_EDGES) restrict buffer edges_block {
    uint groups[3]; // of edges.comp
    uint count;
    uvec2 edges[]; // place, parts
};

void main()
{
    if (gl_GlobalInvocationID.x >= suspect_count) {
        return;
    }
    uint at = suspects[gl_GlobalInvocationID.x];
    vec2 parts = parts_of_neighbours(ivec2(at & 0xFFFFu, at >> 16));
    if (parts.x + parts.y > 0.0) {
        uint place = atomicAdd(count, 1u);
        if (place % uint(PEL_GROUP_LINE) == 0u) {
            atomicAdd(groups[0], 1u);
        }
        edges[place] = uvec2(at, packUnorm2x16(parts));
    }
}
