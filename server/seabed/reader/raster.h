/* Rasters of heights from files, for pelagos-seabed alone: a process that is
 * thrown away, so memory is freed by its end and files may be as bad as they
 * like. One thread. */
#pragma once

#include <gdal.h>
#include <stdbool.h>

#include "base/err.h"
#include "seabed/reader/gdal.h"

/* How a file is to be read and where it goes. Degrees, metres. */
struct pel_raster_request {
    const char *path; /* a plain name in the working directory */
    double origin_latitude, origin_longitude; /* of the local frame */
    bool placed;                              /* by the next three */
    double latitude, longitude;               /* of the middle */
    double spacing_m;
    bool depths; /* positive downward */
};

/* Heights about the origin: rows from south, nodes from west, NaN: no data. */
struct pel_raster_field {
    int columns, rows;
    double west_m, south_m, spacing_m;
    float *heights;
};

/* Heights as the file has them, rows from north. */
struct pel_raster_plain {
    int columns, rows;
    float *values;
};

/* Whether a variable is called like heights or depths. */
bool pel_raster_is_height_name(const char *name);

/* The first band in memory, as it is, with what has no data as NaN; rows from
 * north and columns from west where a georeference says which they are. */
PEL_CHECK enum pel_err pel_raster_read_plain(GDALDatasetH set,
                                             struct pel_raster_plain *out,
                                             struct pel_fault *fault);
/* A raster in GDAL's memory of the values, which stay ours; NULL: no memory. */
GDALDatasetH pel_raster_of_plain(const struct pel_raster_plain *plain);

/* Pixels of a plain picture: an OpenEXR, or a raster without georeference. */
#define PEL_RASTER_MOST_PIXELS (64 << 20)

/* An OpenEXR of one part in scan lines: channel Y, Z or height, else its
 * first. */
PEL_CHECK enum pel_err pel_raster_read_exr(const char *path,
                                           struct pel_raster_plain *out,
                                           struct pel_fault *fault);

/* Before the sandbox is closed: GDAL with the drivers that it may use, and
 * where its own files lie (gdal.h). */
void pel_raster_prepare(const char *places[PEL_GDAL_MOST_PLACES + 1]);

/* What GDAL's allowed drivers read from this one file, resampled bilinearly at
 * the raster's own spacing to azimuthal equidistant metres about the origin
 * (the scene's local frame, scene/geodesy.h). A raster of more than
 * PEL_SEABED_MOST nodes each way: those about the origin. */
PEL_CHECK enum pel_err pel_raster_read(const struct pel_raster_request *request,
                                       struct pel_raster_field *out,
                                       struct pel_fault *fault);
