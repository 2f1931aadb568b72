/* The bottom of the sea and the land beside it as a height field in the
 * scene's local frame: what is drawn and what a sounding answers are this one
 * function. Immutable and reference counted, any thread. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/err.h"

#define PEL_SEABED_MOST 2048 /* columns, and rows */
#define PEL_SEABED_SPACING_MIN 0.1
#define PEL_SEABED_SPACING_MAX 10000.0
/* What can be a height above mean sea level; anything else is no data. */
#define PEL_SEABED_LOWEST (-12000.0)
#define PEL_SEABED_HIGHEST 9000.0

struct pel_seabed {
    uint64_t serial; /* no two of a process have the same */
    int columns, rows;
    double west_m, south_m; /* of the first node, from the scene's origin */
    double spacing_m;       /* between nodes */
    /* Rows from south, nodes from west, m above mean sea level. Where there is
     * no data the neighbourhood's, so that it can be drawn. */
    const float *height_m;
    const uint8_t *known; /* 0: no data at this node */
    double lowest_m, highest_m;
};

/* Makes a height field of columns × rows heights [m] from `heights`, NaN and
 * what cannot be a height: no data. OUT_OF_RANGE (sizes, spacing, place not
 * finite), INVALID (no data at all), NO_MEMORY; *fault says which. */
PEL_CHECK enum pel_err pel_seabed_create(int columns, int rows, double west_m,
                                         double south_m, double spacing_m,
                                         const float *heights,
                                         const struct pel_seabed **out,
                                         struct pel_fault *fault);
const struct pel_seabed *pel_seabed_ref(const struct pel_seabed *bed);
void pel_seabed_unref(const struct pel_seabed *bed); /* NULL allowed */

/* Height above mean sea level [m] at a place of the local frame, bilinear
 * between nodes; false where there is no data: more than half a spacing beyond
 * the outermost nodes, or the nearest node has none. */
bool pel_seabed_height(const struct pel_seabed *bed, double east_m,
                       double north_m, double *height_m);

/* The height that is drawn there: also where nodes have no data; beyond the
 * outermost nodes `outside_m`. Twin of seabed_height in
 * shaders/lib/seabed.glsl. */
double pel_seabed_drawn(const struct pel_seabed *bed, double east_m,
                        double north_m, double outside_m);
