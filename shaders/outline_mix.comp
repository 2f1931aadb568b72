#version 450 core
// The light of pixels that outlines cut, from what the middles of pixels show:
// mixed in a list, then (PEL_PUT) put in its place, since neighbours may be cut as
// well; once for each plane of light.
#include "lib/blocks.h"
#ifdef PEL_PUT
#include "lib/sky.glsl"
#include "lib/ray.glsl"
#include "lib/tone.glsl"
#endif
#include "lib/edge.glsl"
#include "lib/mixed.glsl"

layout(local_size_x = PEL_GROUP_LINE) in;
// Of outline.comp.
layout(std430, binding = PEL_STORE_EDGES) restrict readonly buffer edges_block {
    uint groups[3];
    uint count;
    uvec2 edges[];
};
layout(std430, binding = PEL_STORE_MIXED) restrict buffer mixed_block { vec4 mixed[]; };

#ifdef PEL_PUT
layout(location = 0) uniform bool toned; // the colour too
layout(binding = PEL_IMAGE_COLOR, rgba8) writeonly uniform image2D color_image;
layout(binding = PEL_IMAGE_SLOTS, rgba32f) writeonly uniform image2D plane;
#else
layout(binding = PEL_IMAGE_RADIANCE, rgba32f) readonly uniform image2D radiance; // w: PEL_SHOWS_*
layout(binding = PEL_IMAGE_SLOTS, rgba32f) readonly uniform image2D plane;

vec4 mix_of(uvec2 edge)
{
    ivec2 at = edge_place(edge);
    ivec2 up = edge_up(edge);
    float own = imageLoad(radiance, at).w;
    vec2 parts = parts_mixed(edge, own, imageLoad(radiance, at - up).w, imageLoad(radiance, at + up).w);
    vec3 below = parts.x > 0.0 ? imageLoad(plane, at - up).rgb : vec3(0.0);
    vec3 above = parts.y > 0.0 ? imageLoad(plane, at + up).rgb : vec3(0.0);
    return vec4(mixed_light(parts, imageLoad(plane, at).rgb, below, above), own);
}
#endif

void main()
{
    uint i = gl_GlobalInvocationID.x;
    if (i >= count) {
        return;
    }
#ifdef PEL_PUT
    ivec2 at = edge_place(edges[i]);
    imageStore(plane, at, mixed[i]);
    if (toned) {
        imageStore(color_image, at, unpackUnorm4x8(packed_color(display(mixed[i].rgb, at))));
    }
#else
    mixed[i] = mix_of(edges[i]);
#endif
}
