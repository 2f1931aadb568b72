// The sea as a footprint sees it, twin of ocean/filter.h: eq. 2 and 3 of the
// 2010 paper. A footprint has one length, in metres, for waves of all directions.

struct filtered {
    vec2 slope;
    vec4 fold; // ∂p/∂x = (1 − x, −z, slope.x), ∂p/∂y = (−y, 1 − w, slope.y)
#ifdef PEL_LAYERS
    vec3 shift;
#endif
#ifdef PEL_FOAM
    vec2 breaking; // X, Y of ocean/foam.h
#endif
};

#ifdef PEL_FFT
filtered filtered_sea(vec2 x, float footprint)
{
    filtered f;
    f.slope = vec2(0.0);
    f.fold = vec4(0.0);
#ifdef PEL_LAYERS
    f.shift = vec3(0.0);
#endif
#ifdef PEL_FOAM
    f.breaking = vec2(0.0);
#endif
    reading at = reading_at(x);
    // Nothing is left of a cascade at its coarsest level.
    for (int c = 0; c < PEL_CASCADES; c++) {
        shear(c, x, at);
        float lod = log2(footprint / cascades[c].place.w);
        if (lod + back.w < COARSEST) {
            vec3 uv = vec3(cascade_uv(c, at.place), c);
            vec4 slopes = textureLod(slope_fields, uv, lod + back.w);
            float mixed = textureLod(fold_field, uv, lod + back.w).x;
            f.slope += slopes.x * at.by.xy + slopes.y * at.by.zw;
            f.fold -= vec4(slopes.z, mixed, mixed, slopes.w);
#ifdef PEL_FOAM
            if (c < 2) {
                f.breaking += textureLod(breaking_fields, uv, lod + back.w).xy;
            }
#endif
#ifdef PEL_LAYERS
            f.shift += cascade_displacement(c, uv.xy, lod + back.w - PEL_SHIFT_SHARPER);
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

filtered filtered_sea(vec2 x, float footprint)
{
    float scale = up.w / footprint;
    float offset = -right.w * up.w;
    float length2 = footprint * footprint;
    filtered f;
    f.slope = vec2(0.0);
    f.fold = vec4(0.0);
#ifdef PEL_LAYERS
    f.shift = vec3(0.0);
#define PEL_SHIFT(phase, wander)                                               \
    f.shift += (w * wander.w) * vec3((-chop * sc.x) * phase.xy, sc.y);
#else
#define PEL_SHIFT(phase, wander)
#endif
#ifdef PEL_FOAM
    f.breaking = vec2(0.0);
#define PEL_BREAKING(phase, wander)                                            \
    f.breaking += sc.yx * (phase.w >= PEL_FOAM_SHORTEST_M ? gain * wander.w / phase.w : 0.0);
#else
#define PEL_BREAKING(phase, wander)
#endif
#define PEL_SLOPE(phase, wander)                                               \
    float w = filter_weight(phase.w * scale + offset);                         \
    float gain = w * footprint_mean(length2 * dot(phase.xy, phase.xy));        \
    float chop = wave_chop(phase);                                             \
    vec3 at = wandered(wander, x);                                             \
    vec2 sc = sine_cosine_turns(wave_turns(phase, x, at));                     \
    vec2 hk = (gain * wander.w) * wave_vector(phase, wander, at);              \
    f.fold += (chop * sc.y) * (phase.xxyy * hk.xyxy);                          \
    f.slope -= sc.x * hk;                                                      \
    PEL_SHIFT(phase, wander)                                                   \
    PEL_BREAKING(phase, wander)
    PEL_EACH_WAVE(PEL_SLOPE)
#ifdef PEL_LAYERS
    f.shift *= 0.159154943; // 1 / 2π
#endif
    return f;
}
#endif

// ∂p/∂x × ∂p/∂y, eq. 3.
vec3 filtered_normal(filtered f)
{
    return normalize(vec3(-f.fold.z * f.slope.y - f.slope.x * (1.0 - f.fold.w),
                          -f.fold.y * f.slope.x - f.slope.y * (1.0 - f.fold.x),
                          max((1.0 - f.fold.x) * (1.0 - f.fold.w) - f.fold.y * f.fold.z, 1e-3)));
}
