// The sea as a footprint sees it, twin of ocean/filter.h: eq. 2 and 3 of the
// 2010 paper. A footprint has a length along a direction `sight` and one across
// it; PEL_ANISOTROPY is the most that one may exceed the other, and where it is
// 1 the footprint is as long in all directions as along.
#ifndef PEL_ANISOTROPY
#define PEL_ANISOTROPY 1
#endif

struct filtered {
    vec2 slope;
    vec3 fold; // A, B, C: ∂p/∂x = (1 − A, −B, slope.x), ∂p/∂y = (−B, 1 − C, slope.y)
#ifdef PEL_LAYERS
    vec3 shift;
#endif
};

#ifdef PEL_FFT
filtered filtered_sea(vec2 x, vec2 sight, float along, float across)
{
    filtered f;
    f.slope = vec2(0.0);
    f.fold = vec3(0.0);
#ifdef PEL_LAYERS
    f.shift = vec3(0.0);
#endif
    reading at = reading_at(x);
    // Nothing is left of a cascade at its coarsest level.
    for (int c = 0; c < PEL_CASCADES; c++) {
        shear(c, x, at);
#if PEL_ANISOTROPY > 1
        // Taps along the line of sight, together as wide as the level of
        // detail of that length.
        float texel = cascades[c].place.w;
        float least = max(across, 1.5 * texel);
        float taps = clamp(ceil(along / least), 1.0, float(PEL_ANISOTROPY));
        float lod = log2(across / texel);
        vec2 span = sight * (PEL_TAP_SPAN * sqrt(max(along * along - least * least, 0.0)));
        vec2 along_read = at.by.xz * span.x + at.by.yw * span.y;
        float share = 1.0 / taps;
        taps = lod + back.w < COARSEST ? taps : 0.0;
        for (float j = 0.5; j < taps; j += 1.0) {
            vec2 place = at.place + along_read * (j * share - 0.5);
#else
        float lod = log2(along / cascades[c].place.w);
        const float share = 1.0;
        if (lod + back.w < COARSEST) {
            vec2 place = at.place;
#endif
            vec3 uv = vec3(cascade_uv(c, place), c);
            vec4 slopes = textureLod(slope_fields, uv, lod + back.w);
            float mixed = textureLod(fold_field, uv, lod + back.w).x;
            slopes *= share;
            mixed *= share;
            f.slope += slopes.x * at.by.xy + slopes.y * at.by.zw;
            f.fold -= vec3(slopes.z, mixed, slopes.w);
#ifdef PEL_LAYERS
            f.shift += share * cascade_displacement(c, uv.xy, lod + back.w - PEL_SHIFT_SHARPER);
#endif
        }
    }
    return f;
}
#else
// sin(x)/x, the mean of a wave over a footprint, by (ℓ/λ)²: pel_filter_gain.
float footprint_mean(float y)
{
    return 1.0 - y * (1.6449 - 0.78 * y);
}

filtered filtered_sea(vec2 x, vec2 sight, float along, float across)
{
#if PEL_ANISOTROPY > 1
    // p = (λ's projections) / λ²: |p|² is (ℓ / λ)².
    vec2 lengthwise = sight * along;
    vec2 crosswise = vec2(-sight.y, sight.x) * across;
    float scale = up.w / across;
#define PEL_WEIGHT(i)                                                          \
    vec2 p = vec2(dot(waves[i].phase.xy, lengthwise), dot(waves[i].phase.xy, crosswise)); \
    float y = dot(p, p);                                                       \
    float w = filter_weight(inversesqrt(y) * up.w + offset);                    \
    float gain = w * footprint_mean(y);
#else
    float scale = up.w / along;
#define PEL_WEIGHT(i)                                                          \
    float y = along * waves[i].fold.w;                                         \
    float w = filter_weight(waves[i].phase.w * scale + offset);                 \
    float gain = w * footprint_mean(y * y);
#endif
    float offset = -right.w * up.w;
    filtered f;
    f.slope = vec2(0.0);
    f.fold = vec3(0.0);
#ifdef PEL_LAYERS
    f.shift = vec3(0.0);
#define PEL_SHIFT(i, s, c) f.shift += vec3(-waves[i].shift.xy * (w * s), waves[i].shift.z * (w * c));
#else
#define PEL_SHIFT(i, s, c)
#endif
#define PEL_SLOPE(i)                                                           \
    {                                                                          \
        PEL_WEIGHT(i)                                                          \
        float turns = dot(waves[i].phase.xy, x) + waves[i].phase.z;              \
        float s = sine_turns(turns);                                           \
        float c = sine_turns(turns + 0.25);                                    \
        f.fold += waves[i].fold.xyz * (gain * c);                               \
        f.slope -= waves[i].slope.xy * (gain * s);                              \
        PEL_SHIFT(i, s, c)                                                     \
    }
    PEL_EACH_WAVE(PEL_SLOPE)
    return f;
}
#endif

// ∂p/∂x × ∂p/∂y, eq. 3.
vec3 filtered_normal(filtered f)
{
    return normalize(vec3(-f.fold.y * f.slope.y - f.slope.x * (1.0 - f.fold.z),
                          -f.fold.y * f.slope.x - f.slope.y * (1.0 - f.fold.x),
                          max((1.0 - f.fold.x) * (1.0 - f.fold.z) - f.fold.y * f.fold.y, 1e-3)));
}
