// The light a patch of sea sends to the eye: algorithm 5.1 of Bruneton et al.
// 2010. All directions are in the local frame of the patch (z up), `n` its
// mean normal, `variance` its slope variances along and across the wind.

const float MAP_HALF_WIDTH = 1.4; // of the reflection map, horizon at 1
// A flat sea still shows the Sun as a disc: (0.2665° / 2)² / 4 in slopes.
const float MIN_VARIANCE = 2e-6;

vec3 reflected_sky(sampler2D map, vec3 v, vec3 n, vec3 tx, vec3 ty, vec3 view, vec2 variance)
{
    // Facets are seen in proportion to (μ + z)⁺, z their slope towards the
    // eye, μ = cot θ: mean and spread of the visible ones (the moments of
    // eq. 10), where the paper keeps those of all facets.
    float sine = sqrt(max(1.0 - view.z * view.z, 1e-8));
    float mu = max(view.z, 1e-4) / sine;
    vec2 toward = view.xy / sine;
    vec2 conjugate = variance * toward;
    float s2 = dot(conjugate, toward);
    float s = sqrt(s2);
    float a = min(mu / (1.41421356 * s), 6.0);
    float t = 1.0 / (1.0 + 0.3275911 * a);
    float gauss = exp(-a * a);
    float below = 1.0 - 0.5 * gauss * t * (0.254829592 + t * (-0.284496736 +
                  t * (1.421413741 + t * (-1.453152027 + t * 1.061405429))));
    float edge = s * gauss / 2.50662827;
    float seen = mu * below + edge;
    float mean = s2 * below / seen;
    float spread2 = max(s2 * (mu * below + 2.0 * edge) / seen - mean * mean, 1e-8);
    float spread = sqrt(spread2);
    vec2 axis = conjugate / s2; // slope vector that goes with slope 1 towards the eye
    float cross2 = variance.x * variance.y / s2; // variance left across
    // Three Gauss–Hermite nodes along the view, the map's levels across.
    vec3 sum = vec3(0.0);
    float texels = float(textureSize(map, 0).x) / (2.0 * MAP_HALF_WIDTH);
    for (int i = -1; i <= 1; i++) {
        vec2 slope = axis * (mean + float(i) * 1.7320508 * spread);
        vec3 f = normalize(tx * slope.x + ty * slope.y + n);
        float fv = dot(f, v);
        vec3 r = 2.0 * fv * f - v;
        float inverse = 1.0 / (1.0 + max(r.z, -0.3));
        float width = max(4.0 * sqrt(cross2) * abs(fv), 2.0 * spread) * inverse * texels;
        vec2 uv = r.xy * inverse * (0.5 / MAP_HALF_WIDTH) + 0.5;
        vec3 sample_ = textureLod(map, uv, log2(max(width, 1.0))).rgb;
        sum += sample_ * (i == 0 ? 2.0 / 3.0 : 1.0 / 6.0);
    }
    return sum;
}

// Radiance by its way: reflected Sun, reflected sky, out of the water.
struct lit {
    vec3 sun, sky, water;
    float fresnel;
};

lit sea_radiance(sampler2D map, vec3 v, vec3 sun_dir, vec3 n, vec2 variance)
{
    // Facets that face away are reflected into sight (section 3.2).
    float facing = dot(n, v);
    if (facing < 0.0) {
        n -= 2.0 * facing * v;
    }
    variance = max(variance, vec2(MIN_VARIANCE));
    vec3 along = vec3(wind.xy, 0.0);
    vec3 tx = normalize(along - n * dot(n, along));
    vec3 ty = cross(n, tx);
    vec3 view = vec3(dot(v, tx), dot(v, ty), max(dot(v, n), 1e-3));
    vec3 light = vec3(dot(sun_dir, tx), dot(sun_dir, ty), dot(sun_dir, n));
    float s = sqrt(directional_variance(view, variance));
    float fresnel = mean_fresnel(view.z, s);
    vec3 sky = reflected_sky(map, v, n, tx, ty, view, variance);
    vec3 direct = sun_light.rgb * reflected_sun(view, light, variance);
    return lit(direct, fresnel * sky, (1.0 - fresnel) * sea_light.rgb, fresnel);
}
