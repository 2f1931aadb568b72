#version 450 core
// The air's extinction has drops and flakes near the eye in the mean: what
// is drawn of them one by one (falling.frag) is taken out of it.
#include "lib/blocks.h"
#ifndef PEL_DROPS
#define PEL_DROPS PEL_FALL_DROPS
#define PEL_FLAKES PEL_FALL_FLAKES
#endif
#include "lib/sky.glsl"
#include "lib/clouds.glsl"
#include "lib/fog.glsl"
#include "lib/ray.glsl"
#include "lib/beam.glsl"
#include "lib/falling.glsl"

layout(location = 0) out vec4 light;
// y 1, for tests: what they and all others cover, in black.
layout(location = 0) uniform vec4 falls;
// PEL_DROPS and PEL_FLAKES of them: axis, w cover; x all cover.
layout(location = 1) uniform vec4 kinds[2 * (PEL_DROPS + PEL_FLAKES)];

// Of some kinds; all that they cover is added to `all`.
float covers(vec3 dir, int first, int end, inout float all)
{
    float sum = 0.0;
    for (int i = first; i < end; i++) {
        float along = dot(dir, kinds[2 * i].xyz);
        sum += kinds[2 * i].w * aside(sqrt(max(1.0 - along * along, 0.0)));
        all += kinds[2 * i + 1].x;
    }
    return sum;
}

void main()
{
    vec3 ray = pixel_ray(lattice(ivec2(gl_FragCoord.xy)));
    vec3 dir = ray * inversesqrt(dot(ray, ray));
    float reach = dir.z < 0.0 ? min(eye.x / (-dir.z * 8.0), 1.0) : 1.0;
    float all = 0.0;
    float drops = covers(dir, 0, PEL_DROPS, all);
    float flakes = covers(dir, PEL_DROPS, PEL_DROPS + PEL_FLAKES, all);
#if defined(PEL_CLOUDS) || defined(PEL_FOG)
    veil_lights_evenly();
#endif
    vec3 sum = vec3(0.0);
#if PEL_DROPS > 0
    sum += drops * fallen_light(dir, false);
#endif
#if PEL_FLAKES > 0
    sum += flakes * fallen_light(dir, true);
#endif
    light = falls.y > 0.0 ? vec4(0.0, 0.0, 0.0, all - drops - flakes) : -reach * vec4(sum, drops + flakes);
}
