/* Measured and modelled wave spectra in files of others' forms, read by
 * pelagos-spectrum, a process of its own (base/helper.h): WAVEWATCH III and
 * SWAN as text and NetCDF, ERA5, NDBC and CDIP as NetCDF, NDBC's historical
 * text, Datawell's .spt, Spotter's JSON. */
#pragma once

#include "base/err.h"
#include "ocean/sea.h"

/* What the reader hands over, in the machine's own order:
 *   0  "pelspec1"
 *   8  i32 count, i32 0
 *  16  f64 time of the record, Unix
 *  24  f64[count] each of frequency, density, r1, r2, alpha1, alpha2, as in
 *      struct pel_measured */
#define PEL_SPECTRUM_FILE_MAGIC "pelspec1"
#define PEL_SPECTRUM_FILE_HEAD 24
#define PEL_SPECTRUM_FILE_WIRE_MOST                                            \
    (PEL_SPECTRUM_FILE_HEAD + 6 * 8 * PEL_MEASURED_MOST)
#define PEL_SPECTRUM_FILE_NEAR_S 5400.0
#define PEL_SPECTRUM_FILE_LOAD_MS 15000

/* Reads the record of `station` ("" where the file has one alone; a name, its
 * number from 1, or LATITUDE,LONGITUDE: the nearest place with data,
 * within 3 degrees) whose time is nearest to unix_s and at most 90 minutes
 * away; NAN: the newest. Nothing is interpolated. A density over directions
 * becomes its first and second moments. Waits. INVALID, NOT_FOUND, IO,
 * NO_MEMORY, MALFORMED: *fault says why, and what the file has. */
PEL_CHECK enum pel_err pel_spectrum_file_read(
    const char *directory, const char *file, const char *station, double unix_s,
    struct pel_measured *out, double *record_unix_s, struct pel_fault *fault);
