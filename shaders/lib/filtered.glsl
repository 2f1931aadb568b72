// The sea as a footprint sees it, twin of ocean/filter.h: eq. 2 and 3 of the
// 2010 paper. A footprint has one length, in metres, for waves of all directions.

struct filtered {
    vec2 slope;
    vec3 fold; // A, B, C: ∂p/∂x = (1 − A, −B, slope.x), ∂p/∂y = (−B, 1 − C, slope.y)
#ifdef PEL_LAYERS
    vec3 shift;
#endif
};

#ifdef PEL_FFT
filtered filtered_sea(vec2 x, float footprint)
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
        float lod = log2(footprint / cascades[c].place.w);
        if (lod + back.w < COARSEST) {
            vec3 uv = vec3(cascade_uv(c, at.place), c);
            vec4 slopes = textureLod(slope_fields, uv, lod + back.w);
            float mixed = textureLod(fold_field, uv, lod + back.w).x;
            f.slope += slopes.x * at.by.xy + slopes.y * at.by.zw;
            f.fold -= vec3(slopes.z, mixed, slopes.w);
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
    f.fold = vec3(0.0);
#ifdef PEL_LAYERS
    f.shift = vec3(0.0);
#define PEL_SHIFT(phase, size)                                                 \
    f.shift += vec3(phase.xy * (size.y * (w * -s)), size.x * (w * c));
#else
#define PEL_SHIFT(phase, size)
#endif
#define PEL_SLOPE(phase, size)                                                 \
    float w = filter_weight(phase.w * scale + offset);                         \
    vec3 kk = phase.xxy * phase.xyy;                                           \
    float gain = w * footprint_mean(length2 * (kk.x + kk.z));                  \
    float turns = dot(phase.xy, x) + phase.z;                                  \
    float s = sine_turns(turns);                                               \
    float c = sine_turns(turns + 0.25);                                        \
    f.fold += kk * (size.y * (gain * c));                                      \
    f.slope -= phase.xy * (size.x * (gain * s));                               \
    PEL_SHIFT(phase, size)
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
    return normalize(vec3(-f.fold.y * f.slope.y - f.slope.x * (1.0 - f.fold.z),
                          -f.fold.y * f.slope.x - f.slope.y * (1.0 - f.fold.x),
                          max((1.0 - f.fold.x) * (1.0 - f.fold.z) - f.fold.y * f.fold.y, 1e-3)));
}
