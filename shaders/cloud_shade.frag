#version 450 core
// What clouds leave of the beams of the lights at sea level, over the tile of
// their field: a channel a light.
#ifndef PEL_CLOUDS
#define PEL_CLOUDS
#endif
#include "lib/blocks.h"
#include "lib/sky.glsl"
#include "lib/clouds.glsl"

layout(location = 0) out vec4 left;

void main()
{
    const float SIDE = float(PEL_CLOUD_TEXELS);
    left = vec4(1.0);
    for (int i = 0; i < PEL_LIT; i++) {
        left[i] = cloud_lit_at(gl_FragCoord.xy / SIDE, lights[i].direction.xyz, 1.0 / (cloud_size.z * SIDE));
    }
}
