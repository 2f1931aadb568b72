/* Pictures of the whole sky from files, for pelagos-panorama alone: a process
 * that is thrown away, so memory is freed by its end. One thread. */
#pragma once

#include <stdbool.h>

#include "base/err.h"

#define PEL_EQUIRECT_MOST_COLUMNS 16384

/* What is wanted of a file, row by row from the zenith: means of squares of
 * `shrink` texels. */
struct pel_equirect {
    int file_columns, file_rows, shrink;
    int columns, rows;
    float *values; /* three a texel */
};

/* Sizes it. OUT_OF_RANGE: not twice as wide as high, or too large; NO_MEMORY.
 */
PEL_CHECK enum pel_err pel_equirect_begin(struct pel_equirect *e, int columns,
                                          int rows, struct pel_fault *fault);
/* Adds the file's next row, linear Rec. 709; values that are negative or no
 * numbers count as 0. */
void pel_equirect_add(struct pel_equirect *e, int row, const float *rgb);

/* OpenEXR of one part in scan lines with the channels R, G, B, or Y. */
PEL_CHECK enum pel_err pel_equirect_read_exr(const char *path,
                                             struct pel_equirect *out,
                                             struct pel_fault *fault);
/* Radiance RGBE (Ward 1991), flat or by runs, from the top left. */
PEL_CHECK enum pel_err pel_equirect_read_radiance(const char *path,
                                                  struct pel_equirect *out,
                                                  struct pel_fault *fault);
