// The trochoid sum of Bruneton et al. 2010, eq. 2–4, twin of ocean/sea.c.
// PEL_WAVES is the number of waves. With PEL_UNROLL, a multiple of 4, the sum
// is written out, because a software rasteriser gathers dynamically indexed
// uniforms lane by lane.

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

#define PEL_EACH4(F, i) F(i) F(i + 1) F(i + 2) F(i + 3)
#define PEL_EACH16(F, i) PEL_EACH4(F, i) PEL_EACH4(F, i + 4) PEL_EACH4(F, i + 8) PEL_EACH4(F, i + 12)
#ifdef PEL_UNROLL
#if PEL_WAVES == 20
#define PEL_EACH_WAVE(F) PEL_EACH16(F, 0) PEL_EACH4(F, 16)
#elif PEL_WAVES > 112
#define PEL_EACH_WAVE(F) PEL_EACH16(F, 0) PEL_EACH16(F, 16) PEL_EACH16(F, 32) PEL_EACH16(F, 48) PEL_EACH16(F, 64) PEL_EACH16(F, 80) PEL_EACH16(F, 96) PEL_EACH16(F, 112)
#elif PEL_WAVES > 96
#define PEL_EACH_WAVE(F) PEL_EACH16(F, 0) PEL_EACH16(F, 16) PEL_EACH16(F, 32) PEL_EACH16(F, 48) PEL_EACH16(F, 64) PEL_EACH16(F, 80) PEL_EACH16(F, 96)
#elif PEL_WAVES > 80
#define PEL_EACH_WAVE(F) PEL_EACH16(F, 0) PEL_EACH16(F, 16) PEL_EACH16(F, 32) PEL_EACH16(F, 48) PEL_EACH16(F, 64) PEL_EACH16(F, 80)
#elif PEL_WAVES > 64
#define PEL_EACH_WAVE(F) PEL_EACH16(F, 0) PEL_EACH16(F, 16) PEL_EACH16(F, 32) PEL_EACH16(F, 48) PEL_EACH16(F, 64)
#elif PEL_WAVES > 60
#define PEL_EACH_WAVE(F) PEL_EACH16(F, 0) PEL_EACH16(F, 16) PEL_EACH16(F, 32) PEL_EACH16(F, 48)
#elif PEL_WAVES > 48
#define PEL_EACH_WAVE(F) PEL_EACH16(F, 0) PEL_EACH16(F, 16) PEL_EACH16(F, 32) PEL_EACH4(F, 48) PEL_EACH4(F, 52) PEL_EACH4(F, 56)
#elif PEL_WAVES > 40
#define PEL_EACH_WAVE(F) PEL_EACH16(F, 0) PEL_EACH16(F, 16) PEL_EACH16(F, 32)
#elif PEL_WAVES > 24
#define PEL_EACH_WAVE(F) PEL_EACH16(F, 0) PEL_EACH16(F, 16) PEL_EACH4(F, 32) PEL_EACH4(F, 36)
#else
#define PEL_EACH_WAVE(F) PEL_EACH16(F, 0) PEL_EACH4(F, 16) PEL_EACH4(F, 20)
#endif
#else
// Longest first: the sum ends at the first wave without weight.
#define PEL_EACH_WAVE(F) for (int i_ = 0; i_ < PEL_WAVES && waves[i_].phase.w * scale + offset > 0.0; i_++) { F(i_) }
#endif
