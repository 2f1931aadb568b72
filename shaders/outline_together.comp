#version 450 core
// The colour of pixels that outlines cut, of views that are drawn together: as
// outline_mix.comp, at once, since nobody reads their light any more.
#define PEL_TOGETHER
#include "lib/blocks.h"
#include "lib/together.glsl"
#include "lib/sky.glsl"
#include "lib/ray.glsl"
#include "lib/tone.glsl"
#include "lib/edge.glsl"
#include "lib/pictures.glsl"
#include "lib/mixed.glsl"

layout(local_size_x = PEL_GROUP_LINE) in;
// Of outline.comp.
layout(std430, binding = PEL_STORE_EDGES) restrict readonly buffer edges_block {
    uint counts[PEL_TOGETHER_MOST];
    uvec2 edges[];
};
layout(std430, binding = PEL_STORE_RADIANCE) restrict readonly buffer radiance_block { vec4 radiance[]; };

vec4 radiance_at(ivec2 at)
{
    return radiance[FIRST_PIXEL + uint(at.y * int(size.x) + at.x)];
}

void mix_edge(uvec2 edge)
{
    ivec2 at = edge_place(edge);
    ivec2 up = edge_up(edge);
    vec4 own = radiance_at(at), lower = radiance_at(at - up), upper = radiance_at(at + up);
    vec2 parts = parts_mixed(edge, own.w, lower.w, upper.w);
    put_color(at, display(mixed_light(parts, own.rgb, lower.rgb, upper.rgb), at));
}

void main()
{
    take_view();
    uint all = gl_NumWorkGroups.x * uint(PEL_GROUP_LINE);
    for (uint i = gl_GlobalInvocationID.x; i < counts[gl_WorkGroupID.z]; i += all) {
        mix_edge(edges[FIRST_PIXEL + i]);
    }
}
