#version 450 core
#include "lib/blocks.h"
#include "lib/turns.glsl"
#include "lib/flat.glsl"
#ifdef PEL_AREAS
#include "lib/areas.glsl"
#endif
#include "lib/spline.glsl"
#ifdef PEL_SHORE
#include "lib/shore.glsl"
#endif
#ifdef PEL_FFT
#include "lib/cascades.glsl"
#else
#include "lib/waves.glsl"
#endif
#include "lib/filtered.glsl"
#include "lib/sky.glsl"
#include "lib/clouds.glsl"
#include "lib/fog.glsl"
#include "lib/beam.glsl"
#include "lib/variance.glsl"
#include "lib/ray.glsl"
#include "lib/ross.glsl"
#include "lib/water.glsl"
#include "lib/glints.glsl"
#ifdef PEL_OBJECTS
#include "lib/mirrored.glsl"
#endif
#include "lib/lamplight.glsl"
#include "lib/shade.glsl"
#if defined(PEL_FOAM) || defined(PEL_WASH)
#include "lib/foamlight.glsl"
#include "lib/foam.glsl"
#endif
#include "lib/shaded.glsl"
#include "lib/haze.glsl"
#ifdef PEL_SEABED
#include "lib/seabed.glsl"
#endif
#ifdef PEL_CLOUDS
layout(binding = PEL_UNIT_TRANSMITTANCE) uniform sampler2D transmittance;
#endif
#include "lib/sea.glsl"
#include "lib/tone.glsl"
#include "lib/outputs.glsl"

layout(binding = PEL_UNIT_TRIANGLES) uniform usampler2D triangles;
void main()
{
    ivec2 at = ivec2(gl_FragCoord.xy);
    shaded s = shade_sea(at, texelFetch(triangles, at, 0).r);
    write_outputs(s, at, PEL_SHOWS_SEA);
}
