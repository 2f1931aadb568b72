/* Weather from files, for pelagos-weather alone: a process that is thrown away,
 * so memory is freed by its end and files may be as bad as they like. One
 * thread. */
#pragma once

#include "base/err.h"
#include "seabed/reader/gdal.h"
#include "weather/weather.h"

/* What one band of a file is. */
struct pel_forecast_kind {
    enum pel_weather_number number;
    int rank;      /* of several kinds of a number that with the least counts */
    double factor; /* from the file's number to ours */
    double offset;
};

/* How a band calls itself; NULL: it does not. */
struct pel_forecast_name {
    const char *element;  /* GRIB's element, or NetCDF's variable */
    const char *standard; /* CF's standard_name */
    const char *level;    /* GRIB's */
    int parameter[3];     /* GRIB2's discipline, category, number, or −1 */
};

/* Which number the band holds; false: none of ours. */
bool pel_forecast_kind_of(const struct pel_forecast_name *name,
                          struct pel_forecast_kind *out);

/* Seconds since 1970 of `value` in CF's "UNIT since TIME"; false: it is not
 * that, or not within 3000 years. */
#define PEL_FORECAST_MOST_UNIX_S 1e11
bool pel_forecast_time(const char *units, double value, double *unix_s);

/* Before the sandbox is closed: GDAL with GRIB and NetCDF (gdal.h). */
void pel_forecast_prepare(const char *places[PEL_GDAL_MOST_PLACES + 1]);

/* What the file has. Its values and times are never freed. */
PEL_CHECK enum pel_err pel_forecast_read(const char *path,
                                         struct pel_weather_grid *out,
                                         struct pel_fault *fault);
