#version 450 core
// The filtered surface at places of one moment: the shaders' side of
// ocean/filter.h, for comparison with it.
#define PEL_LAYERS
#include "lib/blocks.h"
#include "lib/turns.glsl"
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

layout(local_size_x = 64) in;
struct probe {
    vec4 place; // xy: at rest, from the eye's nadir; z: footprint, m
};
layout(std430, binding = PEL_STORE_FILTERED) readonly buffer probes_block { probe probes[]; };
struct answer {
    vec4 shift;
    vec4 normal;
    vec4 left; // xy: slope variance along and across the wind
};
layout(std430, binding = PEL_STORE_FILTERED_ANSWERS) writeonly buffer answers_block { answer answers[]; };

void main()
{
    uint i = gl_GlobalInvocationID.x;
    if (i >= uint(probes.length())) {
        return;
    }
    vec4 p = probes[i].place;
    filtered f = filtered_sea(p.xy, p.z);
    answers[i].shift = vec4(f.shift, 0.0);
    answers[i].normal = vec4(filtered_normal(f), 0.0);
    answers[i].left = vec4(variance_left(p.z), 0.0, 0.0);
}
