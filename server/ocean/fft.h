/* Inverse Fourier transforms of PEL_FFT_N points, single precision,
 * PEL_FFT_LANES of them side by side. */
#pragma once

#define PEL_FFT_N 256
#define PEL_FFT_LANES 8

typedef float pel_lanes __attribute__((vector_size(4 * PEL_FFT_LANES)));

/* Point i of transform l is re[i][l] + i · im[i][l]. */
struct pel_fft_strip {
    pel_lanes re[PEL_FFT_N], im[PEL_FFT_N];
};

/* g[x] = Σ g[m] e^{+2πi m x / N} in place, no 1/N. Relative error about 2e-7 of
 * the root sum of squares. Any thread; the same bits on every processor. */
void pel_fft_strip(struct pel_fft_strip *strip);
