#version 450 core
// Which samples of a pixel show an object, where any.frag found one.
#include "lib/blocks.h"
#include "lib/sky.glsl"
#include "lib/ray.glsl"
#include "lib/cut.glsl"
#include "lib/triangles.glsl"
#include "lib/model.glsl"
#include "lib/samples.glsl"
#include "lib/sight.glsl"

layout(location = 0) out uint cover;

void main()
{
    cover = samples_in_sight(ivec2(gl_FragCoord.xy));
}
