#version 450 core
// What a ray from one wave sees of another, by its azimuth and by the tangent of
// its elevation in standard deviations of slopes, η (section 6 of the 2010
// paper, which takes the mirrored sky): the facets that face it, in proportion to
// (z − η)⁺ p(z) by their slope z towards it, mirror the sky at the tangent
// 2 z − η, or show the water. In alpha, for the Sun in them (mirrored_twice), its
// part that is not hidden by the part of their area that is shown.
#include "lib/blocks.h"
#include "lib/sky.glsl"
#include "lib/ross.glsl"

layout(location = 0) out vec4 radiance;
#if defined(PEL_CLOUDS) || defined(PEL_FOG)
layout(binding = PEL_UNIT_REFLECTION) uniform sampler2D reflection_map;
#else
layout(binding = PEL_UNIT_SKY_TABLE) uniform sampler2DArray sky_table;
#endif

const int STEPS = 12;
const float REACH = 3.5;

// `shown`: the mean slope towards the ray of the facets that it meets.
float sunlit(vec3 ray, float shown)
{
    vec3 to = lights[PEL_LIGHT_FIRST].direction.xyz;
    vec2 beam = vec2(dot(to.xy, wind.xy), dot(to.xy, vec2(-wind.y, wind.x)));
    float s_light = sqrt(max(directional_variance(vec3(beam, 0.0), wind.zw), 1e-8));
    float lit = escape(to.z * inversesqrt(max(1.0 - to.z * to.z, 1e-4)) / s_light, escape_odds(0.7));
    return min(lit * sqrt(dot(ray, ray)) / (4.0 * shown), 1e4);
}

void main()
{
    vec2 u = gl_FragCoord.xy / float(PEL_SECOND_SIZE) * 2.0 - 1.0;
    float radius = max(length(u), 1e-3);
    vec2 away = u / radius;
    float place = (radius - PEL_SECOND_INNER) / (1.0 - 1.0 / float(PEL_SECOND_SIZE) - PEL_SECOND_INNER);
    float eta = PEL_SECOND_FIRST + PEL_SECOND_SPAN * clamp(place, 0.0, 1.0);
    vec2 by_wind = vec2(dot(away, wind.xy), dot(away, vec2(-wind.y, wind.x)));
    float s2 = max(directional_variance(vec3(by_wind, 0.0), wind.zw), 1e-8);
    float s = sqrt(s2), cross2 = wind.z * wind.w / s2;
    float from = max(eta, -REACH);
    float step_ = (REACH - from) / float(STEPS);
    vec3 sum = vec3(0.0);
    float seen = 0.0;
    for (int i = 0; i < STEPS; i++) {
        float z = from + (float(i) + 0.5) * step_;
        float weight = (z - eta) * exp(-0.5 * z * z);
        float cosine = (z - eta) * s * inversesqrt((1.0 + s2 * z * z + cross2) * (1.0 + s2 * eta * eta));
        vec3 fresnel = facet_reflectance(cosine);
#if defined(PEL_CLOUDS) || defined(PEL_FOG)
        float rise = max(s * (2.0 * z - eta), 0.0);
        // Stereographic, as reflection.frag has it.
        float r = inversesqrt(1.0 + rise * rise);
        vec2 uv = away * (r / (1.0 + rise * r)) * (0.5 / PEL_REFLECTION_HALF_WIDTH) + 0.5;
        vec3 sky = textureLod(reflection_map, uv, 2.0).rgb;
#else
        vec3 sky = sky_light(sky_table, away, max(atan(s * (2.0 * z - eta)), 0.0));
#endif
        sum += weight * mix(sea_light.rgb, sky, fresnel);
        seen += weight;
    }
    radiance = vec4(sum / seen, sunlit(vec3(away, s * eta), s * seen * step_ / sqrt(2.0 * PI)));
}
