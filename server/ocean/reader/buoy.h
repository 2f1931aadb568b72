/* Reports of buoys: energy by frequency and moments of its directions. For
 * pelagos-spectrum. */
#pragma once

#include "ocean/reader/shelf.h"

/* A record's bands, directions mathematical, the way that waves go to; NAN:
 * missing. Without r2 and alpha2 a wrapped normal distribution's of r1; without
 * r1 or alpha1 all directions alike. */
struct pel_bands {
    int count;
    double frequency_hz[PEL_MEASURED_MOST], density[PEL_MEASURED_MOST];
    double alpha1_rad[PEL_MEASURED_MOST], alpha2_rad[PEL_MEASURED_MOST];
    double r1[PEL_MEASURED_MOST], r2[PEL_MEASURED_MOST];
};

/* All of them missing, to be filled. */
void pel_bands_init(struct pel_bands *bands, int count);

/* Bands whose density is missing are left out. NOT_FOUND: all are, which is no
 * calm sea; OUT_OF_RANGE: the rest is no spectrum. */
PEL_CHECK enum pel_err pel_bands_take(const struct pel_bands *bands,
                                      struct pel_measured *out,
                                      struct pel_fault *fault);

/* The direction that waves go to [degrees from north], by the one they come
 * from. */
double pel_goes_to_rad(double from_deg);

/* From the Fourier coefficients of the direction it goes to, mathematical. */
void pel_bands_fourier(struct pel_bands *bands, int i, const double ab[4]);

/* The first moment of a directional spread [rad] (Kuik et al. 1988). */
double pel_r1_of_spread(double spread_rad);
