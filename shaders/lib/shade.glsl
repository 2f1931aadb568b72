// The light a patch of sea sends to the eye: algorithm 5.1 of Bruneton et al.
// 2010. All directions are in the local frame of the patch (z up), `n` its
// mean normal, `variance` its slope variances along and across the wind.

const float MIN_VARIANCE = 1e-8; // of slopes, against division by zero

#ifndef PEL_PAPER // validation draws by the paper as it stands
layout(binding = PEL_UNIT_FACETS) uniform samplerBuffer facet_texels; // nodes and weights in turn

// Reflected sky radiance, and in `fresnel` the reflectance it was weighted
// with. The integral of eq. 20 over visible facets, Fresnel's term inside it,
// by three Gauss nodes along the view (optics/facets.h); across it by the levels
// of the map. The paper takes the product of two means instead (eq. 21), F̄ by a fit
// (eq. 26) that is a tenth too high at steep angles and a fifth near the
// horizon.
vec3 reflected_sky(sampler2D map, vec3 v, vec3 n, vec3 tx, vec3 ty, vec3 view, vec2 variance,
                   out vec3 fresnel)
{
    float sine = sqrt(max(1.0 - view.z * view.z, 1e-8));
    vec2 toward = view.xy / sine;
    vec2 conjugate = variance * toward;
    float s2 = dot(conjugate, toward);
    float s = sqrt(s2);
    vec2 axis = conjugate / s;              // slopes of one node unit
    float cross2 = variance.x * variance.y / s2; // variance left across
    float mu = view.z / (sine * s);
    float place = mu / (1.0 + mu) * float(PEL_FACET_STEPS);
    int entry = min(int(place), PEL_FACET_STEPS - 1);
    float f_place = place - float(entry);
    vec3 nodes = mix(texelFetch(facet_texels, 2 * entry).xyz,
                     texelFetch(facet_texels, 2 * entry + 2).xyz, f_place);
    vec3 weights = mix(texelFetch(facet_texels, 2 * entry + 1).xyz,
                       texelFetch(facet_texels, 2 * entry + 3).xyz, f_place);
    vec3 sum = vec3(0.0);
    fresnel = vec3(0.0);
    float texels = float(textureSize(map, 0).x) / (2.0 * PEL_REFLECTION_HALF_WIDTH);
    for (int i = 0; i < 3; i++) {
        vec2 slope = axis * nodes[i];
        vec3 facet = tx * slope.x + ty * slope.y + n;
        float facet2 = dot(facet, facet);
        vec3 f = facet * inversesqrt(facet2);
        float fv = dot(f, v);
        vec3 share = facet_reflectance(fv * inversesqrt(1.0 + cross2 / facet2)) * weights[i];
        fresnel += share;
        vec3 r = 2.0 * fv * f - v;
        float inverse = 1.0 / (1.0 + max(r.z, -0.3));
        float width = max(4.0 * sqrt(cross2) * abs(fv), 1.5 * s) * inverse * texels;
        vec2 uv = r.xy * inverse * (0.5 / PEL_REFLECTION_HALF_WIDTH) + 0.5;
        vec3 sample_ = textureLod(map, uv, log2(max(width, 1.0))).rgb;
        sum += sample_ * share;
    }
    return sum;
}
#else
// U(ζ) of algorithm 5.1: where in the map the facet of slopes ζ mirrors.
vec2 mirrored(vec2 slope, vec3 v, vec3 n, vec3 tx, vec3 ty)
{
    vec3 f = normalize(n - slope.x * tx - slope.y * ty);
    vec3 r = 2.0 * dot(f, v) * f - v;
    return r.xy / (1.0 + max(r.z, -0.3)) * (0.5 / PEL_REFLECTION_HALF_WIDTH) + 0.5;
}

// The paper's product of means, eq. 21: F̄ by its fit, L̄ by the map over an
// ellipse of twice the standard deviations (eq. 27), as the mean of nine samples
// inside it.
vec3 reflected_sky(sampler2D map, vec3 v, vec3 n, vec3 tx, vec3 ty, vec3 view, vec2 variance,
                   out vec3 fresnel)
{
    const float EPSILON = 1e-3;
    vec2 s = sqrt(variance);
    fresnel = vec3(mean_fresnel(view.z, sqrt(directional_variance(view, variance))));
    vec2 u0 = mirrored(vec2(0.0), v, n, tx, ty);
    vec2 ux = 2.0 * s.x * (mirrored(vec2(EPSILON, 0.0), v, n, tx, ty) - u0) / EPSILON;
    vec2 uy = 2.0 * s.y * (mirrored(vec2(0.0, EPSILON), v, n, tx, ty) - u0) / EPSILON;
    // A standard deviation apart; each stands for its surroundings.
    float texels = 0.5 * float(textureSize(map, 0).x);
    float level = log2(max(texels * sqrt(length(ux) * length(uy)), 1.0));
    vec3 sum = vec3(0.0);
    for (int j = -1; j <= 1; j++) {
        for (int i = -1; i <= 1; i++) {
            sum += textureLod(map, u0 + 0.5 * (ux * float(i) + uy * float(j)), level).rgb;
        }
    }
    return fresnel / 9.0 * sum;
}
#endif

// Radiance by its way: reflected lights, reflected sky, out of the water.
struct lit {
    vec3 sun, sky, water; // `sun`: of every light, as the layer is called
    vec3 fresnel;
};

// Facets that face away are reflected into sight (section 3.2).
vec3 facet_in_sight(vec3 n, vec3 v)
{
    return n - 2.0 * min(dot(n, v), 0.0) * v;
}

// `leaving`: of the water there (leaving_water); `tilt`: of the patch's up;
// `glint`: of glint_slopes, and the share of the variance that it stands for.
lit sea_radiance(sampler2D map, vec3 v, vec2 tilt, vec3 n, vec2 variance, vec3 leaving, vec3 glint)
{
    variance = max(variance, vec2(MIN_VARIANCE));
    vec3 along = vec3(wind.xy, 0.0);
    vec3 tx = normalize(along - n * dot(n, along));
    vec3 ty = cross(n, tx);
    vec3 view = vec3(dot(v, tx), dot(v, ty), max(dot(v, n), 1e-3));
    vec3 fresnel;
    vec3 sky = reflected_sky(map, v, n, tx, ty, view, variance, fresnel);
    vec2 held = variance * glint.z;
    vec2 drawn = glint.xy * sqrt(held);
    vec3 direct = vec3(0.0);
    for (int i = 0; i < PEL_LIGHTS; i++) {
        vec3 to = light_above(i, tilt);
        vec3 light = vec3(dot(to, tx), dot(to, ty), dot(to, n));
        direct += beams[i].rgb * 
                  reflected_light(view, light, variance, lights[i].limb.w, drawn, held);
    }
    lit result;
    result.sun = direct;
    result.sky = sky;
    result.fresnel = fresnel;
    result.water = (1.0 - fresnel) * leaving;
    return result;
}
