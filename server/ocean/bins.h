/* How the waves of a sea share out a spectrum: bins of equal measure, one wave
 * each. The measure is PEL_BINS_ROOT of the square root of energy (many waves
 * about the peak, and some on its steep flank), PEL_BINS_SLOPE of slope
 * variance, and the rest even over ln k from the first thousandth of the
 * energy on, so that no octave has few, nor the shortest many. */
#pragma once

#include <stdint.h>

#define PEL_BINS_ROOT 0.36
#define PEL_BINS_SLOPE 0.20

/* Fills measure[0..steps], rising from 0 to 1, from the cumulative energy and
 * slope variance at as many places evenly spaced in ln k. */
void pel_bins_measure(const double *energy, const double *slope, int steps,
                      double *measure);

/* Bound i of n bins, 0..n, as a place (index and fraction): at an even measure,
 * moved a fifth of a bin either way by the seed. */
double pel_bins_bound(const double *measure, int steps, int n, int i,
                      uint32_t seed);

/* A cumulative sum between its places. */
double pel_bins_at(const double *sum, int steps, double place);
