#version 450 core
// One texel to one pixel.
#include "lib/blocks.h"
#include "lib/sky.glsl"
#include "lib/ray.glsl"
#include "lib/tone.glsl"

layout(location = 0) out vec4 color;
layout(binding = PEL_UNIT_RADIANCE) uniform sampler2D radiance;

void main()
{
    ivec2 at = ivec2(gl_FragCoord.xy);
    color = vec4(display(texelFetch(radiance, at, 0).rgb, at), 1.0);
}
