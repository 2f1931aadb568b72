/* Inverse Fourier transform of one square grid, single precision. */
#pragma once

#include <stdbool.h>

#define PEL_FFT_N 256

/* Complex grid, row after row, parts apart; aligned to 64 bytes. */
struct pel_fft_grid {
    _Alignas(64) float re[PEL_FFT_N][PEL_FFT_N];
    _Alignas(64) float im[PEL_FFT_N][PEL_FFT_N];
};

/* g[y][x] = Σ g[j][i] e^{+2πi (i x + j y) / N} in place, no 1/N². Columns i
 * with highest < i < N − highest must be zero and are skipped. Relative error
 * about 2e-7 of the root sum of squares. Any thread; the same bits on every
 * processor. */
void pel_fft_inverse(struct pel_fft_grid *g, int highest);
