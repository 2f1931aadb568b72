#version 450 core
// Pixels that objects fill: nothing is shaded behind them.
#include "lib/blocks.h"

layout(location = 0) uniform bool middles;
layout(binding = PEL_UNIT_OBJECT_COVER) uniform usampler2D object_cover;
layout(binding = PEL_UNIT_OBJECTS) uniform usampler2D objects;

void main()
{
    ivec2 at = ivec2(gl_FragCoord.xy);
    bool filled = texelFetch(object_cover, at, 0).r == (1u << PEL_SAMPLES) - 1u;
    if (!filled || (middles && texelFetch(objects, at, 0).r == 0u)) {
        discard;
    }
    gl_FragDepth = 1e-12;
}
