#version 450 core
// Gain of all orders of scattering after the first, taken as isotropic
// (Hillaire 2020, eq. 5–10), for unit irradiance of a light above the air.
#include "lib/blocks.h"
#include "lib/sky.glsl"

layout(location = 0) out vec4 gain;
layout(binding = PEL_UNIT_TRANSMITTANCE) uniform sampler2D transmittance;

const vec2 SIZE = vec2(PEL_MULTIPLE_SIZE);
const int DIRECTIONS = 10; // squared
const int STEPS = 16;

void main()
{
    vec2 x = clamp((gl_FragCoord.xy - 0.5) / (SIZE - 1.0), 0.0, 1.0);
    float s = 2.0 * x.x - 1.0;
    float light_mu = sign(s) * s * s;
    // How much of a disc has set matters little after two scatterings: the first
    // light's radius serves all.
    float radius = lights[0].direction.w;
    // Never quite on the ground, or rays downward would miss it.
    float h = max(x.y * x.y * (planet.y - planet.x), 1.0);
    float r = planet.x + h;
    vec3 second = vec3(0.0);
    vec3 factor = vec3(0.0);
    float horizon = horizon_cosine(h);
    for (int i = 0; i < DIRECTIONS * DIRECTIONS; i++) {
        // Half of the zeniths above the horizon, half below, dμ ∝ 2|x| dx:
        // finest at the horizon, where air and twilight are.
        float q0 = 1.0 - 2.0 * (float(i / DIRECTIONS) + 0.5) / float(DIRECTIONS);
        float side = q0 > 0.0 ? 1.0 - horizon : 1.0 + horizon;
        float mu = clamp(horizon + side * q0 * abs(q0), -1.0, 1.0);
        float weight = side * 2.0 * abs(q0);
        float phi = PI * (float(i % DIRECTIONS) + 0.5) / float(DIRECTIONS);
        float across = sqrt(1.0 - mu * mu);
        float nu = mu * light_mu + across * cos(phi) * sqrt(max(1.0 - light_mu * light_mu, 0.0));
        float ground = distance_to_ground(h, mu);
        float way = ground > 0.0 ? ground : distance_to_top(h, mu);
        vec3 through = vec3(weight);
        float t0 = 0.0;
        for (int k = 0; k < STEPS; k++) {
            float q = float(k + 1) / float(STEPS);
            float t1 = way * q * q;
            float t = 0.5 * (t0 + t1);
            float ht = max(height_along(h, mu, t), 0.0);
            float mu_t = clamp((r * light_mu + t * nu) / (planet.x + ht), -1.0, 1.0);
            vec3 scatter = rayleigh.rgb * rayleigh_density(ht) + mie.y * mie_density(ht);
            vec3 sigma = extinction(ht);
            vec3 step_through = exp(-sigma * (t1 - t0));
            vec3 share = through * scatter * (1.0 - step_through) / max(sigma, vec3(1e-12));
            second += share * light_transmittance(transmittance, ht, mu_t, radius) / (4.0 * PI);
            factor += share;
            through *= step_through;
            t0 = t1;
        }
        if (ground > 0.0) {
            float mu_g = clamp((r * light_mu + ground * nu) / planet.x, -1.0, 1.0);
            second += through * PEL_SEA_ALBEDO / PI * max(mu_g, 0.0) *
                      light_transmittance(transmittance, 0.0, mu_g, radius);
        }
    }
    float count = float(DIRECTIONS * DIRECTIONS);
    second /= count;
    factor /= count;
    gain = vec4(second / (1.0 - min(factor, vec3(0.98))), 1.0);
}
