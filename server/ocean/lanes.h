/* Vectors of PEL_FFT_LANES numbers, for functions under PEL_CLONES. */
#pragma once

#include <stdint.h>

#include "base/simd.h"
#include "ocean/fft.h"

typedef int32_t pel_ints __attribute__((vector_size(4 * PEL_FFT_LANES)));
typedef double pel_doubles __attribute__((vector_size(8 * PEL_FFT_LANES)));

PEL_INLINE pel_lanes pel_lanes_spread(float x)
{
    return x - (pel_lanes){ 0 };
}

PEL_INLINE pel_lanes pel_lanes_choose(pel_ints mask, pel_lanes yes,
                                      pel_lanes no)
{
    return (pel_lanes)(((pel_ints)yes & mask) | ((pel_ints)no & ~mask));
}

PEL_INLINE pel_lanes pel_lanes_root(pel_lanes x)
{
    for (int l = 0; l < PEL_FFT_LANES; l++) {
        x[l] = __builtin_sqrtf(x[l]);
    }
    return x;
}

/* cos and sin of 2π x, |x| ≤ 1/2: quarter turns apart, Taylor's polynomials of
 * what is left, within 1e-7. */
PEL_INLINE void pel_lanes_turn(pel_lanes x, pel_lanes *cosine, pel_lanes *sine)
{
    const float magic = 12582912.0f; /* 1.5 · 2²³ rounds to a whole number */
    pel_lanes shifted = x * 4.0f + magic;
    pel_ints quarter = (pel_ints)shifted;
    pel_lanes a = (x - (shifted - magic) * 0.25f) * 6.28318530718f;
    pel_lanes b = a * a;
    pel_lanes s =
        a + a * b *
                (-1.0f / 6 +
                 b * (1.0f / 120 + b * (-1.0f / 5040 + b * (1.0f / 362880))));
    pel_lanes c =
        1.0f +
        b * (-0.5f + b * (1.0f / 24 + b * (-1.0f / 720 + b * (1.0f / 40320))));
    pel_ints odd = -(quarter & 1);
    pel_lanes first = pel_lanes_choose(odd, s, c);
    pel_lanes second = pel_lanes_choose(odd, c, s);
    *cosine = (pel_lanes)((pel_ints)first ^ (((quarter + 1) & 2) << 30));
    *sine = (pel_lanes)((pel_ints)second ^ ((quarter & 2) << 30));
}

/* Turns in times seconds, less whole ones: within ± 1/2. */
PEL_INLINE pel_lanes pel_lanes_fraction(pel_lanes frequency, double time_s)
{
    pel_doubles turns = __builtin_convertvector(frequency, pel_doubles);
    const double magic = 6755399441055744.0; /* 1.5 · 2⁵² */
    turns *= time_s;
    turns -= (turns + magic) - magic;
    return __builtin_convertvector(turns, pel_lanes);
}

/* Without whole turns, |x| < 2²². */
PEL_INLINE pel_lanes pel_lanes_part(pel_lanes x)
{
    const float magic = 12582912.0f;
    return x - ((x + magic) - magic);
}
