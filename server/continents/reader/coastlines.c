#include "continents/reader/coastlines.h"

#include <limits.h>
#include <math.h>
#include <stdlib.h>

#include <netcdf.h>

#define MOST ((size_t)40 << 20) /* values of a variable */
/* Antarctica has two outlines: of its ice (5) and of where that is grounded. */
#define GROUNDED 6

struct binned {
    int id;
    int bin_minutes, bins_across;
    size_t bins, segments, points;
    int *first_segment, *segment, *first_point;
    int *count, *lon, *lat; /* short in the file */
};

static int *values(int id, const char *name, size_t *size)
{
    int var, rank, dim;
    size_t length;
    if (nc_inq_varid(id, name, &var) || nc_inq_varndims(id, var, &rank) ||
        rank != 1 || nc_inq_vardimid(id, var, &dim) ||
        nc_inq_dimlen(id, dim, &length) || length == 0 || length > MOST ||
        (*size && length != *size)) {
        return NULL;
    }
    int *v = malloc(length * sizeof *v);
    if (v && nc_get_var_int(id, var, v)) {
        free(v);
        return NULL;
    }
    *size = length;
    return v;
}

static int number(int id, const char *name)
{
    size_t one = 1;
    int *v = values(id, name, &one);
    int n = v ? *v : 0;
    free(v);
    return n;
}

static bool whole(const struct binned *b)
{
    if (!b->first_segment || !b->count || !b->segment || !b->first_point ||
        !b->lon || !b->lat || b->bin_minutes <= 0 || b->bins_across <= 0) {
        return false;
    }
    for (size_t i = 0; i < b->bins; i++) {
        int n = b->count[i] & 0xffff;
        if (n && (b->first_segment[i] < 0 ||
                  (size_t)b->first_segment[i] + (size_t)n > b->segments)) {
            return false;
        }
    }
    for (size_t i = 0; i < b->segments; i++) {
        size_t n = (size_t)((unsigned)b->segment[i] >> 9);
        if (b->first_point[i] < 0 ||
            (size_t)b->first_point[i] + n > b->points) {
            return false;
        }
    }
    return true;
}

static enum pel_err take(const struct binned *b, struct pel_coastlines *out)
{
    double degrees = b->bin_minutes / 60.0, scale = degrees / 65535.0;
    size_t points = 0, pieces = 0;
    out->point = malloc(sizeof *out->point * b->points);
    out->first = malloc(sizeof *out->first * (b->segments + 1));
    if (!out->point || !out->first) {
        return PEL_ERR_NO_MEMORY;
    }
    for (size_t i = 0; i < b->bins; i++) {
        double west = degrees * (double)(i % (size_t)b->bins_across);
        double south =
            90.0 - degrees * (double)(1 + i / (size_t)b->bins_across);
        int n = b->count[i] & 0xffff;
        for (int k = 0; k < n; k++) {
            size_t s = (size_t)b->first_segment[i] + (size_t)k;
            unsigned word = (unsigned)b->segment[s];
            if ((word >> 6 & 7) == GROUNDED) {
                continue;
            }
            /* Each segment is some bin's alone; a file that says otherwise has
             * no room for more. */
            if (pieces == b->segments || points + (word >> 9) > b->points) {
                return PEL_ERR_INVALID;
            }
            out->first[pieces++] = points;
            for (unsigned j = 0; j < word >> 9; j++) {
                size_t p = (size_t)b->first_point[s] + j;
                out->point[points][0] = west + scale * (b->lon[p] & 0xffff);
                out->point[points++][1] = south + scale * (b->lat[p] & 0xffff);
            }
        }
    }
    out->first[pieces] = points;
    out->pieces = pieces;
    return PEL_OK;
}

enum pel_err pel_coastlines_read(const char *path, struct pel_coastlines *out,
                                 struct pel_fault *fault)
{
    struct binned b = { 0 };
    if (nc_open(path, NC_NOWRITE, &b.id)) {
        return pel_fault_set(fault, PEL_ERR_INVALID, "not NetCDF");
    }
    b.bin_minutes = number(b.id, "Bin_size_in_minutes");
    b.bins_across = number(b.id, "N_bins_in_360_longitude_range");
    b.first_segment = values(b.id, "Id_of_first_segment_in_a_bin", &b.bins);
    b.count = values(b.id, "N_segments_in_a_bin", &b.bins);
    b.segment = values(b.id, "Embedded_npts_levels_exit_entry_for_a_segment",
                       &b.segments);
    b.first_point = values(b.id, "Id_of_first_point_in_a_segment", &b.segments);
    b.lon = values(b.id, "Relative_longitude_from_SW_corner_of_bin", &b.points);
    b.lat = values(b.id, "Relative_latitude_from_SW_corner_of_bin", &b.points);
    nc_close(b.id);
    enum pel_err err = whole(&b) ? take(&b, out) : PEL_ERR_INVALID;
    free(b.first_segment);
    free(b.count);
    free(b.segment);
    free(b.first_point);
    free(b.lon);
    free(b.lat);
    return err ? pel_fault_set(fault, err, "not binned coastlines") : PEL_OK;
}

/* --- filling -------------------------------------------------------------- */

#define SUBROWS 4
/* A meridian in the Pacific, away from the edges of bins, that meets water at
 * the equator. */
#define MERIDIAN (-179.543211)

struct crossings {
    double *at;
    size_t count, capacity;
};

static bool add(struct crossings *c, double at)
{
    if (c->count == c->capacity) {
        size_t capacity = c->capacity ? 2 * c->capacity : 16;
        double *grown = realloc(c->at, capacity * sizeof *grown);
        if (!grown) {
            return false;
        }
        c->at = grown;
        c->capacity = capacity;
    }
    c->at[c->count++] = at;
    return true;
}

static int ascending(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* East of the meridian, 0..360. */
static double east_of(double longitude)
{
    double x = fmod(longitude - MERIDIAN, 360.0);
    return x < 0 ? x + 360.0 : x;
}

struct filling {
    const struct pel_coastlines *lines;
    int columns, rows;
    struct crossings *along; /* of each line of latitude, SUBROWS a row */
    struct crossings across; /* of the meridian: latitudes */
};

/* An edge's crossings; of a line half open, so that none counts twice. */
static bool cross(struct filling *f, const double *p, const double *q)
{
    double step = 180.0 / (f->rows * SUBROWS);
    const double *low = p[1] <= q[1] ? p : q, *high = p[1] <= q[1] ? q : p;
    long first = (long)ceil((low[1] + 90.0) / step - 0.5),
         end = (long)ceil((high[1] + 90.0) / step - 0.5);
    for (long k = first < 0 ? 0 : first; k < end && k < f->rows * SUBROWS;
         k++) {
        double y = (k + 0.5) * step - 90.0;
        double t = (y - low[1]) / (high[1] - low[1]);
        if (!add(&f->along[k], east_of(low[0] + t * (high[0] - low[0])))) {
            return false;
        }
    }
    double a = remainder(p[0] - MERIDIAN, 360.0),
           b = remainder(q[0] - MERIDIAN, 360.0);
    if ((a < 0) != (b < 0) && fabs(a - b) < 90.0) {
        return add(&f->across, p[1] + a / (a - b) * (q[1] - p[1]));
    }
    return true;
}

/* Adds so much of a row as lies between x and y, columns. */
static void put(double *row, double x, double y, double share)
{
    long i = (long)floor(x), j = (long)floor(y);
    if (i == j) {
        row[i] += share * (y - x);
        return;
    }
    row[i] += share * ((double)(i + 1) - x);
    for (long k = i + 1; k < j; k++) {
        row[k] += share;
    }
    row[j] += share * (y - (double)j);
}

/* Of a half-open stretch east of the meridian, degrees. */
static void put_land(const struct filling *f, double *row, double from,
                     double to)
{
    const double n = f->columns, first = (MERIDIAN + 180.0) / 360.0 * n;
    double x = first + from / 360.0 * n, y = first + to / 360.0 * n;
    const double share = 1.0 / SUBROWS;
    if (y <= n) {
        put(row, x, y, share);
    } else if (x >= n) {
        put(row, x - n, y - n, share);
    } else {
        put(row, x, n, share);
        put(row, 0, y - n, share);
    }
}

static bool land_on_meridian(const struct filling *f, double latitude)
{
    bool land = false;
    for (size_t i = 0; i < f->across.count; i++) {
        double at = f->across.at[i];
        land ^=
            latitude > 0 ? at > 0 && at < latitude : at < 0 && at > latitude;
    }
    return land;
}

static bool fill_line(const struct filling *f, int k, double *row)
{
    struct crossings *c = &f->along[k];
    bool land =
        land_on_meridian(f, (k + 0.5) * 180.0 / (f->rows * SUBROWS) - 90.0);
    const bool begun = land;
    double from = 0.0;
    if (c->count) {
        qsort(c->at, c->count, sizeof *c->at, ascending);
    }
    for (size_t i = 0; i < c->count; i++) {
        if (land) {
            put_land(f, row, from, c->at[i]);
        }
        from = c->at[i];
        land = !land;
    }
    if (land) {
        put_land(f, row, from, 360.0);
    }
    return land == begun;
}

static enum pel_err fill(struct filling *f, unsigned char *out)
{
    double *row = malloc(((size_t)f->columns + 1) * sizeof *row);
    long broken = 0;
    for (size_t i = 0; i < f->lines->pieces; i++) {
        for (size_t p = f->lines->first[i]; p + 1 < f->lines->first[i + 1];
             p++) {
            if (!row || !cross(f, f->lines->point[p], f->lines->point[p + 1])) {
                free(row);
                return PEL_ERR_NO_MEMORY;
            }
        }
    }
    for (int y = 0; row && y < f->rows; y++) {
        for (int x = 0; x <= f->columns; x++) {
            row[x] = 0;
        }
        for (int k = 0; k < SUBROWS; k++) {
            broken += !fill_line(f, SUBROWS * y + k, row);
        }
        for (int x = 0; x < f->columns; x++) {
            out[(size_t)y * (size_t)f->columns + (size_t)x] =
                (unsigned char)lround(255.0 * fmin(row[x], 1.0));
        }
    }
    free(row);
    return !row ? PEL_ERR_NO_MEMORY : broken ? PEL_ERR_INVALID : PEL_OK;
}

enum pel_err pel_coastlines_fill(const struct pel_coastlines *lines,
                                 int columns, int rows, unsigned char **out,
                                 struct pel_fault *fault)
{
    struct filling f = { .lines = lines, .columns = columns, .rows = rows };
    f.along = calloc((size_t)rows * SUBROWS, sizeof *f.along);
    *out = malloc((size_t)rows * (size_t)columns);
    enum pel_err err = f.along && *out ? fill(&f, *out) : PEL_ERR_NO_MEMORY;
    for (int k = 0; f.along && k < rows * SUBROWS; k++) {
        free(f.along[k].at);
    }
    free(f.along);
    free(f.across.at);
    if (err) {
        free(*out);
        *out = NULL;
        return pel_fault_set(fault, err,
                             err == PEL_ERR_NO_MEMORY
                                 ? "out of memory"
                                 : "coastlines that are not closed");
    }
    return PEL_OK;
}
