#version 450 core
// The transform along the columns, into the textures that are sampled.
#include "lib/blocks.h"
#include "lib/fft.glsl"

layout(local_size_x = 64) in;
layout(std430, binding = PEL_STORE_LINES) readonly buffer lines_block { vec4 lines[]; };
#ifdef PEL_FOAM
layout(binding = PEL_IMAGE_BREAKING, rg32f) writeonly uniform image2DArray breaking;
#else
layout(binding = PEL_IMAGE_DISPLACEMENT, rgba32f) writeonly uniform image2DArray displacement;
layout(binding = PEL_IMAGE_SLOPES, rgba32f) writeonly uniform image2DArray slopes;
layout(binding = PEL_IMAGE_FOLD, r32f) writeonly uniform image2DArray fold;
#endif

void main()
{
    int lane = int(gl_LocalInvocationID.x);
    int column = int(gl_WorkGroupID.y);
    int c = int(gl_WorkGroupID.z);
    vec4 ab[4];
    vec4 cd[4];
    for (int r = 0; r < 4; r++) {
        int row = lane + r * FFT_LANES;
        int at = ((c * PEL_CASCADE_N + row) * PEL_CASCADE_N + column) * 2;
        ab[r] = lines[at];
        cd[r] = lines[at + 1];
    }
    transform_line(lane, ab, cd);
    for (int r = 0; r < 4; r++) {
        ivec3 at = ivec3(column, lane + r * FFT_LANES, c);
#ifdef PEL_FOAM
        imageStore(breaking, at, ab[r]);
#else
        imageStore(displacement, at, vec4(ab[r].xyz, 0.0));
        imageStore(slopes, at, cd[r]);
        imageStore(fold, at, vec4(ab[r].w));
#endif
    }
}
