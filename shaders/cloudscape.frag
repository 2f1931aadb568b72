#version 450 core
// The clouds before the sky at the nodes of a coarser lattice: what they add to
// its light, and what they leave of it.
#ifndef PEL_CLOUDS
#define PEL_CLOUDS
#endif
#include "lib/blocks.h"
#include "lib/flat.glsl"
#include "lib/sky.glsl"
#include "lib/clouds.glsl"
#include "lib/ray.glsl"

layout(location = 0) out vec4 scape;
layout(binding = PEL_UNIT_TRANSMITTANCE) uniform sampler2D transmittance;
layout(binding = PEL_UNIT_EYE_TABLE) uniform sampler2DArray eye_table;
#ifdef PEL_NIGHT
#include "lib/night.glsl"
#endif

void main()
{
    vec2 node = floor(pixel.zw * size.w) - 1.0 + floor(gl_FragCoord.xy);
    vec3 ray = pixel_ray(node / size.w);
    float inverse = inversesqrt(dot(ray, ray));
    vec3 dir = ray * inverse;
    float blur = pixel.x / size.w * inverse;
    float angle = angle_above_horizon(dir);
    scape = vec4(0.0, 0.0, 0.0, 1.0);
    // Nodes below the horizon serve those pixels that are just above it.
    if (angle > -4.0 * blur) {
        float low = horizon_cosine(eye.x) + 1e-4;
        if (dir.z < low) {
            dir = vec3(normalize(dir.xy) * sqrt(1.0 - low * low), low);
            angle = 0.0;
        }
        vec3 light = sky_light(eye_table, dir.xy, max(angle, 0.0));
#ifdef PEL_NIGHT
        light += night_off(dir);
#endif
        clouded c = clouds_toward(transmittance, dir, light, through_sky(transmittance, dir), blur, 1e9);
        scape = vec4(clouded_sky(c, light) - light * c.before, c.before);
    }
}
