/* Numbers → a file of binned coastlines → its pieces → shares of land: what is
 * taken is whole, and every share is there. (NetCDF's own form is libnetcdf's,
 * in the reader's sandbox.) The first byte says which variable is missing or
 * longer than its fellows; then come the sizes, then the values. */
#include <fcntl.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

#include <netcdf.h>

#include "continents/reader/coastlines.h"

#define COLUMNS 48
#define ROWS 24
#define VARIABLES 8

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static const uint8_t *at;
static size_t left;

static int number(size_t bytes)
{
    int n = 0;
    for (size_t i = 0; i < bytes && left > 0; i++, left--) {
        n |= (int)((unsigned)*at++ << 8 * i);
    }
    return n;
}

static void demand(bool fine)
{
    if (!fine) {
        abort();
    }
}

/* Bytes of a value: segments' words and indices of points need four. */
static const struct {
    const char *name;
    int length; /* index of its size; 3: one */
    size_t bytes;
} variables[VARIABLES] = {
    { "Bin_size_in_minutes", 3, 2 },
    { "N_bins_in_360_longitude_range", 3, 2 },
    { "Id_of_first_segment_in_a_bin", 0, 2 },
    { "N_segments_in_a_bin", 0, 1 },
    { "Embedded_npts_levels_exit_entry_for_a_segment", 1, 3 },
    { "Id_of_first_point_in_a_segment", 1, 2 },
    { "Relative_longitude_from_SW_corner_of_bin", 2, 2 },
    { "Relative_latitude_from_SW_corner_of_bin", 2, 2 },
};

/* False where the file cannot be so. */
static bool make_file(const char *path)
{
    const int odd = number(1);
    const size_t sizes[] = { (size_t)number(1) + 1, (size_t)number(1) + 1,
                             (size_t)number(1) + 1, 1 };
    int id, dim, var[VARIABLES];
    int values[257];
    if (nc_create(path, NC_CLOBBER, &id)) {
        return false;
    }
    for (int i = 0; i < VARIABLES; i++) {
        size_t length = sizes[variables[i].length] + (odd == 16 + i);
        var[i] = -1;
        if (odd != 1 + i &&
            (nc_def_dim(id, (char[]){ (char)('a' + i), 0 }, length, &dim) ||
             nc_def_var(id, variables[i].name, NC_INT, 1, &dim, &var[i]))) {
            abort();
        }
    }
    if (nc_enddef(id)) {
        abort();
    }
    for (int i = 0; i < VARIABLES; i++) {
        size_t length = sizes[variables[i].length] + (odd == 16 + i);
        for (size_t k = 0; k < length; k++) {
            values[k] = number(variables[i].bytes);
        }
        if (var[i] >= 0 && nc_put_var_int(id, var[i], values)) {
            abort();
        }
    }
    return nc_close(id) == NC_NOERR;
}

static void look(const struct pel_coastlines *lines)
{
    unsigned char *share;
    struct pel_fault fault = { 0 };
    for (size_t i = 0; i < lines->pieces; i++) {
        demand(lines->first[i] <= lines->first[i + 1]);
        for (size_t p = lines->first[i]; p < lines->first[i + 1]; p++) {
            demand(isfinite(lines->point[p][0]) &&
                   isfinite(lines->point[p][1]));
        }
    }
    if (pel_coastlines_fill(lines, COLUMNS, ROWS, &share, &fault)) {
        demand(fault.message[0] != '\0' && share == NULL);
        return;
    }
    unsigned sum = 0;
    for (size_t i = 0; i < (size_t)COLUMNS * ROWS; i++) {
        sum += share[i];
    }
    demand(sum <= 255u * COLUMNS * ROWS);
    free(share);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static char path[64];
    struct pel_coastlines lines = { 0 };
    struct pel_fault fault = { 0 };
    if (!path[0]) {
        int fd = memfd_create("coast", 0);
        snprintf(path, sizeof path, "/proc/self/fd/%d", fd);
    }
    at = data;
    left = size;
    if (make_file(path)) {
        if (pel_coastlines_read(path, &lines, &fault)) {
            demand(fault.message[0] != '\0');
        } else {
            look(&lines);
        }
    }
    free(lines.point);
    free(lines.first);
    return 0;
}
