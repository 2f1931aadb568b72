/* The spectrum of a sea in files of others' forms: WAVEWATCH III as text and
 * NetCDF, SWAN's spectral file, NDBC's real-time files of a buoy. What
 * ocean/spectrumfile.h and ocean/ndbc.h read. Any thread. */
#pragma once

#include <stddef.h>

#include "base/err.h"
#include "ocean/directional.h"

enum pel_spectrum_form {
    PEL_SPECTRUM_WW3,
    PEL_SPECTRUM_SWAN,
    PEL_SPECTRUM_NDBC,
    PEL_SPECTRUM_WW3_NETCDF,
};

/* Of what, where and when it is. */
struct pel_spectrum_place {
    const char *station; /* at most 10 letters and digits */
    const char *history; /* for NetCDF and comments: one line */
    double latitude, longitude;
    double depth_m; /* 0: deep */
    double wind_mps, wind_from_deg;
    double unix_s;
};

/* Which numbers. */
struct pel_spectrum_grid {
    int frequencies;              /* 3..PEL_MEASURED_MOST, evenly in ln f */
    double lowest_hz, highest_hz; /* 0.005..2 */
    int directions;               /* 3..360, the first from north */
};

#define PEL_SPECTRUM_FILES 5

struct pel_spectrum_files {
    const char *type; /* MIME */
    int count;
    struct {
        char name[40];
        unsigned char *data; /* free(), or all by …_finish */
        size_t size;
    } file[PEL_SPECTRUM_FILES];
};
void pel_spectrum_files_finish(struct pel_spectrum_files *files);

/* Density at a frequency is the energy between the middles to its neighbours
 * over that band's width, so that a sum by trapezes over the file has the
 * energy of the sea from the lowest frequency to the highest; at a direction
 * the mean over its sector. Frequencies are rounded as the form prints them;
 * those that are then the same are left out. Waits for NetCDF's writer.
 * OUT_OF_RANGE (the grid), NO_MEMORY, IO. */
PEL_CHECK enum pel_err
pel_spectrum_write(const struct pel_directional *spectrum,
                   enum pel_spectrum_form form,
                   const struct pel_spectrum_grid *grid,
                   const struct pel_spectrum_place *place,
                   struct pel_spectrum_files *out, struct pel_fault *fault);
