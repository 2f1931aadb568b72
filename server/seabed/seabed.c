#include "seabed/seabed.h"

#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

/* What the public part points into. */
struct bed {
    struct pel_seabed public; /* first */
    atomic_uint refs;
    float *heights;
    uint8_t *known;
};

static atomic_uint_least64_t serials;

static bool is_height(float h)
{
    return h >= (float)PEL_SEABED_LOWEST && h <= (float)PEL_SEABED_HIGHEST;
}

/* Half the size, each cell the mean of its known ones; `known` likewise. */
static void halve(const float *from, const uint8_t *has, int columns, int rows,
                  float *to, uint8_t *to_has)
{
    int w = (columns + 1) / 2, h = (rows + 1) / 2;
    for (int y = 0; y < h; y++) {
        for (int x = 0; x < w; x++) {
            double sum = 0;
            int count = 0;
            for (int i = 0; i < 4; i++) {
                int at_x = 2 * x + (i & 1), at_y = 2 * y + (i >> 1);
                if (at_x < columns && at_y < rows &&
                    has[at_y * columns + at_x]) {
                    sum += (double)from[at_y * columns + at_x];
                    count++;
                }
            }
            to[y * w + x] = count > 0 ? (float)(sum / count) : 0.0f;
            to_has[y * w + x] = count > 0;
        }
    }
}

/* Gives nodes without data the mean of the nearest level of halved grids that
 * has some. At least one node is known. */
static enum pel_err fill(float *heights, const uint8_t *known, int columns,
                         int rows)
{
    if (!memchr(known, 0, (size_t)columns * (size_t)rows)) {
        return PEL_OK;
    }
    int w = (columns + 1) / 2, h = (rows + 1) / 2;
    float *half = calloc((size_t)w * (size_t)h, sizeof *half);
    uint8_t *has = calloc((size_t)w, (size_t)h);
    enum pel_err err = half && has ? PEL_OK : PEL_ERR_NO_MEMORY;
    if (!err) {
        halve(heights, known, columns, rows, half, has);
        err = fill(half, has, w, h);
    }
    for (int i = 0; !err && i < columns * rows; i++) {
        if (!known[i]) {
            heights[i] = half[i / columns / 2 * w + i % columns / 2];
        }
    }
    free(half);
    free(has);
    return err;
}

static enum pel_err check(int columns, int rows, double west_m, double south_m,
                          double spacing_m, struct pel_fault *fault)
{
    if (columns < 2 || columns > PEL_SEABED_MOST || rows < 2 ||
        rows > PEL_SEABED_MOST) {
        return pel_fault_set(fault, PEL_ERR_OUT_OF_RANGE,
                             "%d × %d heights; it must be 2 to %d each way",
                             columns, rows, PEL_SEABED_MOST);
    }
    if (!(spacing_m >= PEL_SEABED_SPACING_MIN &&
          spacing_m <= PEL_SEABED_SPACING_MAX)) {
        return pel_fault_set(fault, PEL_ERR_OUT_OF_RANGE,
                             "heights %g m apart; it must be %g to %g m",
                             spacing_m, PEL_SEABED_SPACING_MIN,
                             PEL_SEABED_SPACING_MAX);
    }
    if (!(fabs(west_m) <= 1e7 && fabs(south_m) <= 1e7)) {
        return pel_fault_set(fault, PEL_ERR_OUT_OF_RANGE,
                             "the heights lie beyond 10,000 km");
    }
    return PEL_OK;
}

/* Copies what is a height; the range of it. False: nothing is. */
static bool take(struct bed *bed, const float *heights, size_t count)
{
    double low = HUGE_VAL, high = -HUGE_VAL;
    for (size_t i = 0; i < count; i++) {
        bed->known[i] = is_height(heights[i]);
        bed->heights[i] = bed->known[i] ? heights[i] : 0.0f;
        if (bed->known[i]) {
            low = fmin(low, (double)heights[i]);
            high = fmax(high, (double)heights[i]);
        }
    }
    bed->public.lowest_m = low;
    bed->public.highest_m = high;
    return low <= high;
}

static void destroy(struct bed *bed)
{
    if (bed) {
        free(bed->heights);
        free(bed->known);
        free(bed);
    }
}

enum pel_err pel_seabed_create(int columns, int rows, double west_m,
                               double south_m, double spacing_m,
                               const float *heights,
                               const struct pel_seabed **out,
                               struct pel_fault *fault)
{
    enum pel_err err = check(columns, rows, west_m, south_m, spacing_m, fault);
    if (err) {
        return err;
    }
    size_t count = (size_t)columns * (size_t)rows;
    struct bed *bed = calloc(1, sizeof *bed);
    if (bed) {
        bed->heights = malloc(sizeof *bed->heights * count);
        bed->known = calloc(count, 1);
    }
    if (!bed || !bed->heights || !bed->known) {
        err = PEL_ERR_NO_MEMORY;
    } else if (!take(bed, heights, count)) {
        err = PEL_ERR_INVALID;
    } else {
        err = fill(bed->heights, bed->known, columns, rows);
    }
    if (err) {
        destroy(bed);
        return pel_fault_set(fault, err,
                             err == PEL_ERR_INVALID
                                 ? "no height in the area is data"
                                 : "out of memory");
    }
    bed->public.serial = atomic_fetch_add(&serials, 1) + 1;
    bed->public.columns = columns;
    bed->public.rows = rows;
    bed->public.west_m = west_m;
    bed->public.south_m = south_m;
    bed->public.spacing_m = spacing_m;
    bed->public.height_m = bed->heights;
    bed->public.known = bed->known;
    atomic_init(&bed->refs, 1);
    *out = &bed->public;
    return PEL_OK;
}

const struct pel_seabed *pel_seabed_ref(const struct pel_seabed *bed)
{
    if (bed) {
        atomic_fetch_add(&((struct bed *)bed)->refs, 1);
    }
    return bed;
}

void pel_seabed_unref(const struct pel_seabed *bed)
{
    struct bed *whole = (struct bed *)bed;
    if (whole && atomic_fetch_sub(&whole->refs, 1) == 1) {
        destroy(whole);
    }
}

/* Place in nodes; false: beyond the outermost by more than half a spacing. */
static bool place(const struct pel_seabed *bed, double east_m, double north_m,
                  double *x, double *y)
{
    *x = (east_m - bed->west_m) / bed->spacing_m;
    *y = (north_m - bed->south_m) / bed->spacing_m;
    return *x >= -0.5 && *x <= bed->columns - 0.5 && *y >= -0.5 &&
           *y <= bed->rows - 0.5;
}

static double bilinear(const struct pel_seabed *bed, double x, double y)
{
    x = fmin(fmax(x, 0.0), bed->columns - 1.0);
    y = fmin(fmax(y, 0.0), bed->rows - 1.0);
    int i = (int)fmin(x, bed->columns - 2.0), j = (int)fmin(y, bed->rows - 2.0);
    const float *low = bed->height_m + (size_t)j * (size_t)bed->columns + i;
    const float *high = low + bed->columns;
    double fx = x - i, fy = y - j;
    double a = (double)low[0] + fx * ((double)low[1] - (double)low[0]);
    double b = (double)high[0] + fx * ((double)high[1] - (double)high[0]);
    return a + fy * (b - a);
}

bool pel_seabed_height(const struct pel_seabed *bed, double east_m,
                       double north_m, double *height_m)
{
    double x, y;
    if (!place(bed, east_m, north_m, &x, &y)) {
        return false;
    }
    int i = (int)fmin(fmax(round(x), 0.0), bed->columns - 1.0);
    int j = (int)fmin(fmax(round(y), 0.0), bed->rows - 1.0);
    *height_m = bilinear(bed, x, y);
    return bed->known[(size_t)j * (size_t)bed->columns + (size_t)i];
}

double pel_seabed_drawn(const struct pel_seabed *bed, double east_m,
                        double north_m, double outside_m)
{
    double x, y;
    return place(bed, east_m, north_m, &x, &y) ? bilinear(bed, x, y)
                                               : outside_m;
}
