/* Directional wave spectra of NOAA's buoys, as the National Data Buoy Center
 * publishes them: STATION.data_spec (energy density), .swdir and .swdir2 (mean
 * directions alpha1, alpha2), .swr1 and .swr2 (r1, r2). Any thread. */
#pragma once

#include <stdbool.h>

#include "base/err.h"
#include "ocean/sea.h"

#define PEL_NDBC_STATION_SIZE 33
#define PEL_NDBC_FILE_LIMIT                                                    \
    (4 << 20) /* bytes; a month of records is 0.5 MB                           \
               */

/* Reads the record nearest to unix_s (UTC; NAN: the newest) and at most 90
 * minutes from it, as waves that travel to, mathematical. `station` is 1 to 32
 * of A-Z a-z 0-9 _ -; it never names another directory. Directions that the
 * buoy did not report (999, MM), or has no files of, become r1 = r2 = 0, all
 * directions alike; bands without a density are left out.
 * *record_unix_s (NULL allowed): the record's time.
 * INVALID: no such name; NOT_FOUND: no such file or record, or one without
 * three bands; MALFORMED: a file that is not of this form or is longer than the
 * limit; IO. *fault names the file and the line. */
PEL_CHECK enum pel_err pel_ndbc_read(const char *directory, const char *station,
                                     double unix_s, struct pel_measured *out,
                                     double *record_unix_s,
                                     struct pel_fault *fault);

/* The same from one file's text: values of the record whose time is nearest to
 * unix_s (NAN: newest), for each frequency; `separation`: whether a separation
 * frequency stands before them. Returns the number of values, 0 for no record,
 * −1 − line for a line (from 0) that cannot be read. */
int pel_ndbc_parse(const char *text, double unix_s, bool separation,
                   double frequency_hz[PEL_MEASURED_MOST],
                   double value[PEL_MEASURED_MOST], double *record_unix_s);
