/* pelagos-seabed: reads one raster of heights and writes it to standard output
 * in the form of seabed/wire.h. The daemon starts one for a file and throws it
 * away: what a file makes GDAL do, crash or take, it does here.
 *
 *   pelagos-seabed LATITUDE LONGITUDE elevation|depth FILE [LAT LON SPACING]
 *
 * The first place is the scene's origin, the last that of the raster's middle.
 * On failure a sentence on standard error, status 1, or 2 for wrong use. */
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>

#include "seabed/reader/raster.h"
#include "seabed/wire.h"

#define MOST_MEMORY (1 << 30)
#define MOST_CPU_S 10

/* A sandbox may not let a process set them, and then has limits of its own. */
static void limit(void)
{
    __attribute__((unused))
    const struct rlimit memory = { MOST_MEMORY, MOST_MEMORY };
    const struct rlimit cpu = { MOST_CPU_S, MOST_CPU_S };
    const struct rlimit none = { 0, 0 };
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
    (void)!setrlimit(RLIMIT_AS, &memory); /* sanitizers map far more */
#endif
    (void)!setrlimit(RLIMIT_CPU, &cpu);
    (void)!setrlimit(RLIMIT_CORE, &none);
}

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
    if ((argc != 5 && argc != 8) ||
        !number(argv[1], -90, 90, &out->origin_latitude) ||
        !number(argv[2], -180, 180, &out->origin_longitude) ||
        (strcmp(argv[3], "elevation") != 0 && strcmp(argv[3], "depth") != 0)) {
        return false;
    }
    out->depths = strcmp(argv[3], "depth") == 0;
    out->path = argv[4];
    out->placed = argc == 8;
    return !out->placed || (number(argv[5], -90, 90, &out->latitude) &&
                            number(argv[6], -180, 180, &out->longitude) &&
                            number(argv[7], PEL_SEABED_SPACING_MIN,
                                   PEL_SEABED_SPACING_MAX, &out->spacing_m));
}

int main(int argc, char **argv)
{
    struct pel_raster_request request = { 0 };
    struct pel_raster_field field;
    struct pel_fault fault = { 0 };
    unsigned char head[PEL_SEABED_WIRE_HEAD];
    if (!read_arguments(argc, argv, &request)) {
        fprintf(stderr, "usage: pelagos-seabed LATITUDE LONGITUDE "
                        "elevation|depth FILE [LATITUDE LONGITUDE SPACING]\n");
        return 2;
    }
    limit();
    if (pel_raster_read(&request, &field, &fault)) {
        fprintf(stderr, "%s\n", fault.message);
        return 1;
    }
    pel_seabed_wire_head(field.columns, field.rows, field.west_m, field.south_m,
                         field.spacing_m, head);
    size_t count = (size_t)field.columns * (size_t)field.rows;
    if (fwrite(head, sizeof head, 1, stdout) != 1 ||
        fwrite(field.heights, sizeof *field.heights, count, stdout) != count ||
        fflush(stdout)) {
        fprintf(stderr, "%s\n", strerror(errno));
        return 1;
    }
    /* No tidying up: the system does it faster. */
    fflush(stderr);
    _Exit(0);
}
