#version 450 core
// One value of each function that shades (render/probe.h).
#include "lib/blocks.h"
#include "lib/sky.glsl"
#include "lib/clouds.glsl"
#include "lib/fog.glsl"
#include "lib/beam.glsl"
#include "lib/ray.glsl"
#include "lib/ross.glsl"
#include "lib/water.glsl"
#include "lib/shade.glsl"

layout(local_size_x = 1) in;
layout(binding = PEL_UNIT_TRANSMITTANCE) uniform sampler2D transmittance;
layout(binding = PEL_UNIT_REFLECTION) uniform sampler2D reflection_map;
layout(binding = PEL_UNIT_EYE_TABLE) uniform sampler2DArray eye_table;
layout(location = 0) uniform vec3 direction;
layout(location = 1) uniform vec2 slopes; // variance along, across the wind
layout(std430, binding = PEL_STORE_PROBE) writeonly buffer answer_block { vec4 answer[PEL_PROBE_ANSWERS]; };

// Twin of pel_mean_fresnel, at 550 nm.
float smith_fresnel(vec3 view, vec2 variance)
{
    const float STEP = 2.0 * PEL_MEAN_FRESNEL_REACH / float(PEL_MEAN_FRESNEL_STEPS);
    float seen = 0.0, reflected = 0.0;
    for (int i = 0; i < PEL_MEAN_FRESNEL_STEPS; i++) {
        for (int j = 0; j < PEL_MEAN_FRESNEL_STEPS; j++) {
            vec2 unit = (vec2(i, j) + 0.5) * STEP - PEL_MEAN_FRESNEL_REACH;
            vec2 slope = unit * sqrt(variance);
            float facing = max(view.z - dot(view.xy, slope), 0.0);
            float share = facing * exp(-0.5 * dot(unit, unit));
            seen += share;
            reflected += share * facet_reflectance(facing * inversesqrt(1.0 + dot(slope, slope))).g;
        }
    }
    return reflected / seen;
}

layout(location = 2) uniform int sun; // its place among the lights

void main()
{
#if defined(PEL_CLOUDS) || defined(PEL_FOG)
    veil_lights_evenly();
#endif
    const vec3 n = vec3(0.0, 0.0, 1.0);
    vec3 tx = vec3(wind.xy, 0.0);
    vec3 ty = cross(n, tx);
    vec3 view = vec3(dot(direction, tx), dot(direction, ty), max(direction.z, 1e-3));
    vec3 to = lights[sun].direction.xyz;
    vec3 light = vec3(dot(to, tx), dot(to, ty), to.z);
    float s_view = sqrt(directional_variance(view, slopes));
    float s_light = sqrt(directional_variance(light, slopes));
    vec3 seen, twice;
    reflected_sky(reflection_map, direction, n, tx, ty, view, slopes, waves_resolved(direction, slopes), seen, twice);
    answer[0] = vec4(smith_lambda_cos(view.z, s_view) / view.z,
                     smith_lambda_cos(light.z, s_light) / max(light.z, 1e-4),
                     smith_fresnel(view, slopes), seen.g);
    float reflected = reflected_light(view, light, slopes, lights[sun].limb.w, vec2(0.0), vec2(0.0), 0.0,
                                      patch_frame(mat3(tx, ty, n), NOT_PRESSED, 0.0),
                                      along_sight(view, slopes)).g;
    vec3 h = normalize(view + light);
    answer[1] = vec4(h.z, reflected / max(light.z, 1e-4), reflected, facet_reflectance(dot(view, h)).g);
    answer[2] = vec4(slope_density(-h.xy / max(h.z, 1e-3), slopes));

    answer[3] = vec4(sky_light(eye_table, direction.xy, angle_above_horizon(direction)), 0.0);
    float horizon = horizon_cosine(eye.x);
    answer[4] = vec4(direction.z < horizon ? vec3(0.0)
                                           : transmittance_to_top(transmittance, eye.x, direction.z), 0.0);
    answer[5] = vec4(light_transmittance(transmittance, eye.x, to.z,
                                         lights[sun].direction.w), 0.0);
}
