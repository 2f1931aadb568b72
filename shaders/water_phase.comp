#version 450 core
// The volume-scattering map of Iwasaki et al. 2003 (section 5.2), as a Fourier
// series in azimuth: phase function between each direction of the sampling and
// each node. It depends on the water alone.
#define PEL_MEDIUM
#include "lib/blocks.h"
#include "lib/medium.glsl"

layout(local_size_x = PEL_GROUP_WATER) in;
layout(std430, binding = PEL_STORE_WATER_DIRECTIONS) restrict readonly buffer directions_block { vec2 directions[]; };
layout(std430, binding = PEL_STORE_WATER_NODES) restrict readonly buffer nodes_block { vec2 nodes[]; };
layout(binding = PEL_IMAGE_WATER_PHASE, rgba32f) restrict writeonly uniform image3D phase_map;

void main()
{
    int at = int(gl_GlobalInvocationID.x);
    int node = int(gl_GlobalInvocationID.y);
    float mu = directions[at].x;
    float level = mu * nodes[node].y;
    float across = sqrt(max(1.0 - mu * mu, 0.0)) * nodes[node].x;
    vec3 modes[PEL_WATER_MODES];
    for (int m = 0; m < PEL_WATER_MODES; m++) {
        modes[m] = vec3(0.0);
    }
    for (int j = 0; j < PEL_WATER_AZIMUTHS; j++) {
        float x = cos(3.14159265359 * (float(j) + 0.5) / float(PEL_WATER_AZIMUTHS));
        vec3 p = phase(level + across * x) * (1.0 / float(PEL_WATER_AZIMUTHS));
        float before = x;
        float now = 1.0;
        for (int m = 0; m < PEL_WATER_MODES; m++) {
            modes[m] += p * now;
            float next = 2.0 * x * now - before;
            before = now;
            now = next;
        }
    }
    for (int m = 0; m < PEL_WATER_MODES; m++) {
        imageStore(phase_map, ivec3(at, node, m), vec4(m > 0 ? 2.0 * modes[m] : modes[m], 0.0));
    }
}
