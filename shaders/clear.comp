#version 450 core
// The nearest triangles of a picture, forgotten: a driver that clears or copies
// buffers takes ten times as long.
#include "lib/blocks.h"

layout(local_size_x = PEL_GROUP_LINE) in;
layout(std430, binding = PEL_STORE_KEYS) restrict writeonly buffer keys_block { uint keys[]; };

void main()
{
    uint wide = gl_NumWorkGroups.x * uint(PEL_GROUP_LINE);
    uint i = gl_GlobalInvocationID.y * wide + gl_GlobalInvocationID.x;
    if (i < uint(keys.length())) {
        keys[i] = 0u;
    }
}
