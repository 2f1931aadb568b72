#version 450 core
#ifndef PEL_WAVES
#define PEL_WAVES 60
#endif
#include "lib/blocks.h"
#ifdef PEL_FFT
#include "lib/cascades.glsl"
#else
#include "lib/waves.glsl"
#endif
#include "lib/sky.glsl"
#include "lib/ray.glsl"
#include "lib/ross.glsl"
#include "lib/shade.glsl"
#include "lib/shaded.glsl"
#include "lib/sea.glsl"

layout(binding = 5) uniform usampler2D triangles;
layout(location = 0) out vec4 radiance;
#ifdef PEL_LAYERS
layout(location = 1) out float depth;
layout(location = 2) out vec4 normal;
#endif

void main()
{
    ivec2 at = ivec2(gl_FragCoord.xy);
    shaded s = shade_sea(at, texelFetch(triangles, at, 0).r);
    radiance = vec4(s.radiance, 1.0);
#ifdef PEL_LAYERS
    depth = s.depth;
    normal = vec4(s.normal, 0.0);
#endif
}
