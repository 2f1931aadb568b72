#version 450 core
// Pixels that outlines cut, over what their middles see.
#include "lib/blocks.h"
#include "lib/turns.glsl"
#ifdef PEL_AREAS
#include "lib/areas.glsl"
#endif
#ifdef PEL_FFT
#include "lib/cascades.glsl"
#else
#include "lib/waves.glsl"
#endif
#include "lib/filtered.glsl"
#include "lib/sky.glsl"
#include "lib/variance.glsl"
#include "lib/ray.glsl"
#include "lib/ross.glsl"
#include "lib/water.glsl"
#include "lib/glints.glsl"
#include "lib/shade.glsl"
#ifdef PEL_FOAM
#include "lib/foam.glsl"
#endif
#include "lib/shaded.glsl"
#include "lib/backdrop.glsl"
#include "lib/haze.glsl"
#ifdef PEL_SEABED
#include "lib/seabed.glsl"
#endif
#include "lib/sea.glsl"
#ifdef PEL_LAND
#include "lib/coast.glsl"
#endif
#include "lib/tone.glsl"

layout(local_size_x = PEL_GROUP_LINE) in;
layout(location = 0) uniform int wanted;
// Of outline.comp.
layout(std430, binding = PEL_STORE_EDGES) restrict readonly buffer edges_block {
    uint groups[3];
    uint count;
    uvec2 edges[];
};
layout(binding = PEL_IMAGE_COLOR, rgba8) writeonly uniform image2D color_image;
layout(binding = PEL_IMAGE_RADIANCE, rgba32f) writeonly uniform image2D radiance_image;
#ifdef PEL_LAYERS
layout(location = PEL_UNIFORM_SLOTS) uniform int slots[PEL_COMPUTE_SLOTS];
layout(binding = PEL_IMAGE_SLOTS) writeonly uniform image2D slot_images[PEL_COMPUTE_SLOTS];
#endif

#include "lib/triangles.glsl"
#include "lib/outline.glsl"
#include "lib/edges.glsl"

void main()
{
    if (gl_GlobalInvocationID.x >= count) {
        return;
    }
    uvec2 edge = edges[gl_GlobalInvocationID.x];
    ivec2 at = ivec2(edge.x & 0xFFFFu, edge.x >> 16);
    shaded s = mixed(at, unpackUnorm2x16(edge.y));
    if ((wanted & PEL_WANTS_RADIANCE) != 0) {
        imageStore(radiance_image, at, vec4(s.radiance, 1.0));
    }
    if ((wanted & PEL_WANTS_COLOR) != 0) {
        imageStore(color_image, at, vec4(display(s.radiance, at), 1.0));
    }
#ifdef PEL_LAYERS
    for (int i = 0; i < PEL_COMPUTE_SLOTS; i++) {
        if (slots[i] >= 0) {
            imageStore(slot_images[i], at, layer_of(s, slots[i]));
        }
    }
#endif
}
