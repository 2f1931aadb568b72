#version 450 core
// One level of detail of the cascades' fields from the one before: the mean of
// 2 × 2 texels. All fields and cascades in one dispatch.
#include "lib/blocks.h"

layout(local_size_x = 8, local_size_y = 8) in;
#ifdef PEL_FOAM
layout(binding = PEL_UNIT_BREAKING) uniform sampler2DArray breaking;
layout(binding = PEL_IMAGE_BREAKING, rg32f) writeonly uniform image2DArray breaking_to;
#else
layout(binding = PEL_UNIT_DISPLACEMENT) uniform sampler2DArray displacement;
layout(binding = PEL_UNIT_SLOPES) uniform sampler2DArray slopes;
layout(binding = PEL_UNIT_FOLD) uniform sampler2DArray fold;
layout(binding = PEL_IMAGE_DISPLACEMENT, rgba32f) writeonly uniform image2DArray displacement_to;
layout(binding = PEL_IMAGE_SLOPES, rgba32f) writeonly uniform image2DArray slopes_to;
layout(binding = PEL_IMAGE_FOLD, r32f) writeonly uniform image2DArray fold_to;
#endif
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
#ifdef PEL_FOAM
    ivec2 size = imageSize(breaking_to).xy;
#else
    ivec2 size = imageSize(displacement_to).xy;
#endif
    if (to.x >= size.x || to.y >= size.y) {
        return;
    }
    ivec3 at = ivec3(to.xy * 2, to.z);
#ifdef PEL_FOAM
    imageStore(breaking_to, to, mean(breaking, at));
#else
    imageStore(displacement_to, to, mean(displacement, at));
    imageStore(slopes_to, to, mean(slopes, at));
    imageStore(fold_to, to, mean(fold, at));
#endif
}
