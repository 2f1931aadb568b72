/* What pelagos-weather hands to the daemon: a field in bytes. The reader works
 * on files from anywhere, so the daemon trusts nothing in them. Any thread.
 *
 *   0  "pelwthr2"
 *   8  u32 how many grids, 1 or 2: the second has the waves; u32 bytes of notes
 *  16  notes, UTF-8, zeros after them to a multiple of 8 bytes
 *
 * then each grid:
 *
 *   0  u32 columns, rows, times; u32 numbers it has (bits)
 *  16  f64 west, south of the first node, steps east and north [deg]
 *  48  f64 times [s since 1970], rising
 *      then for each number it has, in its order, i16 of every node and time
 *      (weather.h), zeros after them to a multiple of 8 bytes
 *
 * All in the machine's own order: both ends are on one. */
#pragma once

#include <stdio.h>

#include "weather/weather.h"

#define PEL_WEATHER_WIRE_MAGIC "pelwthr2"
#define PEL_WEATHER_WIRE_MOST                                                  \
    (16u + PEL_WEATHER_MOST_NOTES + 2u * (56u + 8u * PEL_WEATHER_MOST_TIMES) + \
     2u * PEL_WEATHER_MOST_VALUES)

/* False: errno says why. */
bool pel_weather_wire_write(const struct pel_weather_grid *grid, FILE *to);

/* MALFORMED, and what pel_weather_create refuses. */
PEL_CHECK enum pel_err pel_weather_wire_read(const unsigned char *bytes,
                                             size_t size,
                                             const struct pel_weather **out,
                                             struct pel_fault *fault);
