/* What pelagos-weather hands to the daemon: a field in bytes. The reader works
 * on files from anywhere, so the daemon trusts nothing in them. Any thread.
 *
 *   0  "pelwthr1"
 *   8  u32 columns, rows, times; u32 numbers it has (bits)
 *  24  f64 west, south of the first node, steps east and north [deg]
 *  56  f64 times [s since 1970], rising
 *      then for each number it has, in its order, i16 of every node and time
 *      (weather.h)
 *
 * All in the machine's own order: both ends are on one. */
#pragma once

#include "weather/weather.h"

#define PEL_WEATHER_WIRE_MAGIC "pelwthr1"
#define PEL_WEATHER_WIRE_HEAD 56
#define PEL_WEATHER_WIRE_MOST                                                  \
    (PEL_WEATHER_WIRE_HEAD + 8u * PEL_WEATHER_MOST_TIMES +                     \
     2u * PEL_WEATHER_MOST_VALUES)

/* Writes the head, without the times. */
void pel_weather_wire_head(const struct pel_weather_grid *grid,
                           unsigned char out[PEL_WEATHER_WIRE_HEAD]);

/* MALFORMED, and what pel_weather_create refuses. */
PEL_CHECK enum pel_err pel_weather_wire_read(const unsigned char *bytes,
                                             size_t size,
                                             const struct pel_weather **out,
                                             struct pel_fault *fault);
