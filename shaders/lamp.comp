#version 450 core
// The light of lamps alone in each pixel, for shading in compute: GPUs blend slowly.
#include "lib/blocks.h"
#include "lib/lamps.glsl"

layout(local_size_x = PEL_GROUP_SIDE, local_size_y = PEL_GROUP_SIDE) in;
layout(location = 0) uniform uint count;
layout(binding = PEL_UNIT_LAMPS) uniform samplerBuffer lamp_texels;
layout(binding = PEL_IMAGE_RADIANCE, rgba32f) writeonly uniform image2D alone;
shared uint near[PEL_LAMP_SPOTS / 32]; // a bit a lamp, so that sums have one order

void main()
{
    uint own = gl_LocalInvocationIndex;
    const uint GROUP = uint(PEL_GROUP_SIDE * PEL_GROUP_SIDE);
    for (uint i = own; i < uint(PEL_LAMP_SPOTS / 32); i += GROUP) {
        near[i] = 0u;
    }
    barrier();
    vec2 middle = (vec2(gl_WorkGroupID.xy) + 0.5) * float(PEL_GROUP_SIDE) + pixel.zw;
    for (uint i = own; i < count; i += GROUP) {
        vec4 place = texelFetch(lamp_texels, int(3u * i + 2u));
        vec2 off = abs(place.xy - middle) - 0.5 * float(PEL_GROUP_SIDE);
        if (max(off.x, off.y) <= place.w + 1.0) {
            atomicOr(near[i / 32u], 1u << (i & 31u));
        }
    }
    barrier();
    vec2 at = vec2(gl_GlobalInvocationID.xy) + 0.5 + pixel.zw;
    vec3 sum = vec3(0.0);
    for (uint word = 0u; word * 32u < count; word++) {
        for (uint left = near[word]; left != 0u; left &= left - 1u) {
            int i = 3 * (int(word) * 32 + findLSB(left));
            vec4 place = texelFetch(lamp_texels, i + 2);
            vec2 off = at - place.xy;
            if (max(abs(off.x), abs(off.y)) <= place.w + 1.0) {
                sum += lamp_in_pixel(off, texelFetch(lamp_texels, i), texelFetch(lamp_texels, i + 1), place);
            }
        }
    }
    if (all(lessThan(gl_GlobalInvocationID.xy, uvec2(size.xy)))) {
        imageStore(alone, ivec2(gl_GlobalInvocationID.xy), vec4(sum, 0.0));
    }
}
