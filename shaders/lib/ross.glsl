// Reflection by a rough sea: Ross, Dion and Potvin 2005 as used in Bruneton et
// al. 2010, sections 4 and 5. Each function has its twin in optics/brdf.h.

// Smith's Λ(a) cos θ, eq. 8, with a = 1 / (√2 s tan θ): finite as cos θ → 0.
// erfc by Abramowitz and Stegun 7.1.26, |error| < 1.5e-7.
float smith_lambda_cos(float cos_theta, float s)
{
    float c = max(cos_theta, 1e-4);
    float sine = sqrt(max(1.0 - c * c, 1e-12));
    float a = min(c / (1.41421356 * s * sine), 6.0);
    float t = 1.0 / (1.0 + 0.3275911 * a);
    float erfcx = t * (0.254829592 + t * (-0.284496736 + t * (1.421413741 +
                  t * (-1.453152027 + t * 1.061405429))));
    return exp(-a * a) * max(1.0 - 1.77245385 * a * erfcx, 0.0) * s * sine / 2.50662827;
}

// The paper's F̄, eq. 26, which validation draws. s: standard deviation of
// slopes in the view direction.
float mean_fresnel(float cos_theta, float s)
{
    return planet.w + (1.0 - planet.w) *
           pow(max(1.0 - cos_theta, 1e-6), 5.0 * exp(PEL_MEAN_FRESNEL_FALL * s)) /
           (1.0 + PEL_MEAN_FRESNEL_ROUGH * s * sqrt(s));
}

// Slope variance in the azimuth of a direction given in tangent space.
float directional_variance(vec3 dir, vec2 variance)
{
    vec2 d2 = dir.xy * dir.xy;
    return dot(variance, d2) / max(d2.x + d2.y, 1e-12);
}

// Gaussian slope density p(ζ), eq. 7.
float slope_density(vec2 slope, vec2 variance)
{
    return exp(-0.5 * dot(slope * slope, 1.0 / variance)) *
           inversesqrt(variance.x * variance.y) / (2.0 * PI);
}

// What displacement of the water towards crests does to that density, twin of
// pel_sharpened: the logarithm and what it is multiplied by; q: slope² over
// variance. `own`, `whole`: of the waves and of the facet.
vec2 sharpened(vec2 own, vec2 whole, vec2 variance, float disc, float fold)
{
    vec2 s2 = own * own;
    float q = dot(s2, 1.0 / (variance + disc));
    float total = variance.x + variance.y;
    float part = fold * total / (total + 2.0 * disc);
    float both = dot(own, whole);
    float w = part * dot(whole, whole);
    float c = part * both;
    float along = 0.33333333 * w + 0.66666667 * c * both / max(s2.x + s2.y, 1e-12);
    float one = 1.0 / (1.0 + w);
    float area = (1.0 + w - c) * (1.0 + w - 0.33333333 * c) * one * one;
    return vec2(min(0.5 * q * along / (1.0 + along), 16.0),
                area * area * inversesqrt((1.0 + w) * (1.0 + 0.33333333 * w)) *
                    (1.0 + 1.33333333 * fold * total));
}

// Reflectance of a facet, whatever it reflects: Fresnel's equations for light
// without polarisation, refraction = n². Twin of pel_fresnel_exact; the paper
// has Schlick's fit, eq. 14.
vec3 facet_reflectance(float cosine)
{
    float c = clamp(cosine, 0.0, 1.0);
#ifdef PEL_PAPER
    float m = 1.0 - c, m2 = m * m;
    return vec3(planet.w + (1.0 - planet.w) * m2 * m2 * m);
#else
    vec3 g = sqrt(refraction.rgb - (1.0 - c * c));
    vec3 s = (g - c) / (g + c);
    vec3 k = refraction.rgb * c;
    vec3 p = (k - g) / (k + g);
    return 0.5 * (s * s + p * p);
#endif
}

#ifdef PEL_OBJECTS
// The same for one colour.
float reflectance_of(float cosine, float n2)
{
    float c = clamp(cosine, 0.0, 1.0);
    float g = sqrt(n2 - (1.0 - c * c));
    float s = (g - c) / (g + c);
    float p = (n2 * c - g) / (n2 * c + g);
    return 0.5 * (s * s + p * p);
}
#endif

// Part of what facets seen at μ mirror at a tangent of η standard deviations
// that no other wave meets; `odds` of escape_odds(μ). Λ by the rational fit of
// Walter et al. 2007. Twin of pel_escape.
float escape_odds(float mu)
{
    float steep = 1.0 + PEL_ESCAPE_VIEW * mu;
    return PEL_ESCAPE_ODDS / (steep * steep);
}

float escape(float eta, float odds)
{
    float a = eta * 0.70710678;
    float rest = a < 1.6 ? max(1.0 - 1.259 * a + 0.396 * a * a, 0.0) * odds : 0.0;
    float risen = max(3.535 * a + 2.181 * a * a, 0.0);
    return eta > 0.0 ? risen / (risen + rest) : 0.0;
}

// A patch of sea: its frame (columns: tangents along and across the wind,
// normal; z is up), and by how much the waves in its normal press the water of
// others together: ∂p.x/∂x, ∂p.y/∂x, ∂p.x/∂y, ∂p.y/∂y of its places p by those
// at rest. `beside`: the share of these waves that the mesh leaves out. Where they
// draw the water out it shows the patch as often as elsewhere, not oftener.
struct patch_frame {
    mat3 axes;
    vec4 pressed;
    float beside;
};

// Slopes of waves add at rest. Of a facet of slopes s in the frame of a patch
// those of the waves that the patch leaves out; `whole`: its slopes to the
// horizontal, also along and across the wind; `stretch`: their area by that of
// s. Twin of pel_own_slope.
vec2 own_slope(vec2 s, patch_frame at, out vec2 whole, out float stretch)
{
    vec3 f = at.axes * vec3(s, 1.0);
    float rise = 1.0 / max(f.z, 0.05);
    vec2 slope = f.xy * rise;
    whole = vec2(dot(slope, wind.xy), dot(slope, vec2(-wind.y, wind.x)));
    vec2 d = slope - at.axes[2].xy / max(at.axes[2].z, 0.05);
    vec2 rest = vec2(dot(at.pressed.xy, d), dot(at.pressed.zw, d));
    float area = at.pressed.x * at.pressed.w - at.pressed.y * at.pressed.z;
    stretch = rise * rise * rise * area * mix(1.0, area, at.beside);
    return vec2(dot(rest, wind.xy), dot(rest, vec2(-wind.y, wind.x)));
}

// What of it is the same for every light.
struct sight_along {
    float cosine, term, deviation, level, mu, steeper;
};

sight_along along_sight(vec3 view, vec2 variance)
{
    sight_along a;
    a.cosine = max(view.z, 1e-4);
    a.deviation = sqrt(directional_variance(view, variance));
    a.term = smith_lambda_cos(view.z, a.deviation);
    a.level = sqrt(max(1.0 - view.z * view.z, 1e-8));
    a.mu = a.cosine / (a.level * a.deviation);
    a.steeper = PEL_SEEN_STEEPER * a.deviation / (1.0 + PEL_SEEN_KNEE * a.mu * a.mu);
    return a;
}

// Radiance of a light's reflection for irradiance 1 normal to its beam: eq. 15,
// its facets and its shadow those that are seen (PEL_SEEN_STEEPER). Its disc, as
// the variance `disc` of slopes that mirror some of it, is folded into the slope
// density (the paper clamps the variance), so that a flat sea shows the disc.
// Twin of pel_glitter. `drawn`: a slope that is added to the facets', drawn from
// a normal distribution of variance `held`; the mean over what is drawn does not
// depend on it. `fold`: of pel_sharpened.
vec3 reflected_light(vec3 view, vec3 light, vec2 variance, float disc, vec2 drawn, vec2 held,
                     float fold, patch_frame at, sight_along eye_)
{
    vec3 h = normalize(view + light);
    float hz = max(h.z, 1e-3);
    float h2 = hz * hz;
    float s_light = sqrt(directional_variance(light, variance));
    float light_term = smith_lambda_cos(light.z, s_light);
    float facing = max(dot(view, h), 1e-4);
    vec3 reflected = facet_reflectance(facing) / (4.0 * h2 * h2);
#ifdef PEL_PAPER
    float p = slope_density(-h.xy / hz - drawn, variance - held + disc);
    float shadow = eye_.cosine + eye_.term + light_term * eye_.cosine / max(light.z, 1e-4);
    return light.z > 0.0 ? p / shadow * reflected : vec3(0.0);
#else
    vec2 slope = view.xy * (eye_.steeper / eye_.level) - h.xy / hz;
    vec2 whole;
    float stretch;
    vec2 own = own_slope(-slope, at, whole, stretch);
    vec2 crisp = sharpened(own, whole, variance, disc, fold);
    vec2 spread = variance - held + disc;
    vec2 off = own + drawn;
    float z = (dot(view.xy, h.xy) / (hz * eye_.level) - eye_.steeper) / eye_.deviation;
    float narrower = PEL_SEEN_NARROWER / (1.0 + 0.25 * eye_.mu * eye_.mu);
    float p = exp(crisp.x - 0.5 * dot(off * off, 1.0 / spread) - 0.5 * narrower * z * z) * crisp.y *
              inversesqrt(spread.x * spread.y) / (2.0 * PI) *
              max(1.0 - eye_.level * eye_.steeper * hz / facing, 0.0) * stretch * (1.0 + 0.5 * narrower);
    float lit = light.z / (light.z + escape_odds(eye_.mu) * light_term);
    return light.z > 0.0 ? p * lit / (eye_.cosine + eye_.term) * reflected : vec3(0.0);
#endif
}
