#version 450 core
// A square about each lamp that a view shows (lamps.comp).
#include "lib/blocks.h"

layout(binding = PEL_UNIT_LAMPS) uniform samplerBuffer lamp_texels;
flat out vec4 lamp_light, lamp_halo, lamp_place;

void main()
{
    lamp_light = texelFetch(lamp_texels, 3 * gl_InstanceID);
    lamp_halo = texelFetch(lamp_texels, 3 * gl_InstanceID + 1);
    lamp_place = texelFetch(lamp_texels, 3 * gl_InstanceID + 2);
    vec2 corner = vec2(gl_VertexID == 1 || gl_VertexID == 3 || gl_VertexID == 4 ? 1.0 : -1.0,
                       gl_VertexID == 2 || gl_VertexID >= 4 ? 1.0 : -1.0);
    vec2 at = lamp_place.xy - pixel.zw + corner * (lamp_place.w + 1.0);
    gl_Position = vec4(at / size.xy * 2.0 - 1.0, 0.0, 1.0);
}
