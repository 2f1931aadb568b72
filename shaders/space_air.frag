#version 450 core
// The air that an eye high up sees by one light, along every sight of its table
// (lib/space.glsl): log2 of the light that is scattered into it, and of what comes
// through.
#define PEL_SPACE
#include "lib/blocks.h"
#include "lib/sky.glsl"

layout(location = 0) out vec4 radiance_out;
layout(location = 1) out vec4 through_out;
layout(binding = PEL_UNIT_TRANSMITTANCE) uniform sampler2D transmittance;
layout(binding = PEL_UNIT_AIRLIGHT) uniform sampler3D airlight;
layout(location = 1) uniform int light;

const float LEAST = 1e-25;

// A place along the sight that steps are counted from, where it is lowest: its
// height, the zenith angles' cosines of sight and light there, distance from the
// eye, and the steps' range.
struct middle {
    float height, mu, light_mu, away, from, to;
};

// Steps are short where the air is dense.
float step_at(middle m, float u)
{
    float v = 2.0 * u - 1.0;
    return m.to <= 0.0     ? m.from * pow(1.0 - u, 2.5)
           : m.from >= 0.0 ? m.to * pow(u, 2.5)
           : v < 0.0       ? m.from * v * v
                           : m.to * v * v;
}

void main()
{
    const float LIMB = float(PEL_SPACE_GROUND_ROWS);
    const float UP = float(PEL_SPACE_GROUND_ROWS + PEL_SPACE_LIMB_ROWS);
    float h = space_eye.x, r = planet.x + h;
    float column = clamp((gl_FragCoord.x - 0.5) / float(PEL_SPACE_COLUMNS - 1), 0.0, 1.0);
    float azimuth = PI * column * column;
    float row = gl_FragCoord.y - 0.5;
    float across, mu;
    middle m = middle(0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
    if (row < LIMB - 0.25) {
        float x = row / (LIMB - 1.0);
        float e = 0.5 * PI * x * x;
        across = planet.x * cos(e) / r;
        mu = -sqrt(max(1.0 - across * across, 0.0));
        m.mu = -sin(e);
        float b = planet.x * sin(e);
        m.away = h * (planet.x + r) / (b + sqrt(b * b + h * (planet.x + r)));
        m.from = -min(m.away, distance_to_top(0.0, -m.mu));
    } else if (row < UP - 0.25) {
        float x = (row - LIMB) / (UP - LIMB - 1.0);
        // At its very top there is no air, and none has a logarithm.
        bool within = h < planet.y - planet.x;
        x = within ? 1.0 - (1.0 - x) * (1.0 - x) : min(x, 0.992);
        m.height = min(space_eye.w * x * x, 0.999999 * space_eye.w);
        float low = planet.x + m.height;
        across = min(low / r, 1.0);
        mu = -sqrt(max(1.0 - across * across, 0.0));
        m.away = sqrt(max((h - m.height) * (r + low), 0.0));
        m.to = distance_to_top(m.height, 0.0);
        m.from = -min(m.away, m.to);
    } else {
        float x = (row - UP) / (float(PEL_SPACE_ROWS) - UP - 1.0);
        mu = sin(0.5 * PI * x * x);
        across = sqrt(max(1.0 - mu * mu, 0.0));
        m.height = h;
        m.mu = mu;
        m.to = h < planet.y - planet.x ? distance_to_top(h, mu) : 0.0;
    }
    vec3 to = space_lights[light].xyz;
    vec2 toward = length(to.xy) > 1e-6 ? normalize(to.xy) : vec2(1.0, 0.0);
    vec3 dir = vec3(across * (toward * cos(azimuth) + vec2(-toward.y, toward.x) * sin(azimuth)), mu);
    float nu = dot(dir, to);
    float low = planet.x + m.height;
    m.light_mu = (r * to.z + m.away * nu) / low;
    float phase_r = rayleigh_phase(nu), phase_m = mie_phase(nu);
    vec3 radiance = vec3(0.0), through = vec3(1.0);
    float s0 = step_at(m, 0.0);
    for (int i = 0; i < PEL_SPACE_STEPS; i++) {
        float s1 = step_at(m, float(i + 1) / float(PEL_SPACE_STEPS));
        float s = 0.5 * (s0 + s1), ds = s1 - s0;
        s0 = s1;
        float ht = max(height_along(m.height, m.mu, s), 0.0);
        float light_mu = clamp((low * m.light_mu + s * nu) / (planet.x + ht), -1.0, 1.0);
        float sight_mu = clamp((low * m.mu + s) / (planet.x + ht), -1.0, 1.0);
        float dr = rayleigh_density(ht), dm = mie_density(ht);
        vec3 scatter_r = rayleigh.rgb * dr;
        float scatter_m = mie.y * dm;
        vec3 sigma = max(scatter_r + mie.x * dm + ozone.rgb * ozone_density(ht), vec3(1e-12));
        vec3 direct = light_transmittance(transmittance, ht, light_mu, lights[light].direction.w);
        float sines = sqrt(max((1.0 - sight_mu * sight_mu) * (1.0 - light_mu * light_mu), 0.0));
        float turn = (nu - sight_mu * light_mu) / max(sines, 1e-6);
        vec3 before = airlight_at(airlight, ht, dr, dm, light_mu, acos(sight_mu),
                                  sqrt(clamp(0.5 - 0.5 * turn, 0.0, 1.0)));
        // The table of it ends where the night is dark.
        before *= exp(min((asin(light_mu) + radians(20.0)) / radians(2.5), 0.0));
        vec3 source = lights[light].irradiance.rgb * (direct * (scatter_r * phase_r + scatter_m * phase_m) +
                                                      before * (scatter_r + scatter_m));
        vec3 step_through = exp(-sigma * ds);
        radiance += through * source * (1.0 - step_through) / sigma;
        through *= step_through;
    }
    radiance_out = vec4(log2(max(radiance, vec3(LEAST))), 1.0);
    through_out = vec4(log2(max(through, vec3(LEAST))), 1.0);
}
