/* A NetCDF file's variables and the axes that they lie on, for the
 * netcdf….c of pelagos-weather. One thread. */
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

/* An attribute's numbers, or the one that it has as a text; how many there are,
 * 0: none, more than `most`, or no numbers. */
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

/* Why a variable that is called as one of ours is another product; NULL: it is
 * none. */
const char *pel_netcdf_other_product(int id, int variable,
                                     const struct pel_forecast_kind *kind,
                                     char out[96]);
/* The height that its name or a title tells, m; 0: none. */
double pel_netcdf_height_told(int id, int variable);
/* INVALID: its texts may say that its directions are others than its name
 * has, and it has no standard_name. */
PEL_CHECK enum pel_err
pel_netcdf_check_way(int id, int variable, const struct pel_forecast_kind *kind,
                     struct pel_fault *fault);

/* Whether a height is one in metres; its unit, as it is kept. */
bool pel_netcdf_metres(int id, int variable, char unit[24]);

/* A dimension with what it is of. */
PEL_CHECK enum pel_err pel_netcdf_axis_of(int id, int dimension,
                                          struct pel_netcdf_axis *out,
                                          struct pel_fault *fault);

/* The variable without dimensions that has this role; -1: none. */
int pel_netcdf_scalar(int id, enum pel_netcdf_role role);

#define PEL_NETCDF_MOST_HOLES 17

/* The numbers of a variable that stand for no value, as the file has them. */
struct pel_netcdf_holes {
    nc_type type;
    double scale, offset, wrap; /* from the file's numbers to values */
    double values[PEL_NETCDF_MOST_HOLES], unpacked[PEL_NETCDF_MOST_HOLES];
    size_t count, unpacked_count;
    double least, most; /* of valid ones */
    bool scaled;        /* those are of values after the scale */
    bool told;          /* by any attribute of the variable */
    double ends[2];     /* of a type of 16 bits and more, else NAN */
    size_t at_end[2];   /* how many values were so */
};
void pel_netcdf_find_holes(int id, int variable, nc_type type,
                           struct pel_netcdf_holes *out);
/* The value of a number of the file, NAN: none. */
double pel_netcdf_value(struct pel_netcdf_holes *holes, double raw);
/* INVALID: several of the values so far were the end of their type, and no
 * attribute says what stands for none. */
PEL_CHECK enum pel_err
pel_netcdf_check_ends(const struct pel_netcdf_holes *holes, const char *name,
                      struct pel_fault *fault);
/* The command by which a value (before its unit is converted) is declared to
 * be none. */
void pel_netcdf_declare(const struct pel_netcdf_holes *holes, const char *name,
                        double value, char out[112]);
