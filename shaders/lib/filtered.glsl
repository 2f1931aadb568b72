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
#ifdef PEL_AREAS
    float up; // what short waves are times
    vec3 washed; // of wash_at
#endif
#ifdef PEL_SHORE
    vec2 surf; // how much breaks on the bottom; height of the waves that feel it
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
#ifdef PEL_AREAS
    f.up = short_waves(x, footprint, f.washed);
#endif
#ifdef PEL_SHORE
    f.surf = vec2(0.0);
#endif
    reading at = reading_at(x);
    float lod = log2(footprint / cascades[0].place.w) + back.w;
    // Nothing is left of a cascade at its coarsest level.
    for (int c = 0; c < PEL_CASCADES; c++, lod += log2(PEL_CASCADE_RATIO)) {
        shear(c, x, at);
        if (lod < COARSEST) {
            reading own = at;
#ifdef PEL_SHORE
            shored here = far_out(x);
            if (c < PEL_CASCADES / 2) {
                here = shore_at(c, x);
                own = reading_ashore(c, here.read);
            }
#endif
            vec3 uv = vec3(cascade_uv(c, own.place), c);
            vec4 slopes = textureLod(slope_fields, uv, lod);
            float mixed = textureLod(fold_field, uv, lod).x;
#ifdef PEL_AREAS
            if (c >= PEL_CASCADES / 2) {
                slopes *= vec4(f.up, f.up, min(vec2(f.up), 1.0));
                mixed *= min(f.up, 1.0);
            }
#endif
#ifdef PEL_SHORE
            f.slope += here.a * shore_gradient(here, slopes.x * own.by.xy + slopes.y * own.by.zw);
            f.fold -= here.b * vec4(shore_gradient(here, vec2(slopes.z, mixed)),
                                    shore_gradient(here, vec2(mixed, slopes.w)));
            if (c < PEL_CASCADES / 2) {
                float high = textureLod(displacement_fields, uv, max(lod, 0.0)).z;
                f.slope += high * here.higher;
                f.surf += vec2(0.0, here.a * high);
                f.surf.x = here.breaks;
            }
#else
            f.slope += slopes.x * own.by.xy + slopes.y * own.by.zw;
            f.fold -= vec4(slopes.z, mixed, mixed, slopes.w);
#endif
#ifdef PEL_FOAM
            if (c < 2) {
                f.breaking += textureLod(breaking_fields, uv, lod).xy;
            }
#endif
#ifdef PEL_LAYERS
            vec3 shift = cascade_displacement(c, uv.xy, lod - PEL_SHIFT_SHARPER);
#ifdef PEL_AREAS
            if (c >= PEL_CASCADES / 2) {
                shift *= vec3(min(vec2(f.up), 1.0), f.up);
            }
#endif
#ifdef PEL_SHORE
            shift *= vec3(here.b, here.b, here.a);
#endif
            f.shift += shift;
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
    f.shift += (w * wander.w) * vec3((-chop * sc.x) * phase.xy, PEL_SHORE_HIGHER sc.y);
#ifdef PEL_AREAS
#undef PEL_SHIFT
#define PEL_SHIFT(phase, wander)                                               \
    f.shift += (w * wander.w) * vec3((-chop * level * sc.x) * phase.xy, PEL_SHORE_HIGHER up * sc.y);
#endif
#else
#define PEL_SHIFT(phase, wander)
#endif
#ifdef PEL_SHORE
    shored here[PEL_SHORE_BANDS + 1];
    shore_of_waves(x, here);
    f.surf = vec2(here[0].breaks, 0.0);
#define PEL_READ                                                               \
    shored ashore = here[wave_band(wave_)];                                    \
    vec2 read = ashore.read;
#define PEL_GROWN(wander) \
    hk = shore_gradient(ashore, hk);                                           \
    float high = 0.159154943 * gain * wander.w * sc.y; /* 1 / 2π */            \
    f.slope += high * ashore.higher;                                           \
    f.surf.y += ashore.to == vec2(0.0) ? 0.0 : ashore.a * high;                \
    chop *= ashore.b;
#define PEL_SHORE_HIGHER ashore.a *
#else
#define PEL_READ vec2 read = x;
#define PEL_GROWN(wander)
#define PEL_SHORE_HIGHER
#endif
#ifdef PEL_FOAM
    f.breaking = vec2(0.0);
#define PEL_BREAKING(phase, wander)                                            \
    f.breaking += sc.yx * (phase.w >= PEL_FOAM_SHORTEST_M ? gain * wander.w / phase.w : 0.0);
#else
#define PEL_BREAKING(phase, wander)
#endif
#ifdef PEL_AREAS
    f.up = short_waves(x, footprint, f.washed);
#define PEL_UP(phase)                                                          \
    float up = phase.w < PEL_AREA_SHORTER_M ? f.up : 1.0;                      \
    float level = min(up, 1.0);
#define PEL_LEVEL level *
#define PEL_HIGHER up *
#else
#define PEL_UP(phase)
#define PEL_LEVEL
#define PEL_HIGHER
#endif
#define PEL_SLOPE(phase, wander)                                               \
    float w = filter_weight(phase.w * scale + offset);                         \
    float gain = w * footprint_mean(length2 * dot(phase.xy, phase.xy));        \
    float chop = wave_chop(phase);                                             \
    PEL_READ                                                            \
    vec3 at = wandered(wander, read);                                          \
    vec2 sc = sine_cosine_turns(wave_turns(phase, read, at));                  \
    vec2 hk = (gain * wander.w) * wave_vector(phase, wander, at);              \
    PEL_GROWN(wander)                                                                  \
    PEL_UP(phase)                                                              \
    f.fold += PEL_LEVEL (chop * sc.y) * (phase.xxyy * hk.xyxy);                \
    f.slope -= PEL_HIGHER PEL_SHORE_HIGHER sc.x * hk;                                           \
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

#ifdef PEL_WAKES
#include "lib/wake.glsl"

// The surface with ship waves on top.
void add_wakes(wake_shift w, inout filtered f)
{
    f.slope += vec2(w.dx.z, w.dy.z);
    f.fold -= vec4(w.dx.x, w.dy.x, w.dx.y, w.dy.y);
#ifdef PEL_LAYERS
    f.shift += w.d;
#endif
}
#endif
