/* Height fields from files, by a process of their own (pelagos-seabed, beside
 * the program or in ../libexec/pelagos): the libraries that read rasters, and
 * what bad files do to them, stay out of the daemon. */
#pragma once

#include <stdbool.h>

#include "seabed/seabed.h"

/* How long a file may take to be read. */
#define PEL_SEABED_LOAD_MS 5000

/* What to read. Degrees, metres. */
struct pel_seabed_source {
    const char *directory; /* NULL: none is configured */
    const char *file;      /* a plain name in it */
    double origin_latitude, origin_longitude;
    /* Where the raster's middle lies and how far its pixels are apart, for
     * files that do not say it themselves; else not read. */
    bool placed;
    double latitude, longitude, spacing_m;
    bool depths;     /* the file's numbers grow downward */
    double offset_m; /* added to heights: of the file's zero above mean sea
                        level */
};

/* Reads the file; waits for it, at most PEL_SEABED_LOAD_MS. CONFLICT (no
 * directory; too far from the origin), INVALID (the name; what is in the
 * file), NOT_FOUND, OUT_OF_RANGE, IO, NO_MEMORY: *fault says what is wrong
 * with it. Any thread. */
PEL_CHECK enum pel_err pel_seabed_load(const struct pel_seabed_source *source,
                                       const struct pel_seabed **out,
                                       struct pel_fault *fault);
