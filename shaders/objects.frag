#version 450 core
// The objects of a picture, where object.frag found them; in tiles with land
// that stands nearer, not.
#include "lib/blocks.h"
#ifdef PEL_LAND
#ifdef PEL_FFT
#include "lib/cascades.glsl"
#else
#include "lib/waves.glsl"
#endif
#include "lib/filtered.glsl"
#endif
#include "lib/sky.glsl"
#include "lib/variance.glsl"
#include "lib/ray.glsl"
#include "lib/water.glsl"
#include "lib/shaded.glsl"
#include "lib/haze.glsl"
#ifdef PEL_LAND
#include "lib/seabed.glsl"
#endif
#include "lib/objects.glsl"
#include "lib/tone.glsl"
#include "lib/outputs.glsl"

void main()
{
    ivec2 at = ivec2(gl_FragCoord.xy);
    uvec2 seen = texelFetch(objects, at, 0).rg;
#ifdef PEL_LAND
    if (!object_in_sight(at, seen)) {
        discard;
    }
#endif
    shaded s = shade_object(at, seen);
    write_outputs(s, at);
}
