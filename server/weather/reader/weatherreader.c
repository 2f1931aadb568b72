/* pelagos-weather: reads a GRIB or NetCDF file of wind and waves and writes
 * them to standard output in the form of weather/wire.h. The daemon starts one
 * for a file and throws it away: what a file makes ecCodes or libnetcdf do,
 * crash or take, it does here.
 *
 *   pelagos-weather DIRECTORY FILE
 *
 * It may read that file, ecCodes' own and nothing else (base/sandbox.h). On
 * failure a sentence on standard error, status 1, or 2 for wrong use. */
#include <stdio.h>

#include "base/reader.h"
#include "weather/reader/forecast.h"
#include "weather/wire.h"

#define MOST_MEMORY ((size_t)3 << 29) /* 1.5 GiB */
#define MOST_CPU_S 18

int main(int argc, char **argv)
{
    struct pel_weather_grid grid;
    struct pel_fault fault = { 0 };
    char path[4096];
    if (argc != 3) {
        fprintf(stderr, "usage: pelagos-weather DIRECTORY FILE\n");
        return 2;
    }
    /* No name is an address then, which libnetcdf would take. */
    snprintf(path, sizeof path, "./%.4000s", argv[2]);
    const char *readable[PEL_FORECAST_MOST_PLACES + 2] = { path };
    pel_forecast_prepare(readable + 1);
    pel_reader_begin(
        &(struct pel_reader){ argv[1], readable, MOST_CPU_S, MOST_MEMORY });
    if (pel_forecast_read(path, &grid, &fault)) {
        pel_reader_refuse(fault.message);
    }
    pel_reader_end(pel_weather_wire_write(&grid, stdout));
}
