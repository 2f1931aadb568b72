#version 450 core
// How bright the first light's beam is in the water about the eye, by the place
// of the surface through which it comes and by depth: what the waves focus, of
// some whose rays have crossed too, so that it is no more than in proportion.
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
    // As caustic of lib/seabed.glsl, by waves PEL_SHAFT_SHARPER times as long.
    const float eta = 1.0 / PEL_WATER_INDEX;
    vec3 light = lights[PEL_LIGHT_FIRST].direction.xyz;
    float row = clamp((log2(z) - PEL_FOCUS_FIRST) * PEL_FOCUS_STEPS, 0.0, float(PEL_FOCUS_COUNT) - 1.001);
    int focus = PEL_LIGHT_FIRST * PEL_FOCUS_COUNT + int(row);
    float least = PEL_SHAFT_SHARPER * exp2(mix(bed_focus[focus].x, bed_focus[focus + 1].x, fract(row)));
    least = max(least, max(footprint, 2.0 * lights[PEL_LIGHT_FIRST].direction.w * eta * z));
    float reach = z * (to.z - eta * light.z) / to.z;
    vec2 enter = place + light.xy * (z * eta / to.z);
    vec3 bend = wave_bend(enter - reach * wave_slope(enter, least), least);
    float spread = (1.0 + reach * bend.x) * (1.0 + reach * bend.z) - reach * reach * bend.y * bend.y;
    imageStore(shafts, at, vec4(1.0 / max(abs(spread), 1.0 / PEL_SHAFT_MOST)));
}
