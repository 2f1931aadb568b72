#version 450 core
// The sky of a light as beams at the nodes: a mode of its radiance in azimuth, refracted
// into the water and given to the nodes by their weights, so that the answer
// of the water to these is its answer to the whole sky. One workgroup a mode.
#include "lib/blocks.h"
#include "lib/sky.glsl"

layout(local_size_x = PEL_WATER_SKY_ROWS) in;
layout(std430, binding = PEL_STORE_WATER_COEFFICIENTS) restrict writeonly buffer coefficients_block { vec4 coefficients[]; };
layout(std430, binding = PEL_STORE_WATER_ROWS) restrict readonly buffer rows_block { pel_shader_row rows[]; };
layout(binding = PEL_UNIT_SKY_TABLE) uniform sampler2DArray sky_table;
layout(location = 0) uniform int light;

shared vec3 lit[PEL_WATER_SKY_ROWS];

void main()
{
    int row = int(gl_LocalInvocationID.x);
    float mode = float(gl_WorkGroupID.x);
    vec2 table = vec2(textureSize(sky_table, 0).xy);
    vec3 sum = vec3(0.0);
    for (int j = 0; j < PEL_WATER_SKY_COLUMNS; j++) {
        float azimuth = PI * (float(j) + 0.5) / float(PEL_WATER_SKY_COLUMNS);
        sum += textureLod(sky_table, vec3(sky_uv(azimuth, rows[row].at.x, table), light), 0.0).rgb *
               cos(mode * azimuth);
    }
    lit[row] = sum * rows[row].at.y;
    barrier();
    if (row < PEL_WATER_NODES) {
        vec3 total = vec3(0.0);
        for (int i = 0; i < PEL_WATER_SKY_ROWS; i++) {
            total += lit[i] * rows[i].at_nodes[row / 4][row % 4];
        }
        coefficients[int(mode) * PEL_WATER_NODES + row] = vec4(total, 0.0);
    }
}
