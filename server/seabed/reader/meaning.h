/* The meaning of a raster's numbers by all that its file says: their direction
 * and their unit. For pelagos-seabed. */
#pragma once

#include <gdal.h>
#include <stdbool.h>

#include "base/err.h"

/* The file's own words on its numbers; "": none. */
struct pel_raster_said {
    char name[64]; /* of the variable */
    char standard[96], long_name[96];
    char positive[24], unit[48];
    char comment[96]; /* and other texts */
    char type;        /* of its numbers, as NCO calls it */
    bool netcdf;      /* NCO mends it, else GDAL's own tool */
    bool up_by_bag;   /* heights by the format, whatever its CRS calls itself */
};

enum pel_raster_way {
    PEL_RASTER_AS_ASKED, /* the file says nothing: as seabed.values has it */
    PEL_RASTER_UP,
    PEL_RASTER_DOWN,
    PEL_RASTER_BY_SIGN, /* called a depth: down where nothing is below 0 */
};

struct pel_raster_meaning {
    double metres; /* a unit of the file */
    enum pel_raster_way way;
    bool by_crs; /* the way is known from the vertical CRS alone */
    char why[128];
};

/* By a standard_name of CF, or one that begins as plainly. */
enum pel_raster_way pel_raster_way_of_name(const char *name);

/* NCO's letter of a type of numbers. */
char pel_raster_letter(GDALDataType type);

/* The attributes that GDAL keeps with a band. */
void pel_raster_said_by_band(GDALRasterBandH band, struct pel_raster_said *out);

/* INVALID: a unit that is not known; two statements that contradict each
 * other, or seabed.values (`depths`); *fault says which, and the cure. */
PEL_CHECK enum pel_err pel_raster_mean(const struct pel_raster_said *said,
                                       OGRSpatialReferenceH srs, bool depths,
                                       struct pel_raster_meaning *out,
                                       struct pel_fault *fault);

/* The factor of the file's numbers to heights, by the least and the greatest
 * of them that were read. */
PEL_CHECK enum pel_err pel_raster_sign(const struct pel_raster_meaning *meaning,
                                       bool depths, double least,
                                       double greatest, double *factor,
                                       struct pel_fault *fault);

/* OUT_OF_RANGE: among the numbers that were read are some that are no heights,
 * or a usual fill value apart from all others, which the file does not declare.
 * *fault has the command that does. */
PEL_CHECK enum pel_err pel_raster_check_fills(
    const float *from, size_t count, double scale, double offset, double metres,
    const struct pel_raster_said *said, struct pel_fault *fault);
