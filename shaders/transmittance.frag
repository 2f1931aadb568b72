#version 450 core
// Transmittance from (height, zenith cosine) to the top of the atmosphere.
#include "lib/blocks.h"
#include "lib/sky.glsl"

layout(location = 0) out vec4 transmittance;

const vec2 SIZE = vec2(PEL_TRANSMITTANCE_WIDTH, PEL_TRANSMITTANCE_HEIGHT);
const int STEPS = 64;

void main()
{
    float h, mu;
    transmittance_from_texel(gl_FragCoord.xy, SIZE, h, mu);
    float way = distance_to_top(h, mu);
    vec3 depth = vec3(0.0);
    float t0 = 0.0;
    for (int i = 0; i < STEPS; i++) {
        float x = float(i + 1) / float(STEPS);
        float t1 = way * x * x;
        depth += extinction(max(height_along(h, mu, 0.5 * (t0 + t1)), 0.0)) * (t1 - t0);
        t0 = t1;
    }
    transmittance = vec4(exp(-depth), 1.0);
}
