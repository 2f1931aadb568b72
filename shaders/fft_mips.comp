#version 450 core
// One level of detail of the cascades' fields from the one before: the mean of
// 2 × 2 texels. All fields and cascades in one dispatch.
#include "lib/blocks.h"

layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = PEL_UNIT_DISPLACEMENT) uniform sampler2DArray displacement;
layout(binding = PEL_UNIT_SLOPES) uniform sampler2DArray slopes;
layout(binding = PEL_UNIT_FOLD) uniform sampler2DArray fold;
layout(binding = PEL_IMAGE_DISPLACEMENT, rgba32f) writeonly uniform image2DArray displacement_to;
layout(binding = PEL_IMAGE_SLOPES, rgba32f) writeonly uniform image2DArray slopes_to;
layout(binding = PEL_IMAGE_FOLD, r32f) writeonly uniform image2DArray fold_to;
layout(location = 0) uniform int from; // level that is read

vec4 mean(sampler2DArray field, ivec3 at)
{
    return 0.25 * (texelFetch(field, at, from) + texelFetch(field, at + ivec3(1, 0, 0), from) +
                   texelFetch(field, at + ivec3(0, 1, 0), from) +
                   texelFetch(field, at + ivec3(1, 1, 0), from));
}

void main()
{
    ivec3 to = ivec3(gl_GlobalInvocationID);
    if (to.x >= imageSize(displacement_to).x || to.y >= imageSize(displacement_to).y) {
        return;
    }
    ivec3 at = ivec3(to.xy * 2, to.z);
    imageStore(displacement_to, to, mean(displacement, at));
    imageStore(slopes_to, to, mean(slopes, at));
    imageStore(fold_to, to, mean(fold, at));
}
