#version 450 core
// The tiles of a picture that lamps have shone on (lamps.comp).
#include "lib/blocks.h"

layout(binding = PEL_UNIT_LAMPS) uniform usamplerBuffer lamp_tiles;

void main()
{
    ivec2 end = ivec2(size.xy);
    int across = (end.x - 1) / PEL_LAMP_TILE + 1;
    ivec2 tile = ivec2(gl_InstanceID % across, gl_InstanceID / across);
    ivec2 corner = ivec2(gl_VertexID == 1 || gl_VertexID == 3 || gl_VertexID == 4, gl_VertexID == 2 || gl_VertexID >= 4);
    vec2 at = vec2(min((tile + corner) * PEL_LAMP_TILE, end));
    bool touched = texelFetch(lamp_tiles, gl_InstanceID).r != 0u;
    gl_Position = touched ? vec4(at / size.xy * 2.0 - 1.0, 0.0, 1.0) : vec4(0.0);
}
