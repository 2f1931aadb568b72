/* Where the Earth has land, for pictures from high up: shares of land of texels
 * in equal steps of longitude and latitude, from the coastlines of GSHHG
 * (Wessel and Smith 1996), and a plain albedo. Immutable, made once a process.
 * Any thread. */
#pragma once

#include <stdint.h>

#include "base/err.h"

#define PEL_CONTINENT_COLUMNS 8192
#define PEL_CONTINENT_ROWS 4096
#define PEL_GROUND_COLUMNS 720
#define PEL_GROUND_ROWS 360

struct pel_continents {
    /* 0: all water .. 255: all land; rows from the south pole, columns from
     * 180° W. */
    const uint8_t *share;
    /* Albedo at 680, 550 and 440 nm of pel_land_albedo, then 1, of 65535;
     * likewise. */
    const uint16_t (*ground)[4];
};

/* Albedo of land at 680, 550 and 440 nm, degrees. A rule and no map: ice in
 * Antarctica, Greenland and the high Arctic, forest about the equator, savanna,
 * steppe, taiga and tundra by latitude, and nine deserts by their middles and
 * half-widths. */
void pel_land_albedo(double latitude, double longitude, double out[3]);

/* Reads a file binned_GSHHS_*.nc of a directory by pelagos-continents, a
 * process of its own (base/helper.h); waits, at most PEL_CONTINENT_LOAD_MS. To
 * be freed by pel_continents_free. NOT_FOUND, INVALID, IO, NO_MEMORY,
 * MALFORMED. */
#define PEL_CONTINENT_LOAD_MS 20000
PEL_CHECK enum pel_err pel_continents_load(const char *directory,
                                           const char *file,
                                           struct pel_continents **out,
                                           struct pel_fault *fault);
void pel_continents_free(struct pel_continents *c); /* NULL allowed */

/* Those of Debian's gmt-gshhg-low, read by the first that asks; NULL without,
 * which the log says once. */
const struct pel_continents *pel_continents_get(void);

/* What the reader hands over: "pelland1", then the shares. */
#define PEL_CONTINENT_MAGIC "pelland1"
#define PEL_CONTINENT_BYTES                                                    \
    (8u + (unsigned)PEL_CONTINENT_COLUMNS * PEL_CONTINENT_ROWS)
