#version 450 core
// Four levels of detail of a field of the cascades from the one before them, each
// the mean of 2 × 2 texels of the one before it. A level a dispatch is a dispatch
// that waits for the last one.
#include "lib/blocks.h"

const int SIDE = 8;
layout(local_size_x = SIDE, local_size_y = SIDE) in;
layout(binding = PEL_UNIT_MIPS) uniform sampler2DArray field;
layout(binding = PEL_IMAGE_MIPS) writeonly uniform image2DArray levels[PEL_MIPS];
layout(location = 0) uniform int from; // level that is read

shared vec4 texels[SIDE][SIDE];

void main()
{
    ivec3 to = ivec3(gl_GlobalInvocationID);
    ivec2 at = ivec2(gl_LocalInvocationID);
    ivec3 of = ivec3(to.xy * 2, to.z);
    vec4 mean = 0.25 * (texelFetch(field, of, from) + texelFetch(field, of + ivec3(1, 0, 0), from) +
                        texelFetch(field, of + ivec3(0, 1, 0), from) +
                        texelFetch(field, of + ivec3(1, 1, 0), from));
    imageStore(levels[0], to, mean);
    for (int level = 1; level < PEL_MIPS; level++) {
        int side = SIDE >> level;
        bool within = max(at.x, at.y) < side;
        barrier();
        texels[at.y][at.x] = mean;
        barrier();
        if (within) {
            ivec2 from_ = at * 2;
            mean = 0.25 * (texels[from_.y][from_.x] + texels[from_.y][from_.x + 1] +
                           texels[from_.y + 1][from_.x] + texels[from_.y + 1][from_.x + 1]);
            imageStore(levels[level], ivec3(ivec2(gl_WorkGroupID) * side + at, to.z), mean);
        }
    }
}
