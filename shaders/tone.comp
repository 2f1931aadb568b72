#version 450 core
// The colour of a picture whose layers were shaded in compute.
#include "lib/blocks.h"
#include "lib/tone.glsl"

layout(local_size_x = PEL_GROUP_SIDE, local_size_y = PEL_GROUP_SIDE) in;
layout(binding = PEL_UNIT_RADIANCE) uniform sampler2D radiance;
layout(binding = 0, rgba8) writeonly uniform image2D color_image;

void main()
{
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (at.x < int(size.x) && at.y < int(size.y)) {
        imageStore(color_image, at, vec4(display(texelFetch(radiance, at, 0).rgb, at), 1.0));
    }
}
