#version 450 core
// Sky table of an eye for one light. Above the horizon: radiance of the sky
// without the disc. Below: the radiance a way through this air tends to (its
// equilibrium) and its mean extinction, from which a shorter way follows.
#include "lib/blocks.h"
#include "lib/sky.glsl"
#include "lib/march.glsl"

layout(location = 0) out vec4 radiance_out;
layout(location = 1) out vec4 extinction_out;
layout(binding = PEL_UNIT_TRANSMITTANCE) uniform sampler2D transmittance;
layout(binding = PEL_UNIT_AIRLIGHT) uniform sampler3D airlight;
layout(location = 0) uniform vec2 table_size;
layout(location = 1) uniform int light;
#ifdef PEL_PANORAMA
#include "lib/panorama.glsl"
#endif
#ifdef PEL_NIGHT
layout(binding = PEL_UNIT_NIGHT) uniform sampler2D night_zonal; // by elevation
layout(location = 2) uniform vec3 night_air;
#endif

const int STEPS = 32;

void main()
{
    float h = lut.x;
    float column = clamp((gl_FragCoord.x - 0.5) / (table_size.x - 1.0), 0.0, 1.0);
    float azimuth = PI * column * column;
    float rows = 0.5 * table_size.y;
    bool above = gl_FragCoord.y > rows;
    float x = above ? (gl_FragCoord.y - 0.5 - rows) / (rows - 1.0)
                    : (rows - 0.5 - gl_FragCoord.y) / (rows - 1.0);
    float angle = 0.5 * PI * x * x * (above ? 1.0 : -1.0);
    float zenith = acos(clamp(horizon_cosine(h), -1.0, 1.0)) - angle;
    zenith = clamp(zenith, 0.0, PI);
    float mu = cos(zenith);
    float across = sin(zenith);
    vec2 level = lights[light].direction.xy;
    vec2 toward = length(level) > 1e-6 ? normalize(level) : vec2(1.0, 0.0);
    vec3 dir = vec3(across * (toward * cos(azimuth) + vec2(-toward.y, toward.x) * sin(azimuth)), mu);
    float ground = above ? -1.0 : distance_to_ground(h, min(mu, horizon_cosine(h) - 1e-7));
    float way = ground > 0.0 ? ground
                : above      ? distance_to_top(h, mu)
                             : sqrt(h * (2.0 * planet.x + h));
    vec3 radiance, through;
    integrate_ray(light, transmittance, airlight, h, dir, way, STEPS, radiance, through);
#ifdef PEL_NIGHT
    if (light == 0) {
        float row = (sqrt(max(angle, 0.0) * (2.0 / PI)) * float(PEL_NIGHT_MAP_ROWS - 1) + 0.5) / float(PEL_NIGHT_MAP_ROWS);
        radiance += above ? textureLod(night_zonal, vec2(0.5, row), 0.0).rgb : night_air * (1.0 - through);
    }
#endif
#ifdef PEL_PANORAMA
    // All of it is the first light's, the mean of both sides of that: 4 degrees.
    radiance = vec3(0.0);
    if (light == 0) {
        vec2 other = 2.0 * toward * dot(toward, dir.xy) - dir.xy;
        float from = above ? zenith : 0.5 * PI;
        float up = above ? angle : 0.0;
        radiance = 0.5 * (panorama_at(dir.xy, from, up, 0.07) + panorama_at(other, from, up, 0.07)) *
                   (above ? vec3(1.0) : 1.0 - through);
    }
#endif
    if (above) {
        radiance_out = vec4(radiance, 1.0);
        extinction_out = vec4(0.0);
    } else {
        // Never none: the logarithm of 0 would spoil the table's neighbours.
        through = clamp(through, vec3(1e-30), vec3(0.999999));
        radiance_out = vec4(radiance / (1.0 - through), 1.0);
        extinction_out = vec4(-log(through) / way, 1.0);
    }
}
