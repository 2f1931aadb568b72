#version 450 core
// What leaves the water under a light and its sky, for every line of sight: the
// maps that lib/water.glsl looks up. One workgroup a row, that is a zenith
// angle, and level of depth; its lanes first are the modes of the parts, then
// the azimuths.
#define PEL_MEDIUM
#include "lib/blocks.h"
#include "lib/medium.glsl"

layout(local_size_x = PEL_WATER_MAP_SIZE) in;
layout(std430, binding = PEL_STORE_WATER_KERNEL) restrict readonly buffer kernel_block { vec4 kernel[]; };
layout(std430, binding = PEL_STORE_LIGHT) restrict buffer out_block {
    vec4 out_incident;
    vec4 out_sea;
};
layout(std430, binding = PEL_STORE_WATER_COEFFICIENTS) restrict readonly buffer coefficients_block { vec4 coefficients[]; };
layout(std430, binding = PEL_STORE_WATER_ROWS) restrict readonly buffer rows_block { pel_shader_row rows[]; };
layout(location = 0) uniform int light;
layout(binding = PEL_IMAGE_WATER_MAP, rgba32f) restrict writeonly uniform image2DArray water_map;

shared vec3 series[PARTS * PEL_WATER_MODES];

// Look-up of single scattering: eq. 5 of the 2003 paper but for the surface on
// the way out, for a beam of unit irradiance.
vec3 single(int level, float nu, float mu)
{
    vec3 rate = single_extinction.rgb * (1.0 / refracted.y + 1.0 / mu);
    return scattering.rgb * phase(nu) * mean_decay(rate * depth[level].x) * depth[level].x /
           (mu * PEL_WATER_INDEX * PEL_WATER_INDEX);
}

// Look-up of the beam's light straight from the bottom: eq. 9.
vec3 straight(int level, float mu)
{
    vec3 way = full_extinction.rgb * (1.0 / refracted.y + 1.0 / mu);
    return ground.rgb * exp(-way * depth[level].x) * (refracted.y / (3.14159265359 * PEL_WATER_INDEX * PEL_WATER_INDEX));
}

void main()
{
    int lane = int(gl_LocalInvocationID.x);
    int row = int(gl_WorkGroupID.x);
    int level = int(gl_WorkGroupID.y);
    vec3 beam = beams[light].rgb * refracted.z;
    if (lane < PARTS * PEL_WATER_MODES) {
        int part = lane / PEL_WATER_MODES;
        int mode = lane % PEL_WATER_MODES;
        // The beam's own single scattering and eq. 9 are exact.
        vec3 direct = part == SINGLE || part == STRAIGHT ? vec3(0.0) : beam;
        vec3 sum = vec3(0.0);
        for (int i = 0; i < PEL_WATER_NODES; i++) {
            vec3 seen = vec3(0.0);
            for (int j = 0; j < PEL_WATER_NODES; j++) {
                seen += kernel[kernel_at(level, part, mode, i, j)].rgb *
                        rows[row].at_nodes[j / 4][j % 4];
            }
            sum += seen * (direct * at_nodes[i / 4][i % 4] +
                           coefficients[mode * PEL_WATER_NODES + i].rgb);
        }
        series[lane] = sum;
    }
    barrier();
    float x = 2.0 * float(lane) / float(PEL_WATER_MAP_SIZE - 1) - 1.0;
    float sine = rows[row].at.x;
    float mu = rows[row].at.y;
    vec3 part[PARTS];
    for (int p = 0; p < PARTS; p++) {
        float before = x;
        float now = 1.0;
        part[p] = vec3(0.0);
        for (int m = 0; m < PEL_WATER_MODES; m++) {
            part[p] += series[p * PEL_WATER_MODES + m] * now;
            float next = 2.0 * x * now - before;
            before = now;
            now = next;
        }
    }
    part[SINGLE] += beam * single(level, refracted.x * sine * x - refracted.y * mu, mu);
    part[BOTTOM] += part[STRAIGHT] + beam * straight(level, mu);
    if (full_extinction.w > 0.5) {
        part[BEYOND] -= part[SECOND];
    }
    vec3 total = vec3(0.0);
    int levels = imageSize(water_map).z / (PEL_LIGHTS * PEL_WATER_LAYERS);
    int first = light * PEL_WATER_LAYERS;
    for (int p = 0; p < STRAIGHT; p++) {
        part[p] = max(part[p], 0.0);
        total += part[p];
        imageStore(water_map, ivec3(lane, row, (first + 1 + p) * levels + level), vec4(part[p], 0.0));
    }
    imageStore(water_map, ivec3(lane, row, first * levels + level), vec4(total, 0.0));
    // One value for where the line of sight is not known: 37° aside, over the
    // deepest water.
    if (row == PEL_WATER_MAP_SIZE * 3 / 5 && lane == PEL_WATER_MAP_SIZE / 2 && level == levels - 1) {
        out_sea = vec4(light > 0 ? out_sea.rgb + total : total, 0.0);
    }
}
