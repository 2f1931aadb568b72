/* A NetCDF file's variables and the axes that they lie on, for netcdffile.c and
 * netcdfaxes.c of pelagos-weather. One thread. */
#pragma once

#include <netcdf.h>
#include <stdbool.h>
#include <stddef.h>

#include "weather/reader/forecast.h"

#define PEL_NETCDF_MOST_DIMENSIONS 64 /* of a file */
#define PEL_NETCDF_MOST_RANK 8        /* of a variable that is read */

/* The quantity of a dimension. */
enum pel_netcdf_role {
    PEL_NETCDF_UNKNOWN,
    PEL_NETCDF_LATITUDE,
    PEL_NETCDF_LONGITUDE,
    PEL_NETCDF_ROTATED, /* degrees of another pole, or metres of a map */
    PEL_NETCDF_TIME,
    PEL_NETCDF_RUN,  /* the forecast's reference time */
    PEL_NETCDF_STEP, /* from it */
    PEL_NETCDF_MEMBER,
    PEL_NETCDF_EXPVER, /* the ECMWF's version of a reanalysis */
    PEL_NETCDF_HEIGHT,
    PEL_NETCDF_SEQUENCE, /* of swells */
};

struct pel_netcdf_axis {
    char name[NC_MAX_NAME + 1];
    size_t count;
    int variable; /* its coordinates'; -1: it has none */
    enum pel_netcdf_role role;
    double *values; /* of coordinates; NULL: none. Times: of UNIX; steps: s;
                     * heights: m where they are metres */
    bool metres;
    char unit[24]; /* of heights */
};

/* The text of an attribute, without blanks at its ends; false: there is none or
 * it is empty. `variable` may be NC_GLOBAL. */
bool pel_netcdf_text(int id, int variable, const char *name, char *out,
                     size_t size);

/* An attribute's numbers; how many there are, 0: none, more than `most`, or no
 * numbers. */
size_t pel_netcdf_numbers(int id, int variable, const char *name, size_t most,
                          double *out);

/* The quantity of a coordinate variable, by its standard_name, units and
 * name. */
enum pel_netcdf_role pel_netcdf_role_of(int id, int variable);

/* Coordinates of `count` nodes of a variable in the units above. */
PEL_CHECK enum pel_err pel_netcdf_coordinates(int id, int variable,
                                              enum pel_netcdf_role role,
                                              size_t count, double *out,
                                              struct pel_fault *fault);

/* Whether a height is one in metres; its unit, as it is kept. */
bool pel_netcdf_metres(int id, int variable, char unit[24]);

/* A dimension with what it is of. */
PEL_CHECK enum pel_err pel_netcdf_axis_of(int id, int dimension,
                                          struct pel_netcdf_axis *out,
                                          struct pel_fault *fault);

/* The variable without dimensions that has this role; -1: none. */
int pel_netcdf_scalar(int id, enum pel_netcdf_role role);
