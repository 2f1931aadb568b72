#version 450 core
// What the water sends to an eye in it under a light and its sky, for every
// direction and depth: the maps that lib/underlight.glsl looks up. One workgroup
// a row, that is an elevation, and level of depth; its lanes first are the modes,
// then the azimuths. The last two rows are irradiances.
#include "lib/blocks.h"

layout(local_size_x = PEL_UNDER_COLUMNS) in;
layout(std430, binding = PEL_STORE_WATER_KERNEL) restrict readonly buffer kernel_block { vec4 kernel[]; };
layout(std430, binding = PEL_STORE_UNDER_NEXT) restrict readonly buffer next_block { vec4 next_kernel[]; };
layout(std430, binding = PEL_STORE_WATER_COEFFICIENTS) restrict readonly buffer coefficients_block { vec4 coefficients[]; };
layout(location = 0) uniform int light;
layout(location = 1) uniform float share; // of the next kernel
layout(binding = PEL_IMAGE_UNDER, rgba32f) restrict writeonly uniform image2DArray under_map;

// As in struct pel_under_kernel.
const int RADIANCES = PEL_UNDER_LEVELS * PEL_UNDER_MODES * PEL_WATER_NODES * 2 * PEL_UNDER_ROWS;
const int FLUXES = PEL_UNDER_LEVELS * PEL_WATER_NODES * 2;

shared vec3 series[PEL_UNDER_MODES];

vec3 at_(int i)
{
    return mix(kernel[i].rgb, next_kernel[i].rgb, share);
}

vec3 sky_beam(int mode, int node)
{
    return mode < PEL_WATER_MODES ? coefficients[mode * PEL_WATER_NODES + node].rgb : vec3(0.0);
}

void main()
{
    int lane = int(gl_LocalInvocationID.x);
    int row = int(gl_WorkGroupID.x);
    int level = int(gl_WorkGroupID.y);
    vec3 beam = beams[light].rgb * refracted.z;
    vec3 sum = vec3(0.0);
    if (row >= 2 * PEL_UNDER_ROWS) {
        int side = row - 2 * PEL_UNDER_ROWS;
        for (int i = 0; i < PEL_WATER_NODES && lane == 0; i++) {
            int k = 2 * RADIANCES + (level * PEL_WATER_NODES + i) * 2 + side;
            sum += at_(k) * (beam * at_nodes[i / 4][i % 4]) + at_(k + FLUXES) * sky_beam(0, i);
        }
        if (lane == 0) {
            series[0] = sum;
        }
    } else if (lane < PEL_UNDER_MODES) {
        for (int i = 0; i < PEL_WATER_NODES; i++) {
            int k = ((level * PEL_UNDER_MODES + lane) * PEL_WATER_NODES + i) * 2 * PEL_UNDER_ROWS + row;
            sum += at_(k) * (beam * at_nodes[i / 4][i % 4]) + at_(k + RADIANCES) * sky_beam(lane, i);
        }
        series[lane] = sum;
    }
    barrier();
    vec3 total = series[0];
    float azimuth = 3.14159265359 * float(lane) / float(PEL_UNDER_COLUMNS - 1);
    for (int m = 1; m < PEL_UNDER_MODES && row < 2 * PEL_UNDER_ROWS; m++) {
        total += series[m] * cos(float(m) * azimuth);
    }
    imageStore(under_map, ivec3(lane, row, light * PEL_UNDER_LEVELS + level), vec4(max(total, vec3(0.0)), 0.0));
}
