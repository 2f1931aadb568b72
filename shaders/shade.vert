#version 450 core
// One triangle that covers the viewport, at the far end of the depth range, for
// what shades fragments.
#define PEL_PASSES_FLAT
#include "lib/blocks.h"
#include "lib/flat.glsl"

void main()
{
    vec2 corner = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
    gl_Position = vec4(corner, 0.0, 1.0);
#ifdef PEL_FLAT_LIGHT
    flat_lights[0] = lights[0];
    flat_glare[0] = glare[0];
    flat_beams[0] = beams[0];
#endif
    flat_wind = wind;
    flat_planet = planet;
    flat_refraction = refraction;
    flat_water = water;
    flat_red = red;
    flat_green = green;
    flat_blue = blue;
    flat_eye = eye;
    flat_right = right;
    flat_up = up;
    flat_back = back;
    flat_pixel = pixel;
    flat_exposing = exposing;
#ifdef PEL_FFT
    flat_cascades = cascades;
#endif
}
