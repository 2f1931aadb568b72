// The trochoid sum of Bruneton et al. 2010, eq. 2–4, twin of ocean/sea.c.

// Where a wave is in its wander (ocean/wander.h): r, within ±1/2, 1 − 2 |r|, and
// the swing, turns.
vec3 wandered(vec4 wander, vec2 x)
{
    float s = dot(wander.xy, x) + wander.z;
    float r = s - roundEven(s);
    return vec3(r, 1.0 - 2.0 * abs(r), 0.5 * floor(wander.z));
}

// Its phase there, turns, and its wave vector, turns/m.
float wave_turns(vec4 phase, vec2 x, vec3 at)
{
    return dot(phase.xy, x) + phase.z + at.z * (at.x * at.y);
}

vec2 wave_vector(vec4 phase, vec4 wander, vec3 at)
{
    return phase.xy + (2.0 * at.z * at.y - at.z) * wander.xy;
}

// c λ, m.
float wave_chop(vec4 phase)
{
    return floor(phase.z) * phase.w * (1.0 / float(PEL_CHOP_STEPS));
}

#ifdef PEL_SHORE
// The band of the wave whose texel is the `texel`-th, PEL_SHORE_BANDS: none.
int wave_band(int texel)
{
    int wave = texel >> 1;
    return int(shore_waves[wave >> 5][wave >> 3 & 3]) >> (3 * (wave & 7)) & 7;
}

// All bands at a place, and what belongs to none.
void shore_of_waves(vec2 x, out shored here[PEL_SHORE_BANDS + 1])
{
    for (int b = 0; b < PEL_SHORE_BANDS; b++) {
        here[b] = shore_at(b, x);
    }
    here[PEL_SHORE_BANDS] = far_out(x);
}
#endif

// w(a, b, x) of section 3.2, x = λ / length, in units of the interval.
float filter_weight(float x)
{
    x = clamp(x, 0.0, 1.0);
    return x * x * (3.0 - 2.0 * x);
}

// pel_shader_wave, two words each. All pixels read the same ones, which hardware
// hands out faster from buffers, software devices as texels.
#ifdef PEL_STORED
layout(std430, binding = PEL_STORE_WAVES) restrict readonly buffer waves_block { vec4 wave_words[]; };
#define WAVE_WORD(i) wave_words[i]
#else
layout(binding = PEL_UNIT_WAVES) uniform samplerBuffer wave_texels;
#define WAVE_WORD(i) texelFetch(wave_texels, i)
#endif

// F(phase, wander) of each wave, longest first: the sum ends before the first
// without weight, so that a pixel costs what it resolves. (The first always
// counts, with no weight if need be; the last is of no length. The bound is for
// what is not finite: a graphics device would never come back.) Not written out:
// the program would take seconds to make, and computes what the pixel does not
// resolve.
#define PEL_EACH_WAVE(F)                                                       \
    {                                                                          \
        int wave_ = 0;                                                         \
        vec4 phase_ = WAVE_WORD(0);                                            \
        do {                                                                   \
            vec4 wander_ = WAVE_WORD(wave_ + 1);                               \
            F(phase_, wander_)                                                 \
            wave_ += 2;                                                        \
            phase_ = WAVE_WORD(wave_);                                         \
        } while (phase_.w * scale + offset > 0.0 &&                            \
                 wave_ < 2 * PEL_WAVE_LIMIT);                                  \
    }
