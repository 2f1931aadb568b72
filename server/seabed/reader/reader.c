/* pelagos-seabed: reads one raster of heights and writes it to standard output
 * in the form of seabed/wire.h. The daemon starts one for a file and throws it
 * away: what a file makes GDAL do, crash or take, it does here.
 *
 *   pelagos-seabed LATITUDE LONGITUDE elevation|depth DIRECTORY FILE
 *                  [LAT LON SPACING]
 *
 * The first place is the scene's origin, the last that of the raster's middle.
 * Of the directory's files it may read all, since many formats have a second
 * file beside the first; nothing elsewhere (base/sandbox.h).
 * On failure a sentence on standard error, status 1, or 2 for wrong use. */
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/reader.h"
#include "seabed/reader/raster.h"
#include "seabed/wire.h"

#define MOST_MEMORY (1 << 30)
#define MOST_CPU_S 10

static bool number(const char *text, double low, double high, double *out)
{
    char *end = NULL;
    errno = 0;
    *out = strtod(text, &end);
    return *text && end && !*end && *out >= low && *out <= high;
}

static bool read_arguments(int argc, char **argv,
                           struct pel_raster_request *out)
{
    if ((argc != 6 && argc != 9) ||
        !number(argv[1], -90, 90, &out->origin_latitude) ||
        !number(argv[2], -180, 180, &out->origin_longitude) ||
        (strcmp(argv[3], "elevation") != 0 && strcmp(argv[3], "depth") != 0)) {
        return false;
    }
    out->depths = strcmp(argv[3], "depth") == 0;
    out->path = argv[5];
    out->placed = argc == 9;
    return !out->placed || (number(argv[6], -90, 90, &out->latitude) &&
                            number(argv[7], -180, 180, &out->longitude) &&
                            number(argv[8], PEL_SEABED_SPACING_MIN,
                                   PEL_SEABED_SPACING_MAX, &out->spacing_m));
}

int main(int argc, char **argv)
{
    struct pel_raster_request request = { 0 };
    struct pel_raster_field field;
    struct pel_fault fault = { 0 };
    char name[4096];
    unsigned char head[PEL_SEABED_WIRE_HEAD];
    if (!read_arguments(argc, argv, &request)) {
        fprintf(stderr, "usage: pelagos-seabed LATITUDE LONGITUDE "
                        "elevation|depth DIRECTORY FILE "
                        "[LATITUDE LONGITUDE SPACING]\n");
        return 2;
    }
    /* No name is one of GDAL's prefixes then. */
    snprintf(name, sizeof name, "./%.4000s", request.path);
    request.path = name;
    const char *readable[PEL_GDAL_MOST_PLACES + 2] = { "." };
    pel_raster_prepare(readable + 1);
    pel_reader_begin(
        &(struct pel_reader){ argv[4], readable, MOST_CPU_S, MOST_MEMORY });
    if (pel_raster_read(&request, &field, &fault)) {
        pel_reader_refuse(fault.message);
    }
    pel_seabed_wire_head(field.columns, field.rows, field.west_m, field.south_m,
                         field.spacing_m, head);
    size_t count = (size_t)field.columns * (size_t)field.rows;
    pel_reader_end(
        fwrite(head, sizeof head, 1, stdout) == 1 &&
        fwrite(field.heights, sizeof *field.heights, count, stdout) == count);
}
