#version 450 core
// The radiance map of Iwasaki et al. 2003: light scattered once that arrives
// at each plane from each direction (eq. 7 over β E), for a beam at each node;
// and the attenuation map, from each plane up each line of sight.
#define PEL_MEDIUM
#include "lib/blocks.h"
#include "lib/medium.glsl"

layout(local_size_x = PEL_GROUP_WATER) in;
layout(std430, binding = PEL_STORE_WATER_DIRECTIONS) restrict readonly buffer directions_block { vec2 directions[]; };
layout(std430, binding = PEL_STORE_WATER_NODES) restrict readonly buffer nodes_block { vec2 nodes[]; };
layout(std430, binding = PEL_STORE_WATER_PLANES) restrict readonly buffer planes_block { vec4 planes[]; };
layout(binding = PEL_IMAGE_WATER_RADIANCE, rgba32f) restrict writeonly uniform image3D radiance_map;
layout(binding = PEL_IMAGE_WATER_ATTENUATION, rgba32f) restrict writeonly uniform image2D attenuation_map;
layout(location = 0) uniform int level;

void main()
{
    ivec3 at = ivec3(gl_GlobalInvocationID);
    vec3 c = full_extinction.rgb;
    vec3 z = planes[2 * (level * PEL_WATER_PLANES + at.z)].rgb;
    vec3 weight = planes[2 * (level * PEL_WATER_PLANES + at.z) + 1].rgb;
    float mu = directions[at.x].x;
    float sun_mu = nodes[at.y].y;
    imageStore(radiance_map, at, vec4(first_path(level, z, sun_mu, mu), 0.0));
    if (at.x == 0) {
        imageStore(attenuation_map, at.yz, vec4(weight * exp(-c * z / nodes[at.y].y), 0.0));
    }
}
