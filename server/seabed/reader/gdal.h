/* GDAL in a process that reads a file from people, before and after its sandbox
 * is closed. One thread. */
#pragma once

#include <stddef.h>

#include "base/err.h"

#define PEL_GDAL_MOST_PLACES 8

/* Before the sandbox is closed: GDAL with these drivers and no others, silent,
 * without network, plugins and files beside the one that it is given, and where
 * its own files lie (NULL-terminated). */
void pel_gdal_prepare(void (*const *drivers)(void), size_t count,
                      const char *places[PEL_GDAL_MOST_PLACES + 1]);

/* Refuses an HDF5 file (netCDF 4 and BAG are such) that hands on to other
 * files: external links, external storage, virtual data sets. OK: any other
 * file. */
PEL_CHECK enum pel_err pel_gdal_check_hdf5(const char *path,
                                           struct pel_fault *fault);
