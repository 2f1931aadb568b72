#version 450 core
// A drop on a pane: a lens of so short a focus that it shows all that lies before
// it, turned over, whatever the picture is of: the sky that the sea mirrors, and
// the sea.
#include "lib/blocks.h"
#include "lib/sky.glsl"
#include "lib/clouds.glsl"
#include "lib/fog.glsl"
#include "lib/beam.glsl"

flat in vec4 drop, bent, form;
layout(location = 0) out vec4 light;
layout(binding = PEL_UNIT_REFLECTION) uniform sampler2D reflection_map;

vec3 sky_there(vec3 dir)
{
    vec2 u = dir.xy / (1.0 + max(dir.z, 0.0));
    return textureLod(reflection_map, u * (0.5 / PEL_REFLECTION_HALF_WIDTH) + 0.5, 3.0).rgb;
}

vec3 light_from(vec3 dir)
{
    vec3 above = sky_there(vec3(dir.xy, abs(dir.z)));
    // Of a rough sea, never as much as a mirror's.
    float glance = 1.0 - abs(dir.z);
    float mirrored = 0.02 + 0.5 * glance * glance * glance * glance;
    vec3 below = sea_light.rgb + mirrored * above;
    vec3 sum = mix(below, above, smoothstep(-0.03, 0.03, dir.z));
    for (int i = 0; i < PEL_LIT; i++) {
        float off = 2.0 - 2.0 * dot(dir, lights[i].direction.xyz);
        sum += beam_there(i) * (20.0 * exp(-60.0 * off)) / 3.14159;
    }
    return sum;
}

void main()
{
    vec2 off = gl_FragCoord.xy + pixel.zw - drop.xy;
    vec2 p = vec2(off.x, -off.y / bent.z) / drop.z;
    // A runner is narrow above.
    p.x *= 1.0 + (bent.z - 1.0) * 1.2 * clamp(p.y, 0.0, 1.0);
    float r2 = dot(p, p);
    // A pane is out of focus.
    r2 += form.x * (p.x * p.x - p.y * p.y) + form.y * p.x * p.y + form.z * p.y * (3.0 * p.x * p.x - p.y * p.y) * 0.5;
    float soft = max(PEL_PANE_SOFT / pixel.x, 0.5);
    float cover = drop.w * smoothstep(-soft, soft, (1.0 - sqrt(max(r2, 0.0))) * drop.z);
    // Its surface is steeper and steeper.
    float turn = 1.5 / sqrt(max(1.0 - 0.72 * min(r2, 1.0), 0.1));
    vec2 to = bent.xy - turn * p;
    vec3 dir = normalize(right.xyz * to.x + up.xyz * to.y - back.xyz);
#if defined(PEL_CLOUDS) || defined(PEL_FOG)
    veil_lights_evenly();
#endif
    float rim = 1.0 - 0.75 * smoothstep(0.7, 1.0, r2);
    light = vec4(light_from(dir) * (0.95 * rim * cover), cover);
}
