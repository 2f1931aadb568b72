#version 450 core
// How much brighter than under a level sea the first light's beam is in the
// water about the eye: what the waves focus, less its mean, by the place of the
// surface through which it comes and by depth.
#define PEL_UNDER
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
#include "lib/sky.glsl"
#include "lib/ray.glsl"
#include "lib/water.glsl"
#include "lib/seabed.glsl"

layout(local_size_x = PEL_GROUP_SIDE, local_size_y = PEL_GROUP_SIDE) in;
layout(binding = PEL_IMAGE_SHAFTS, rgba16f) restrict writeonly uniform image2DArray shafts;

void main()
{
    ivec3 at = ivec3(gl_GlobalInvocationID);
    vec2 u = (vec2(at.xy) + 0.5) * (2.0 / float(PEL_SHAFT_PLACES)) - 1.0;
    vec2 off = PEL_SHAFT_REACH * u * abs(u);
    // Of a texel there.
    float footprint = 4.0 * PEL_SHAFT_REACH * max(length(u), 0.05) / float(PEL_SHAFT_PLACES);
    float z = PEL_SHAFT_FIRST * exp2(float(at.z) / PEL_SHAFT_STEPS);
    vec3 to = under_beams[PEL_LIGHT_FIRST].xyz;
    vec2 run = to.xy / to.z;
    vec2 place = off + run * (max(under_eye.x, 0.0) - z);
    float focus = caustic(PEL_LIGHT_FIRST, place, z, footprint, lights[PEL_LIGHT_FIRST].direction.xyz, to.z) - 1.0;
    imageStore(shafts, at, vec4(focus));
}
