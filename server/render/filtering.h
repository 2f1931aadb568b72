/* How the sea is filtered and its sky light is taken: the choices that options
 * offer. Pure data. */
#pragma once

#include "base/err.h"
#include "ocean/filter.h"

/* The integral of eq. 20 of Bruneton et al. 2010 over the sky. */
enum pel_sky_filter {
    PEL_SKY_AUTO,   /* facets: nearest to the truth and cheapest */
    PEL_SKY_FACETS, /* Gauss nodes over the facets seen, F in the integral */
    PEL_SKY_NINE,   /* the paper's F̄ and mean of nine samples */
    PEL_SKY_ANISOTROPIC, /* the paper's F̄ and the sampler's own filter, 16 × */
};

/* All zero: the defaults. */
struct pel_filtering {
    double n_min, n_max; /* struct pel_filter; 0: 1 and 2.5 */
    double cell_px;      /* side of the mesh's cells, 2..64; 0: 8 */
    /* A pixel's footprint at grazing angles is followed up to this many times
     * its width, 1..16: 1 is as long in all directions as along the line of
     * sight. 0: PEL_ANISOTROPY_DEFAULT. */
    int anisotropy;
    enum pel_sky_filter sky;
};
#define PEL_CELL_PX_DEFAULT 8.0
#define PEL_ANISOTROPY_DEFAULT 1
#define PEL_ANISOTROPY_MOST 16

/* With the defaults in place of zeros; INVALID with a message that names what
 * is out of its range, also for NaN. */
PEL_CHECK enum pel_err pel_filtering_settle(const struct pel_filtering *given,
                                            struct pel_filtering *out,
                                            struct pel_fault *fault);
