#version 450 core
// What a drop or flake near the eye covers of a pixel while the shutter is open,
// blended over the radiance behind.
#include "lib/blocks.h"

flat in vec4 streak, shape, light_of;
layout(location = 0) out vec4 light;

// Share of the way from -1 to 1, of a parabola.
float passed(float x)
{
    return smoothstep(-1.0, 1.0, x);
}

void main()
{
    vec2 off = gl_FragCoord.xy + pixel.zw - streak.xy;
    float x = dot(off, vec2(-streak.w, streak.z)) / shape.x;
    float y = dot(off, streak.zw);
    float bump = max(1.0 - x * x, 0.0);
    float ends = 0.5 * shape.y;
    float covers = bump * bump * (passed((y + ends) / shape.x) - passed((y - ends) / shape.x));
    covers = min(covers * shape.z * (15.0 / 16.0) / (shape.x * shape.y), 1.0);
    light = vec4(light_of.rgb * covers, covers);
}
