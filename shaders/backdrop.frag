#version 450 core
#include "lib/blocks.h"
#include "lib/sky.glsl"
#include "lib/ray.glsl"
#include "lib/shaded.glsl"
#include "lib/backdrop.glsl"

layout(location = 0) out vec4 radiance;
#ifdef PEL_LAYERS
layout(location = 1) out float depth;
layout(location = 2) out vec4 normal;
#endif

void main()
{
    shaded s = shade_backdrop(ivec2(gl_FragCoord.xy));
    radiance = vec4(s.radiance, 1.0);
#ifdef PEL_LAYERS
    depth = s.depth;
    normal = vec4(s.normal, 0.0);
#endif
}
