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

// Longest first: the sum ends at the first wave without weight, so that a pixel
// costs what it resolves.
#define PEL_EACH_WAVE(F) for (int i_ = 0; i_ < PEL_WAVE_LIMIT && waves[i_].phase.w * scale + offset > 0.0; i_++) { F(i_) }
