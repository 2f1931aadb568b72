// The light a patch of sea sends to the eye: algorithm 5.1 of Bruneton et al.
// 2010. All directions are in the local frame of the patch (z up), `n` its
// mean normal, `variance` its slope variances along and across the wind.

const float MIN_VARIANCE = 1e-8; // of slopes, against division by zero

// Square of the cosine between a direction's azimuth and the wind's.
float along_wind(vec3 direction)
{
    float along = dot(direction.xy, wind.xy);
    return along * along / max(dot(direction.xy, direction.xy), 1e-12);
}

#ifndef PEL_PAPER // validation draws by the paper as it stands
layout(binding = PEL_UNIT_FACETS) uniform samplerBuffer facet_texels; // nodes and weights in turn
layout(binding = PEL_UNIT_SECOND) uniform sampler2D second_map;

// What a ray towards the azimuth `away` at a tangent of η standard deviations
// sees of other waves; in alpha what the Sun in them is, for a beam of 1, times
// density of slopes and reflectance (mirrored_twice).
vec4 second_reflection(vec2 away, float eta)
{
    float place = clamp((eta - PEL_SECOND_FIRST) / PEL_SECOND_SPAN, 0.0, 1.0);
    float radius = mix(PEL_SECOND_INNER, 1.0 - 1.0 / float(PEL_SECOND_SIZE), place);
#ifdef PEL_SPACE
    return space_second(away, radius);
#else
    return textureLod(second_map, 0.5 + 0.5 * radius * away, 0.0);
#endif
}

// Waves that the pixel resolves hide what its facets mirror, too. Of those in
// sight: 1 / s of them, between that of the waves that it resolves and that of
// all so that the two steps hide what one would (docs/physics/light.md);
// escape_odds: 1 / s of all.
vec3 waves_resolved(vec3 v, vec2 variance)
{
    float share = along_wind(v);
    float whole = max(mix(wind.w, wind.z, share), MIN_VARIANCE);
    float resolved = max(whole - mix(variance.y, variance.x, share), 1e-8);
    float inverse = inversesqrt(sqrt(resolved * whole));
    float mu = max(v.z, 0.0) * inversesqrt(max(1.0 - v.z * v.z, 1e-8)) * inverse;
    return vec3(inverse, escape_odds(mu), inversesqrt(whole));
}

// The Sun in the facets that rays about r meet, for a beam of 1; `shown`: alpha of
// second_reflection. The rays come from facets whose slopes across the view have
// the variance cross2, so they point to both sides of the Sun, whose path on
// what they meet is narrow: the density of slopes is widened by what that turns
// the facet that mirrors it, and reflectance is of the likeliest of these.
float mirrored_twice(vec3 r, vec3 v, float cross2, float shown)
{
    vec3 ray = r * inversesqrt(max(dot(r, r), 1e-12));
#ifdef PEL_SPACE
    vec3 to = space_to[PEL_LIGHT_FIRST];
#else
    vec3 to = lights[PEL_LIGHT_FIRST].direction.xyz;
#endif
    vec3 sum = to - ray, half_ = ray + v;
    float up = max(sum.z, 0.02);
    float turned = cross2 * dot(half_, half_) / (up * up * max(dot(ray.xy, ray.xy), 1e-4));
    vec2 side = vec2(-wind.y, wind.x);
    vec2 slope = vec2(dot(sum.xy, wind.xy), dot(sum.xy, side)) / up;
    vec2 wide = vec2(dot(vec2(-ray.y, ray.x), wind.xy), dot(vec2(-ray.y, ray.x), side));
    vec2 own = max(wind.zw, vec2(1e-8)) + lights[PEL_LIGHT_FIRST].limb.w;
    vec3 spread = vec3(own, 0.0) + turned * vec3(wide * wide, wide.x * wide.y);
    float det = own.x * own.y + turned * (own.x * wide.y * wide.y + own.y * wide.x * wide.x);
    vec2 g = vec2(spread.y * slope.x - spread.z * slope.y, spread.x * slope.y - spread.z * slope.x) / det;
    vec2 likeliest = own * g;
    float steep = 1.0 + dot(likeliest, likeliest);
    float p = exp(-0.5 * dot(slope, g)) * inversesqrt(det) / (2.0 * PI);
    float seen = shown * p * facet_reflectance(0.5 * up * sqrt(steep)).g * steep * steep;
    return sum.z > 0.02 ? seen : 0.0;
}

// Reflected sky radiance, and in `fresnel` the reflectance it was weighted
// with; `twice`: of the Sun mirrored by two waves, by its irradiance. The
// integral of eq. 20 over visible facets, Fresnel's term inside it,
// along the view by three nodes of facets that mirror the sky and one of facets
// that mirror other waves (optics/facets.h); across it by the levels of the map.
// The paper takes the product of two means instead (eq. 21), F̄ by a fit (eq. 26).
vec3 reflected_sky(sampler2D map, vec3 v, vec3 n, vec3 tx, vec3 ty, vec3 view, vec2 variance,
                   vec3 resolved, out vec3 fresnel, out vec3 twice)
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
    vec4 nodes = mix(texelFetch(facet_texels, 2 * entry), texelFetch(facet_texels, 2 * entry + 2), f_place);
    vec4 weights = mix(texelFetch(facet_texels, 2 * entry + 1), texelFetch(facet_texels, 2 * entry + 3), f_place);
    vec3 sum = vec3(0.0), lost = vec3(0.0);
    vec3 lost_ray = vec3(0.0);
    float lost_tangent = 0.0;
    fresnel = vec3(0.0);
#ifdef PEL_SPACE
    const float texels = float(PEL_SPACE_MAP) / (2.0 * PEL_REFLECTION_HALF_WIDTH);
#else
    float texels = float(textureSize(map, 0).x) / (2.0 * PEL_REFLECTION_HALF_WIDTH);
#endif
    for (int i = 0; i < 4; i++) {
        vec2 slope = axis * nodes[i];
        vec3 facet = tx * slope.x + ty * slope.y + n;
        // The mean over slopes across the view: their normals are nearer the
        // horizontal, so are their reflections.
        vec3 f = facet * inversesqrt(dot(facet, facet) + cross2);
        float fv = dot(f, v);
        vec3 share = facet_reflectance(fv) * weights[i];
        fresnel += share;
        vec3 r = 2.0 * fv * f - v;
        float tangent = r.z * inversesqrt(max(1.0 - r.z * r.z, 1e-4));
        float met = 1.0;
        if (i < 3) {
            met -= escape(tangent * resolved.x, resolved.y);
            float inverse = 1.0 / (1.0 + max(r.z, 0.0));
            float width = max(1.0 * sqrt(cross2) * abs(fv), 0.3 * s) * inverse * texels;
#ifdef PEL_SPACE
            vec3 sample_ = space_sky(r.xy * inverse, log2(max(width, 1.0)));
#else
            vec2 uv = r.xy * inverse * (0.5 / PEL_REFLECTION_HALF_WIDTH) + 0.5;
            vec3 sample_ = textureLod(map, uv, log2(max(width, 1.0))).rgb;
#endif
            sum += sample_ * share * (1.0 - met);
        }
        lost += share * met;
        lost_tangent += share.g * met * tangent;
        lost_ray += share.g * met * r;
    }
    vec2 away = -v.xy * inversesqrt(max(dot(v.xy, v.xy), 1e-8));
    float eta = lost_tangent / max(lost.g, 1e-9) * resolved.z;
    vec4 second = second_reflection(away, eta);
    twice = lost * mirrored_twice(lost_ray, v, cross2, second.a);
#ifdef PEL_OBJECTS
    return with_objects(map, sum, v, n, tx, ty, axis, s, cross2, mu, resolved, fresnel / fresnel.g, lost, eta, second.rgb);
#else
    return sum + lost * second.rgb;
#endif
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
                   vec3 resolved, out vec3 fresnel, out vec3 twice)
{
    const float EPSILON = 1e-3;
    vec2 s = sqrt(variance);
    twice = vec3(0.0);
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

// Waves that the pixel resolves but not the mesh turn its normal as often away
// from the eye as towards it; those that turn towards it show more of
// themselves. What their mean slope towards the eye is then, by their variance:
// s / √(μ² + 2/π), 0 to 8 % above the mean of (μ + y)⁺ p(y). `facing`: cosine
// between the sight and the facet of the mesh that carries them.
vec3 toward_sight(vec3 v, float facing, vec2 variance)
{
    float s2 = max(mix(variance.y, variance.x, along_wind(v)), 0.0);
    float sine2 = max(1.0 - v.z * v.z, 1e-8);
    return vec3(v.xy * (s2 * inversesqrt(facing * facing + 0.64 * s2 * sine2 + 1e-12)), 0.0);
}

// Facets that face away are reflected into sight (section 3.2).
vec3 facet_in_sight(vec3 n, vec3 v)
{
    return n - 2.0 * min(dot(n, v), 0.0) * v;
}

const vec4 NOT_PRESSED = vec4(1.0, 0.0, 0.0, 1.0);

// `leaving`: of the water there (leaving_water); `tilt`: of the patch's up;
// `glint`: of glint_slopes, and the share of the variance that it stands for;
// `pressed`, `beside`: of the patch_frame.
lit sea_radiance(sampler2D map, vec3 v, vec2 tilt, vec3 n, vec2 variance, vec3 leaving, vec3 glint,
                 vec4 pressed, float beside)
{
    variance = max(variance, vec2(MIN_VARIANCE));
    vec3 along = vec3(wind.xy, 0.0);
    vec3 tx = normalize(along - n * dot(n, along));
    vec3 ty = cross(n, tx);
    vec3 view = vec3(dot(v, tx), dot(v, ty), max(dot(v, n), 1e-3));
    vec3 fresnel, twice;
#ifdef PEL_PAPER
    const vec3 resolved = vec3(0.0);
#else
    vec3 resolved = waves_resolved(v, variance);
#endif
    vec3 sky = reflected_sky(map, v, n, tx, ty, view, variance, resolved, fresnel, twice);
    patch_frame at = patch_frame(mat3(tx, ty, n), pressed, beside);
    vec2 held = variance * glint.z;
    vec2 drawn = glint.xy * sqrt(held);
    float fold = crests.x + crests.y * (variance.x + variance.y);
    sight_along eye_ = along_sight(view, variance);
    vec3 direct = beam_there(PEL_LIGHT_FIRST) * twice;
    for (int i = 0; i < PEL_LIT; i++) {
        vec3 to = light_above(i, tilt);
        vec3 light = vec3(dot(to, tx), dot(to, ty), dot(to, n));
        vec3 one = beam_there(i) *
                   reflected_light(view, light, variance, lights[i].limb.w, drawn, held, fold,
                                   at, eye_);
#ifdef PEL_OBJECTS
        one *= i == PEL_LIGHT_FIRST ? sea_lit : 1.0;
#endif
#ifndef PEL_PAPER
        one *= escape(to.z * inversesqrt(max(1.0 - to.z * to.z, 1e-4)) * resolved.x, resolved.y);
#endif
        direct += one;
    }
#ifdef PEL_LAMPS
    for (uint left = lamps_likely(v, tilt, tx, ty, n, view, variance, drawn, held, fold, at, eye_); left != 0u;
         left &= left - 1u) {
        direct += lamp_mirrored(findLSB(left), v, tilt, tx, ty, n, view, variance, drawn, held, fold, at,
                                eye_);
    }
#endif
    lit result;
    result.sun = direct;
    result.sky = sky;
    result.fresnel = fresnel;
    result.water = (1.0 - fresnel) * leaving;
    return result;
}
