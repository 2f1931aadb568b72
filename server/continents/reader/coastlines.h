/* Coastlines of GSHHG in the form of GMT's binned files (Wessel and Smith, J.
 * Geophys. Res. 101(B4), 1996), and what of a map they fill. */
#pragma once

#include <stdbool.h>
#include <stddef.h>

#include "base/err.h"

/* Pieces of the outlines of land in water, of lakes in land and so on, degrees.
 * Points belong to piece by piece; `first` has one more, the end. */
struct pel_coastlines {
    double (*point)[2]; /* longitude, latitude */
    size_t *first, pieces;
};

/* INVALID (not such a file), NO_MEMORY. */
PEL_CHECK enum pel_err pel_coastlines_read(const char *path,
                                           struct pel_coastlines *out,
                                           struct pel_fault *fault);

/* Shares of land in columns from 180° W and rows from the south pole, 0..255,
 * by how often a line to a place crosses coasts. INVALID where that is not
 * whole, NO_MEMORY. */
PEL_CHECK enum pel_err pel_coastlines_fill(const struct pel_coastlines *lines,
                                           int columns, int rows,
                                           unsigned char **out,
                                           struct pel_fault *fault);
