/* Weather as a field: wind and waves over a grid of latitudes and longitudes,
 * by time, as a weather service's file has them. Immutable and reference
 * counted, any thread. Pictures from high up and the sea at own ship ask this
 * one function. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/err.h"

#define PEL_WEATHER_MOST_COLUMNS 7200
#define PEL_WEATHER_MOST_ROWS 3601
#define PEL_WEATHER_MOST_TIMES 2048
/* Numbers in all: 256 MiB. */
#define PEL_WEATHER_MOST_VALUES ((size_t)1 << 27)
#define PEL_WEATHER_MOST_STEP_DEG 10.0
#define PEL_WEATHER_MOST_NOTES 1024
/* Times between the years 1900 and 2100. */
#define PEL_WEATHER_FIRST_UNIX_S (-2208988800.0)
#define PEL_WEATHER_LAST_UNIX_S 4102444800.0

/* What a file may have. Each is kept in 16 bits: PEL_WEATHER_NONE where there
 * is none (land, ice), else a number of quanta. */
enum pel_weather_number {
    PEL_WEATHER_WIND_EAST, /* at 10 m, towards the east, m/s */
    PEL_WEATHER_WIND_NORTH,
    PEL_WEATHER_HEIGHT,       /* significant, of all waves, m */
    PEL_WEATHER_PERIOD,       /* of the peak, s */
    PEL_WEATHER_DIRECTION,    /* of all waves: they go to, rad from east */
    PEL_WEATHER_WIND_HEIGHT,  /* of the wind sea alone */
    PEL_WEATHER_SWELL_PERIOD, /* of the swell alone, and the next */
    PEL_WEATHER_SWELL_DIRECTION,
    PEL_WEATHER_NUMBERS
};
#define PEL_WEATHER_NONE INT16_MIN

/* Unit of one quantum; the range is ±32767 of them. Of wind 1/256 m/s, of
 * heights and periods 1/1024 m and s, of directions a 65534th of a turn. */
double pel_weather_quantum(enum pel_weather_number number);
/* The nearest number of quanta; PEL_WEATHER_NONE for NaN and what is beyond the
 * range. */
int16_t pel_weather_quantise(enum pel_weather_number number, double value);

#define PEL_WEATHER_WIND                                                       \
    (1u << PEL_WEATHER_WIND_EAST | 1u << PEL_WEATHER_WIND_NORTH)
#define PEL_WEATHER_WAVES                                                      \
    (1u << PEL_WEATHER_HEIGHT | 1u << PEL_WEATHER_PERIOD |                     \
     1u << PEL_WEATHER_DIRECTION)
#define PEL_WEATHER_PARTS                                                      \
    (1u << PEL_WEATHER_WIND_HEIGHT | 1u << PEL_WEATHER_SWELL_PERIOD |          \
     1u << PEL_WEATHER_SWELL_DIRECTION)

/* A grid as it comes. Nodes from west to east, rows from south to north, rows
 * of one time one after the other, times in their order. */
struct pel_weather_grid {
    int columns, rows, times;
    double west_deg, south_deg; /* of the first node: −360..360, −90..90 */
    double east_step, north_step; /* degrees between nodes, > 0 */
    const double *unix_s;         /* of the times, rising */
    /* NULL: not in it. Wind always; waves all three or none; parts all
     * three, with waves, or none. */
    const int16_t *values[PEL_WEATHER_NUMBERS];
    /* Waves of a grid or times of their own, without wind; NULL: none. */
    const struct pel_weather_grid *waves;
    const char *notes; /* what of the file a user should know; NULL: nothing */
};

struct pel_weather {
    uint64_t serial; /* no two of a process have the same */
    int columns, rows, times;
    double west_deg, east_step;
    bool around; /* the columns go round the Earth: no seam */
    /* Of the rows, from south. A grid that goes round the Earth and to within a
     * step of a pole has one more row there, of the nearest row's mean. */
    const double *latitude_deg;
    const double *unix_s;
    unsigned has; /* bits of pel_weather_number */
    /* columns · rows · times; where the file has none those of a neighbour, so
     * that there is weather everywhere. NULL: not in the file. */
    const int16_t *values[PEL_WEATHER_NUMBERS];
    const uint8_t
        *known; /* per node and time: 1 wind, 2 waves are the file's */
    const struct pel_weather *waves; /* on a grid of their own; NULL: here */
    const char *notes;               /* of the grid; never NULL */
};

/* Makes a field; copies all. OUT_OF_RANGE (sizes, steps, place, times),
 * INVALID (no wind; waves in part; nothing known at a time), NO_MEMORY; *fault
 * says which. */
PEL_CHECK enum pel_err pel_weather_create(const struct pel_weather_grid *grid,
                                          const struct pel_weather **out,
                                          struct pel_fault *fault);
const struct pel_weather *pel_weather_ref(const struct pel_weather *weather);
void pel_weather_unref(const struct pel_weather *weather); /* NULL allowed */

/* Where the question lies against the field; what is beyond it is held. */
enum pel_weather_place {
    PEL_WEATHER_INSIDE,
    PEL_WEATHER_BEFORE,  /* the first time: its weather */
    PEL_WEATHER_AFTER,   /* the last */
    PEL_WEATHER_OUTSIDE, /* the grid: the weather of its edge */
};

struct pel_weather_now {
    enum pel_weather_place place;
    /* Of the nearest node and time: the file has them there. Else the
     * neighbourhood's. */
    bool wind_known, waves_known; /* waves beyond their own grid are not */
    double wind_east_mps, wind_north_mps; /* at 10 m, it blows to */
    /* All below 0 where the file has no waves. */
    double height_m, period_s, direction_rad; /* they go to, from east */
    /* How much the directions agree that were averaged, 0..1: the length of
     * their mean as unit vectors, weighted by energy. */
    double agreement;
    bool parts;           /* the file has wind sea and swell apart */
    double wind_height_m; /* the rest of height_m, by energy, is the swell's */
    double swell_period_s, swell_direction_rad, swell_agreement;
};

/* The weather at a place (radians; any longitude) and time: linear in time,
 * latitude and longitude, the wind as a vector, heights as heights, periods and
 * directions weighted by energy. Continuous everywhere, poles and the date line
 * included; but a direction where `agreement` is 0. */
void pel_weather_at(const struct pel_weather *weather, double latitude_rad,
                    double longitude_rad, double unix_s,
                    struct pel_weather_now *out);
