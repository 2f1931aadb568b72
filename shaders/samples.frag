#version 450 core
// The nearest triangle of objects at each sample of a pixel. The depth is that
// of the sample's ray, as in object.frag.
#include "lib/blocks.h"
#include "lib/sky.glsl"
#include "lib/ray.glsl"
#include "lib/samples.glsl"
#ifdef PEL_HOLES
#include "lib/model.glsl"
#include "lib/holes.glsl"
#endif

flat in uvec2 number;
flat in vec4 plane;
flat in vec2 reach;
layout(location = 0) out uvec2 seen;

const float NEAR = 0.05;

void main()
{
    vec3 ray = pixel_ray(pixel.zw + floor(gl_FragCoord.xy) + sample_place(gl_SampleID));
#ifdef PEL_HOLES
    if (hole_on_ray(number, ray, (float(gl_SampleID) + 0.5) / float(PEL_SAMPLES))) {
        discard;
    }
#endif
    float slant = dot(plane.xyz, ray);
    gl_FragDepth = NEAR / (slant == 0.0 ? reach.x : clamp(plane.w / slant, reach.x, reach.y));
    seen = uvec2(number.x, number.y | (slant > 0.0 ? SAMPLE_INNER : 0u));
}
