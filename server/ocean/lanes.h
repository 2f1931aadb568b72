/* Vectors of PEL_FFT_LANES numbers, for functions under PEL_CLONES. */
#pragma once

#include <stdint.h>
#include <string.h>

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

#define PEL_LANES_LOW(a, b)                                                    \
    __builtin_shufflevector(a, b, 0, 8, 1, 9, 4, 12, 5, 13)
#define PEL_LANES_HIGH(a, b)                                                   \
    __builtin_shufflevector(a, b, 2, 10, 3, 11, 6, 14, 7, 15)
#define PEL_LANES_LOW2(a, b)                                                   \
    __builtin_shufflevector(a, b, 0, 1, 8, 9, 4, 5, 12, 13)
#define PEL_LANES_HIGH2(a, b)                                                  \
    __builtin_shufflevector(a, b, 2, 3, 10, 11, 6, 7, 14, 15)
#define PEL_LANES_LEFT(a, b)                                                   \
    __builtin_shufflevector(a, b, 0, 1, 2, 3, 8, 9, 10, 11)
#define PEL_LANES_RIGHT(a, b)                                                  \
    __builtin_shufflevector(a, b, 4, 5, 6, 7, 12, 13, 14, 15)

/* out[i][l] = in[l][i] */
PEL_INLINE void pel_lanes_turn_over(const pel_lanes *in, pel_lanes *out)
{
    pel_lanes a0 = PEL_LANES_LOW(in[0], in[1]),
              a1 = PEL_LANES_HIGH(in[0], in[1]);
    pel_lanes a2 = PEL_LANES_LOW(in[2], in[3]),
              a3 = PEL_LANES_HIGH(in[2], in[3]);
    pel_lanes a4 = PEL_LANES_LOW(in[4], in[5]),
              a5 = PEL_LANES_HIGH(in[4], in[5]);
    pel_lanes a6 = PEL_LANES_LOW(in[6], in[7]),
              a7 = PEL_LANES_HIGH(in[6], in[7]);
    pel_lanes b0 = PEL_LANES_LOW2(a0, a2), b1 = PEL_LANES_HIGH2(a0, a2);
    pel_lanes b2 = PEL_LANES_LOW2(a1, a3), b3 = PEL_LANES_HIGH2(a1, a3);
    pel_lanes b4 = PEL_LANES_LOW2(a4, a6), b5 = PEL_LANES_HIGH2(a4, a6);
    pel_lanes b6 = PEL_LANES_LOW2(a5, a7), b7 = PEL_LANES_HIGH2(a5, a7);
    out[0] = PEL_LANES_LEFT(b0, b4);
    out[1] = PEL_LANES_LEFT(b1, b5);
    out[2] = PEL_LANES_LEFT(b2, b6);
    out[3] = PEL_LANES_LEFT(b3, b7);
    out[4] = PEL_LANES_RIGHT(b0, b4);
    out[5] = PEL_LANES_RIGHT(b1, b5);
    out[6] = PEL_LANES_RIGHT(b2, b6);
    out[7] = PEL_LANES_RIGHT(b3, b7);
}

/* A strip of rows into the blocks of columns. */
PEL_INLINE void
pel_lanes_lay_rows(const struct pel_fft_strip *s, int j,
                   struct pel_fft_strip block[PEL_FFT_N / PEL_FFT_LANES])
{
    for (int b = 0; b < PEL_FFT_N / PEL_FFT_LANES; b++) {
        pel_lanes_turn_over(&s->re[b * PEL_FFT_LANES], &block[b].re[j]);
        pel_lanes_turn_over(&s->im[b * PEL_FFT_LANES], &block[b].im[j]);
    }
}

static inline void
pel_lanes_lay_none(int j, struct pel_fft_strip block[PEL_FFT_N / PEL_FFT_LANES])
{
    for (int b = 0; b < PEL_FFT_N / PEL_FFT_LANES; b++) {
        memset(&block[b].re[j], 0, sizeof(pel_lanes) * PEL_FFT_LANES);
        memset(&block[b].im[j], 0, sizeof(pel_lanes) * PEL_FFT_LANES);
    }
}

/* Lanes wherever floats may lie: memcpy of a vector goes by way of the integer
 * registers. */
typedef float pel_lanes_loose
    __attribute__((vector_size(4 * PEL_FFT_LANES), aligned(4), may_alias));

/* PEL_FFT_LANES texels of four components. */
PEL_INLINE void pel_lanes_store4(float (*to)[4], pel_lanes x, pel_lanes y,
                                 pel_lanes z, pel_lanes w)
{
    pel_lanes a = PEL_LANES_LOW(x, y), b = PEL_LANES_HIGH(x, y),
              c = PEL_LANES_LOW(z, w), d = PEL_LANES_HIGH(z, w);
    pel_lanes e = PEL_LANES_LOW2(a, c), f = PEL_LANES_HIGH2(a, c),
              g = PEL_LANES_LOW2(b, d), h = PEL_LANES_HIGH2(b, d);
    pel_lanes_loose *out = (pel_lanes_loose *)to;
    out[0] = PEL_LANES_LEFT(e, f);
    out[1] = PEL_LANES_LEFT(g, h);
    out[2] = PEL_LANES_RIGHT(e, f);
    out[3] = PEL_LANES_RIGHT(g, h);
}

/* PEL_FFT_LANES texels of two. */
PEL_INLINE void pel_lanes_store2(float (*to)[2], pel_lanes x, pel_lanes y)
{
    pel_lanes a = PEL_LANES_LOW(x, y), b = PEL_LANES_HIGH(x, y);
    pel_lanes_loose *out = (pel_lanes_loose *)to;
    out[0] = PEL_LANES_LEFT(a, b);
    out[1] = PEL_LANES_RIGHT(a, b);
}
