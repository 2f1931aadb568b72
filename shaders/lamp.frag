#version 450 core
// The light of a lamp in a pixel.
#include "lib/blocks.h"
#include "lib/lamps.glsl"

flat in vec4 lamp_light, lamp_halo, lamp_place;
layout(location = 0) out vec4 light;

void main()
{
    vec2 off = gl_FragCoord.xy + pixel.zw - lamp_place.xy;
    vec3 sum = lamp_light.rgb * lamp_spread(off, lamp_light.w);
    // Less what it has at its end, where it stops.
    float core2 = lamp_place.z * lamp_place.z;
    float halo = 1.0 / (1.0 + dot(off, off) / core2) - 1.0 / (1.0 + lamp_halo.w * lamp_halo.w / core2);
    light = vec4(sum + lamp_halo.rgb * max(halo, 0.0), 0.0);
}
