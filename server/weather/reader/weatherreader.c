/* pelagos-weather: reads a GRIB or NetCDF file of wind and waves and writes
 * them to standard output in the form of weather/wire.h. The daemon starts one
 * for a file and throws it away: what a file makes GDAL do, crash or take, it
 * does here.
 *
 *   pelagos-weather DIRECTORY FILE
 *
 * It may read that file, GDAL's own and nothing else (base/sandbox.h). On
 * failure a sentence on standard error, status 1, or 2 for wrong use. */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/sandbox.h"
#include "weather/reader/forecast.h"
#include "weather/wire.h"

#define MOST_MEMORY ((size_t)3 << 29) /* 1.5 GiB */
#define MOST_CPU_S 18

_Noreturn static void refuse(const char *why)
{
    fprintf(stderr, "%s\n", why);
    fflush(stderr);
    _Exit(1);
}

/* Into the directory, and the sandbox closed behind us. */
static enum pel_err enter(const char *directory, const char *path,
                          struct pel_fault *fault)
{
    const char *readable[PEL_GDAL_MOST_PLACES + 2] = { path };
    const struct pel_sandbox sandbox = { .readable = readable,
                                         .cpu_s = MOST_CPU_S,
                                         .memory_bytes = MOST_MEMORY,
                                         .walls = PEL_SANDBOX_ALL };
    if (chdir(directory)) {
        return pel_fault_set(fault, PEL_ERR_IO, "%.160s: %s", directory,
                             strerror(errno));
    }
    pel_forecast_prepare(readable + 1);
    return pel_sandbox_close(&sandbox, fault);
}

static bool write_all(const struct pel_weather_grid *grid)
{
    unsigned char head[PEL_WEATHER_WIRE_HEAD];
    size_t times = (size_t)grid->times;
    size_t count = (size_t)grid->columns * (size_t)grid->rows * times;
    pel_weather_wire_head(grid, head);
    bool whole =
        fwrite(head, sizeof head, 1, stdout) == 1 &&
        fwrite(grid->unix_s, sizeof *grid->unix_s, times, stdout) == times;
    for (int n = 0; whole && n < PEL_WEATHER_NUMBERS; n++) {
        const int16_t *v = grid->values[n];
        whole = !v || fwrite(v, sizeof *v, count, stdout) == count;
    }
    return whole && fflush(stdout) == 0;
}

int main(int argc, char **argv)
{
    struct pel_weather_grid grid;
    struct pel_fault fault = { 0 };
    char path[512];
    if (argc != 3) {
        fprintf(stderr, "usage: pelagos-weather DIRECTORY FILE\n");
        return 2;
    }
    /* No name is one of GDAL's prefixes then. */
    snprintf(path, sizeof path, "./%.500s", argv[2]);
    if (enter(argv[1], path, &fault) ||
        pel_forecast_read(path, &grid, &fault)) {
        refuse(fault.message);
    }
    if (!write_all(&grid)) {
        refuse(strerror(errno));
    }
    /* No tidying up: the system does it faster. */
    fflush(stderr);
    _Exit(0);
}
