#version 450 core
#include "lib/blocks.h"
#include "lib/flat.glsl"
#include "lib/sky.glsl"
#include "lib/clouds.glsl"
#include "lib/fog.glsl"
#include "lib/beam.glsl"
#include "lib/ray.glsl"
#include "lib/water.glsl"
#include "lib/shaded.glsl"
#include "lib/backdrop.glsl"
#include "lib/tone.glsl"
#include "lib/outputs.glsl"

void main()
{
    ivec2 at = ivec2(gl_FragCoord.xy);
    shaded s = shade_backdrop(at);
    write_outputs(s, at, PEL_SHOWS_SEA);
}
