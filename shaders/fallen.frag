#version 450 core
// The air's extinction has drops and flakes near the eye in the mean: what
// is drawn of them one by one (falling.frag) is taken out of it.
#include "lib/blocks.h"
#include "lib/sky.glsl"
#include "lib/clouds.glsl"
#include "lib/fog.glsl"
#include "lib/ray.glsl"
#include "lib/beam.glsl"
#include "lib/falling.glsl"

layout(location = 0) out vec4 light;
// x number of kinds; y 1, for tests: what they and all others cover, in black.
layout(location = 0) uniform vec4 falls;
layout(location = 1) uniform vec4 kinds[2 * PEL_FALL_KINDS]; // axis, w cover; x 1: flakes; y all cover

void main()
{
    vec3 ray = pixel_ray(lattice(ivec2(gl_FragCoord.xy)));
    vec3 dir = ray * inversesqrt(dot(ray, ray));
    float reach = dir.z < 0.0 ? min(eye.x / (-dir.z * PEL_FALL_FARTHEST_M), 1.0) : 1.0;
    float drops = 0.0;
    float flakes = 0.0;
    float all = 0.0;
    for (int i = 0; i < int(falls.x); i++) {
        float along = dot(dir, kinds[2 * i].xyz);
        float sine = sqrt(max(1.0 - along * along, 1e-3));
        float covers = kinds[2 * i].w * aside(sine) / sine;
        all += kinds[2 * i + 1].y / sine;
        drops += kinds[2 * i + 1].x > 0.0 ? 0.0 : covers;
        flakes += kinds[2 * i + 1].x > 0.0 ? covers : 0.0;
    }
#if defined(PEL_CLOUDS) || defined(PEL_FOG)
    veil_lights_evenly();
#endif
    vec3 sum = drops * fallen_light(dir, false) + flakes * fallen_light(dir, true);
    light = falls.y > 0.0 ? vec4(0.0, 0.0, 0.0, all - drops - flakes) : -reach * vec4(sum, drops + flakes);
}
