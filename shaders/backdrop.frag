#version 450 core
#include "lib/blocks.h"
#include "lib/sky.glsl"
#include "lib/ray.glsl"
#include "lib/water.glsl"
#include "lib/shaded.glsl"
#include "lib/backdrop.glsl"
#include "lib/outputs.glsl"

void main()
{
    shaded s = shade_backdrop(ivec2(gl_FragCoord.xy));
    write_outputs(s);
}
