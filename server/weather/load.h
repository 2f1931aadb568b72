/* Weather fields from files, by a process of their own (pelagos-weather, beside
 * the program or in ../libexec/pelagos): the libraries that read GRIB and
 * NetCDF, and what bad files do to them, stay out of the daemon. */
#pragma once

#include "weather/weather.h"

/* How long a file may take to be read. */
#define PEL_WEATHER_LOAD_MS 20000

/* Reads a file of the directory (NULL: none is configured) by its plain name;
 * waits for it, at most PEL_WEATHER_LOAD_MS. CONFLICT (no directory), INVALID
 * (the name; what is in the file), NOT_FOUND, OUT_OF_RANGE, MALFORMED, IO,
 * NO_MEMORY: *fault says what is wrong with it. Any thread. */
PEL_CHECK enum pel_err pel_weather_load(const char *directory, const char *file,
                                        const struct pel_weather **out,
                                        struct pel_fault *fault);
