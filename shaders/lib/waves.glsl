// The trochoid sum of Bruneton et al. 2010, eq. 2–4, twin of ocean/sea.c.

// sin 2π x: folded to a quarter wave, minimax polynomial of degree 5,
// |error| < 7e-5: a tenth of a millimetre of a metre-high wave.
float sine_turns(float x)
{
    float y = 0.25 - abs(fract(x + 0.25) - 0.5);
    float z = y * y;
    return y * (6.281280067 + z * (-41.0952419 + z * 73.58550223));
}

// w(a, b, x) of section 3.2, x = λ / length, in units of the interval.
float filter_weight(float x)
{
    x = clamp(x, 0.0, 1.0);
    return x * x * (3.0 - 2.0 * x);
}

// pel_shader_wave, two texels each.
layout(binding = PEL_UNIT_WAVES) uniform samplerBuffer wave_texels;

// F(phase, size) of each wave, longest first: the sum ends before the first
// without weight, so that a pixel costs what it resolves. (The first always
// counts, with no weight if need be.) Not written out: the program would take
// seconds to make, and computes what the pixel does not resolve.
#define PEL_EACH_WAVE(F)                                                       \
    {                                                                          \
        int wave_ = 0;                                                         \
        float next_;                                                           \
        do {                                                                   \
            vec4 phase_ = texelFetch(wave_texels, wave_);                      \
            vec4 size_ = texelFetch(wave_texels, wave_ + 1);                   \
            F(phase_, size_)                                                   \
            next_ = size_.z;                                                   \
            wave_ += 2;                                                        \
        } while (next_ * scale + offset > 0.0);                                \
    }
