#version 450 core
// One level of detail of the mirrored views from the one before: the mean of
// 2 × 2 texels, of all views in one dispatch.
#include "lib/blocks.h"

layout(local_size_x = PEL_GROUP_SIDE, local_size_y = PEL_GROUP_SIDE) in;
layout(binding = PEL_UNIT_MIRRORS) uniform sampler2DArray radiance;
layout(binding = PEL_UNIT_MIRROR_DEPTHS) uniform sampler2DArray away;
layout(binding = PEL_IMAGE_MIRRORS, rgba16f) writeonly uniform image2DArray radiance_to;
layout(binding = PEL_IMAGE_MIRROR_DEPTHS, rg16f) writeonly uniform image2DArray away_to;
layout(location = 0) uniform int from; // level that is read

vec4 mean(sampler2DArray views, ivec3 at)
{
    return 0.25 * (texelFetch(views, at, from) + texelFetch(views, at + ivec3(1, 0, 0), from) +
                   texelFetch(views, at + ivec3(0, 1, 0), from) +
                   texelFetch(views, at + ivec3(1, 1, 0), from));
}

void main()
{
    ivec3 to = ivec3(gl_GlobalInvocationID);
    ivec2 size = imageSize(radiance_to).xy;
    if (to.x >= size.x || to.y >= size.y) {
        return;
    }
    ivec3 at = ivec3(to.xy * 2, to.z);
    imageStore(radiance_to, to, mean(radiance, at));
    imageStore(away_to, to, mean(away, at));
}
