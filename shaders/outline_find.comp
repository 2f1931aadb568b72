#version 450 core
// Lists the pixels that outlines may cut, eight below each other at once: where
// the numbers of neighbouring triangles lie at least a ring apart.
#include "lib/blocks.h"
#include "lib/together.glsl"
#include "lib/triangles.glsl"

layout(local_size_x = PEL_GROUP_LINE) in;
#ifdef PEL_TOGETHER
uvec2 apart_of(int i)
{
    uvec4 pair = PEL_OWN.apart[i >> 1];
    return (i & 1) == 0 ? pair.xy : pair.zw;
}
#define sideways (PEL_OWN.picture.w != 0u)
layout(std430, binding = PEL_STORE_SUSPECTS) restrict buffer suspects_block {
    uint counts[PEL_TOGETHER_MOST];
    uint suspects[];
};
#define count counts[gl_WorkGroupID.z]
#else
// From x on, triangles of numbers y apart have a ring between theirs.
layout(location = 0) uniform uvec2 apart[PEL_OUTLINE_BLOCKS];
layout(location = 0 + PEL_OUTLINE_BLOCKS + 1) uniform bool sideways; // neighbours to the left and right count
layout(location = 0 + PEL_OUTLINE_BLOCKS) uniform ivec4 region; // pixels from xy to before zw
layout(std430, binding = PEL_STORE_SUSPECTS) restrict buffer suspects_block {
    uint groups[3]; // of outline.comp
    uint count;
    uint suspects[];
};

uvec2 apart_of(int i)
{
    return apart[i];
}
#endif

bool are_apart(uint a, uint b)
{
    uint far = max(a, b);
    uint least = apart_of(0).y;
    for (int i = 1; i < PEL_OUTLINE_BLOCKS; i++) {
        least = far >= apart_of(i).x ? apart_of(i).y : least;
    }
    return far - min(a, b) >= least;
}

void main()
{
    take_view();
#ifdef PEL_TOGETHER
    int margin = int(PEL_OWN.picture.x);
    ivec4 region = ivec4(margin, margin, ivec2(size.xy) - margin);
#endif
    ivec2 first = region.xy + ivec2(gl_GlobalInvocationID.xy) * ivec2(1, PEL_OUTLINE_ROWS);
    if (first.x >= region.z || first.y >= region.w) {
        return;
    }
    // Rings lie above each other in their order: what is within one at the ends
    // is between them.
    ivec2 last = ivec2(size.xy) - 1;
    uint found = 0u;
    const int HALF = PEL_OUTLINE_ROWS / 2;
    uint next = triangle_at(first - ivec2(0, 1));
    uint middle = triangle_at(min(first + ivec2(0, HALF - 1), last));
    bool below = are_apart(next, middle) || sideways;
    bool above = are_apart(middle, triangle_at(min(first + ivec2(0, PEL_OUTLINE_ROWS), last))) || sideways;
    next = below ? next : middle;
    for (int y = below ? 0 : HALF; y <= (above ? PEL_OUTLINE_ROWS : below ? HALF - 1 : -1); y++) {
        uint own = next;
        next = triangle_at(min(first + ivec2(0, y), last));
        found |= are_apart(own, next) ? 3u << y : 0u; // by one
    }
    found >>= 1;
    for (int y = 0; y < PEL_OUTLINE_ROWS && sideways; y++) {
        ivec2 at = min(first + ivec2(0, y), last - ivec2(1, 0));
        uint own = triangle_at(at);
        bool beside = are_apart(triangle_at(at - ivec2(1, 0)), own) ||
                      are_apart(triangle_at(at + ivec2(1, 0)), own);
        found |= beside ? 1u << y : 0u;
    }
    found &= (1u << min(PEL_OUTLINE_ROWS, region.w - first.y)) - 1u;
    if (found == 0u) {
        return;
    }
    // There is room for all pixels.
    uint many = uint(bitCount(found));
    uint place = atomicAdd(count, many);
#ifndef PEL_TOGETHER
    atomicMax(groups[0], (place + many - 1u) / uint(PEL_GROUP_LINE) + 1u);
#endif
    for (; found != 0u; found &= found - 1u) {
        suspects[FIRST_PIXEL + place++] = uint(first.y + findLSB(found)) << 16 | uint(first.x);
    }
}
