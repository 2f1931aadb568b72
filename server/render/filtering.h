/* Filtering of the sea: the choices of the options, and one for validation.
 * Pure data. */
#pragma once

#include <stdbool.h>

#include "base/err.h"
#include "ocean/filter.h"

/* All zero: the defaults. */
struct pel_filtering {
    double n_min, n_max; /* struct pel_filter; 0: 1 and 2.5 */
    double cell_px;      /* side of the mesh's cells, 2..64; 0: 8 */
    /* For validation: glitter and sky by the 2010 paper as it stands, eq. 15,
     * 21, 26, 27, F̄ by its fit and the sky by nine samples of the map. It costs
     * a tenth more and is further from brute force (docs/physics/waves.md). */
    bool paper;
};
#define PEL_CELL_PX_DEFAULT 8.0

/* With the defaults in place of zeros; INVALID with a message that names what
 * is out of its range, also for NaN. */
PEL_CHECK enum pel_err pel_filtering_settle(const struct pel_filtering *given,
                                            struct pel_filtering *out,
                                            struct pel_fault *fault);
