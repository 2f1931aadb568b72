/* The raster of a NetCDF file, by its dimensions. For pelagos-seabed. */
#pragma once

#include <gdal.h>

#include "base/err.h"
#include "seabed/reader/meaning.h"

/* *out NULL: it is no NetCDF, or its dimensions do not say which is east and
 * which north; GDAL's classic way may read it. INVALID: uneven or unknown
 * coordinates, several times; MALFORMED. */
PEL_CHECK enum pel_err pel_raster_open_netcdf(const char *path,
                                              GDALDatasetH *out,
                                              struct pel_raster_said *said,
                                              struct pel_fault *fault);
