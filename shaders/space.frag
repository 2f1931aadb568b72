#version 450 core
// Every pixel of a view from high up: sea and land on the ellipsoid, the air, and
// what shines beyond it. No mesh: what waves there are in a pixel is in its normal.
#define PEL_SPACE
#include "lib/blocks.h"
#include "lib/turns.glsl"
#include "lib/flat.glsl"
#ifdef PEL_SPACE_WINDS
#include "lib/windhere.glsl"
#endif
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
#include "lib/variance.glsl"
#include "lib/ray.glsl"
#include "lib/ross.glsl"
#include "lib/water.glsl"
#include "lib/glints.glsl"
#include "lib/space.glsl"
#include "lib/shade.glsl"
#if defined(PEL_FOAM) || defined(PEL_WASH) || defined(PEL_SPACE_WINDS)
#include "lib/foamlight.glsl"
#endif
#if defined(PEL_FOAM) || defined(PEL_WASH)
#include "lib/foam.glsl"
#endif
#include "lib/shaded.glsl"
#include "lib/backdrop.glsl"
#ifdef PEL_SPACE_CLOUDS
#include "lib/spacecloud.glsl"
#endif
#include "lib/spacesea.glsl"
#include "lib/tone.glsl"
#include "lib/outputs.glsl"

void main()
{
    ivec2 at = ivec2(gl_FragCoord.xy);
    float shows;
    shaded s = shade_space(at, shows);
    write_outputs(s, at, shows);
}
