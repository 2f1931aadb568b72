/* A NetCDF file in memory: described here, written by libnetcdf in a process of
 * its own (`pelagos-spectrum --write`), which is the only one that has it. Any
 * thread; one at a time. */
#pragma once

#include <stddef.h>

#include "base/err.h"

#define PEL_NETCDF_GLOBAL (-1)
#define PEL_NETCDF_RANK 8
#define PEL_NETCDF_MOST_BYTES ((size_t)256 << 20)
#define PEL_NETCDF_WRITE_MS 30000

enum pel_netcdf_type {
    PEL_NETCDF_DOUBLE = 'd',
    PEL_NETCDF_FLOAT = 'f',
    PEL_NETCDF_INT = 'i',
    PEL_NETCDF_CHAR = 'c',
};

struct pel_netcdf;

/* NULL: no memory. */
struct pel_netcdf *pel_netcdf_create(void);

/* Its number, from 0. */
int pel_netcdf_dimension(struct pel_netcdf *nc, const char *name, size_t size);
/* Its number, from 0; dims are numbers of dimensions. */
int pel_netcdf_variable(struct pel_netcdf *nc, const char *name,
                        enum pel_netcdf_type type, int rank, const int *dims);

/* Attributes of a variable, or PEL_NETCDF_GLOBAL; a number has the variable's
 * type. */
void pel_netcdf_text(struct pel_netcdf *nc, int var, const char *name,
                     const char *text);
void pel_netcdf_number(struct pel_netcdf *nc, int var, const char *name,
                       double value);

/* All of a variable's values, converted to its type; characters of one. */
void pel_netcdf_values(struct pel_netcdf *nc, int var, const double *values,
                       size_t count);
void pel_netcdf_chars(struct pel_netcdf *nc, int var, const char *chars,
                      size_t count);

/* The file's bytes, free(); destroys `nc` in any case. Waits for the process.
 * NO_MEMORY, IO, INVALID. */
PEL_CHECK enum pel_err pel_netcdf_end(struct pel_netcdf *nc,
                                      unsigned char **out, size_t *size,
                                      struct pel_fault *fault);
