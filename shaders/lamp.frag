#version 450 core
// The light of a lamp in a pixel.
#include "lib/blocks.h"
#include "lib/lamps.glsl"

flat in vec4 lamp_light, lamp_halo, lamp_place;
layout(location = 0) out vec4 light;

void main()
{
    vec2 off = gl_FragCoord.xy + pixel.zw - lamp_place.xy;
    light = vec4(lamp_in_pixel(off, lamp_light, lamp_halo, lamp_place), 0.0);
}
