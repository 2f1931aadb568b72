#version 450 core
// The scattering maps of Iwasaki et al. 2003: radiance map times
// volume-scattering map over the directions, times attenuation map, accumulated
// over the planes (eq. 6, 8), for every beam and every line of sight. The
// planes are added up first: the phase functions do not depend on them.
#define PEL_MEDIUM
#include "lib/blocks.h"
#include "lib/medium.glsl"

layout(local_size_x = PEL_GROUP_WATER) in;
layout(std430, binding = PEL_STORE_WATER_DIRECTIONS) restrict readonly buffer directions_block { vec2 directions[]; };
layout(std430, binding = PEL_STORE_WATER_NODES) restrict readonly buffer nodes_block { vec2 nodes[]; };
layout(std430, binding = PEL_STORE_WATER_KERNEL) restrict writeonly buffer kernel_block { vec4 kernel[]; };
layout(std430, binding = PEL_STORE_WATER_PLANES) restrict readonly buffer planes_block { vec4 planes[]; };
layout(binding = PEL_UNIT_WATER_PHASE) uniform sampler3D phase_map;
layout(binding = PEL_UNIT_WATER_RADIANCE) uniform sampler3D radiance_map;
layout(binding = PEL_UNIT_WATER_ATTENUATION) uniform sampler2D attenuation_map;
layout(location = 0) uniform int level;

shared vec3 partial[PEL_WATER_MODES][PEL_GROUP_WATER];

// A mode of light that was turned from the beam to the line of sight, and
// besides met the phase function's peak, before or after: straight on.
vec3 by_peak(int beam, int sight, int mode)
{
    vec2 from = nodes[beam];
    vec2 to = nodes[sight];
    vec3 turned = vec3(0.0);
    for (int j = 0; j < PEL_WATER_AZIMUTHS; j++) {
        float azimuth = 3.14159265359 * (float(j) + 0.5) / float(PEL_WATER_AZIMUTHS);
        turned += phase(from.x * to.x * cos(azimuth) - from.y * to.y) * cos(float(mode) * azimuth);
    }
    turned *= (mode > 0 ? 2.0 : 1.0) / float(PEL_WATER_AZIMUTHS);
    vec3 light = vec3(0.0);
    for (int k = 0; k < PEL_WATER_PLANES; k++) {
        vec3 z = planes[2 * (level * PEL_WATER_PLANES + k)].rgb;
        light += texelFetch(attenuation_map, ivec2(sight, k), 0).rgb *
                 (first_path(level, z, from.y, from.y) + first_path(level, z, from.y, -to.y));
    }
    return peak.rgb * turned * light;
}

void main()
{
    int lane = int(gl_LocalInvocationID.x);
    int beam = int(gl_WorkGroupID.x);
    int sight = int(gl_WorkGroupID.y);
    vec3 sum[PEL_WATER_MODES];
    for (int m = 0; m < PEL_WATER_MODES; m++) {
        sum[m] = vec3(0.0);
    }
    for (int i = lane; i < 2 * PEL_WATER_ZENITHS; i += PEL_GROUP_WATER) {
        vec3 light = vec3(0.0);
        for (int k = 0; k < PEL_WATER_PLANES; k++) {
            light += texelFetch(radiance_map, ivec3(i, beam, k), 0).rgb *
                     texelFetch(attenuation_map, ivec2(sight, k), 0).rgb;
        }
        light *= directions[i].y;
        // Seen from the line of sight, a direction's mirror image.
        int mirrored = i < PEL_WATER_ZENITHS ? i + PEL_WATER_ZENITHS : i - PEL_WATER_ZENITHS;
        for (int m = 0; m < PEL_WATER_MODES; m++) {
            sum[m] += light * texelFetch(phase_map, ivec3(i, beam, m), 0).rgb *
                      texelFetch(phase_map, ivec3(mirrored, sight, m), 0).rgb;
        }
    }
    for (int m = 0; m < PEL_WATER_MODES; m++) {
        partial[m][lane] = sum[m];
    }
    barrier();
    if (lane < PEL_WATER_MODES) {
        vec3 total = vec3(0.0);
        for (int i = 0; i < PEL_GROUP_WATER; i++) {
            total += partial[lane][i];
        }
        vec3 b = scattering.rgb;
        total *= (lane > 0 ? 1.0 : 2.0) * 3.14159265359;
        if (any(greaterThan(peak.rgb, vec3(0.0)))) {
            total += by_peak(beam, sight, lane);
        }
        total *= b * b / (PEL_WATER_INDEX * PEL_WATER_INDEX * nodes[sight].y);
        kernel[kernel_at(level, SECOND, lane, beam, sight)] = vec4(total, 0.0);
    }
}
