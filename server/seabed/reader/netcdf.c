/* NetCDF by its dimensions: which is east and which is north is known from the
 * coordinates, whatever their order; coordinates that are rounded to the digits
 * they are printed with are equal steps. */
#include <cpl_conv.h>
#include <cpl_string.h>
#include <gdal.h>
#include <math.h>
#include <ogr_srs_api.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "seabed/reader/netcdf.h"
#include "seabed/reader/raster.h"

#define MOST_DIMS 8
#define MOST_NODES 200000
#define FLOAT_EPSILON 6e-8 /* a coordinate's own, of single precision */

enum axis { OTHER, EAST, NORTH };

struct array {
    GDALMDArrayH is;
    size_t rank;
    GDALDimensionH *dims;
    enum axis axis[MOST_DIMS];
    int east, north; /* their dimensions */
    int score;
};

static bool one_of(const char *word, const char *const *list)
{
    for (; *list; list++) {
        if (strcasecmp(word, *list) == 0) {
            return true;
        }
    }
    return false;
}

static void attribute(GDALMDArrayH array, const char *name, char *out,
                      size_t size)
{
    GDALAttributeH a = array ? GDALMDArrayGetAttribute(array, name) : NULL;
    const char *text = a ? GDALAttributeReadAsString(a) : NULL;
    snprintf(out, size, "%s", text ? text : "");
    if (a) {
        GDALAttributeRelease(a);
    }
}

/* --- dimensions ----------------------------------------------------------- */

static enum axis axis_of(GDALDimensionH dim)
{
    static const char *const east[] = { "longitude",
                                        "grid_longitude",
                                        "projection_x_coordinate",
                                        "degrees_east",
                                        "degree_east",
                                        "degreese",
                                        "degrees_e",
                                        "lon",
                                        "x",
                                        "easting",
                                        "longitudes",
                                        "lons",
                                        NULL };
    static const char *const north[] = { "latitude",
                                         "grid_latitude",
                                         "projection_y_coordinate",
                                         "degrees_north",
                                         "degree_north",
                                         "degreesn",
                                         "degrees_n",
                                         "lat",
                                         "y",
                                         "northing",
                                         "latitudes",
                                         "lats",
                                         NULL };
    static const char *const attributes[] = { "standard_name", "units", "axis",
                                              "long_name" };
    GDALMDArrayH v = GDALDimensionGetIndexingVariable(dim);
    const char *type = GDALDimensionGetType(dim);
    enum axis axis =
        type && strcmp(type, GDAL_DIM_TYPE_HORIZONTAL_X) == 0   ? EAST
        : type && strcmp(type, GDAL_DIM_TYPE_HORIZONTAL_Y) == 0 ? NORTH
                                                                : OTHER;
    /* The coordinate's attributes count before its name. */
    for (size_t i = 0; v && axis == OTHER && i < 4; i++) {
        char text[96];
        attribute(v, attributes[i], text, sizeof text);
        axis = one_of(text, east) ? EAST : one_of(text, north) ? NORTH : OTHER;
    }
    if (axis == OTHER) {
        const char *name = GDALDimensionGetName(dim);
        axis = one_of(name, east) ? EAST : one_of(name, north) ? NORTH : OTHER;
    }
    if (v) {
        GDALMDArrayRelease(v);
    }
    return axis;
}

/* Whether the array is a raster, and of which two dimensions. */
static bool take_dims(struct array *a)
{
    GDALExtendedDataTypeH type = GDALMDArrayGetDataType(a->is);
    bool numeric = GDALExtendedDataTypeGetClass(type) == GEDTC_NUMERIC;
    GDALExtendedDataTypeRelease(type);
    a->dims = GDALMDArrayGetDimensions(a->is, &a->rank);
    a->east = a->north = -1;
    if (!numeric || a->rank < 2 || a->rank > MOST_DIMS) {
        return false;
    }
    for (size_t i = 0; i < a->rank; i++) {
        a->axis[i] = axis_of(a->dims[i]);
        if (a->axis[i] == EAST) {
            a->east = (int)i;
        } else if (a->axis[i] == NORTH) {
            a->north = (int)i;
        }
    }
    return a->east >= 0 && a->north >= 0;
}

/* --- which array ---------------------------------------------------------- */

static int score_of(GDALMDArrayH array)
{
    char standard[96];
    attribute(array, "standard_name", standard, sizeof standard);
    return pel_raster_way_of_name(standard) != PEL_RASTER_AS_ASKED ? 2
           : pel_raster_is_height_name(GDALMDArrayGetName(array))  ? 1
                                                                   : 0;
}

/* false: the file has no raster that is known by its dimensions. */
static bool choose(GDALGroupH root, struct array *out, bool *several)
{
    char **names = GDALGroupGetMDArrayNames(root, NULL);
    int count = 0;
    out->is = NULL;
    for (int i = 0; names && names[i]; i++) {
        struct array a = { .is = GDALGroupOpenMDArray(root, names[i], NULL) };
        if (!a.is || !take_dims(&a)) {
            continue;
        }
        a.score = score_of(a.is);
        count++;
        if (!out->is || a.score > out->score) {
            *out = a;
        }
    }
    *several = count > 1 && out->score == 0;
    return out->is != NULL;
}

static enum pel_err check_rest(const struct array *a, struct pel_fault *fault)
{
    for (size_t i = 0; i < a->rank; i++) {
        unsigned long long size = GDALDimensionGetSize(a->dims[i]);
        const char *name = GDALDimensionGetName(a->dims[i]);
        if ((int)i != a->east && (int)i != a->north && size != 1) {
            return pel_fault_set(
                fault, PEL_ERR_INVALID,
                "its %.40s has %llu values along %.40s: take one, as by ncks "
                "-d %.40s,0 FILE OUT",
                GDALMDArrayGetName(a->is), size, name, name);
        }
        if (((int)i == a->east || (int)i == a->north) &&
            (size < 2 || size > MOST_NODES)) {
            return pel_fault_set(fault, PEL_ERR_OUT_OF_RANGE,
                                 "its %.40s has %llu values; 2 to %d are read",
                                 name, size, MOST_NODES);
        }
    }
    return PEL_OK;
}

/* --- coordinates ---------------------------------------------------------- */

/* Half of the last decimal that all of them have. */
static double half_digit(const double *v, size_t count)
{
    double unit = 1;
    for (int digits = 0; digits <= 7; digits++, unit /= 10) {
        bool all = true;
        for (size_t i = 0; all && i < count; i++) {
            double n = v[i] / unit;
            all = fabs(n - rint(n)) <= fmax(1e-6, 2 * FLOAT_EPSILON * fabs(n));
        }
        if (all) {
            return 0.6 * unit; /* the fit takes a little of it */
        }
    }
    return 0;
}

/* Equal steps through the coordinates; false: there are none. */
static bool fit(const double *v, size_t count, double *first, double *step)
{
    double middle = 0.5 * (double)(count - 1), sum = 0, along = 0, square = 0;
    double most = 0;
    for (size_t i = 0; i < count; i++) {
        double x = (double)i - middle;
        if (!isfinite(v[i])) {
            return false;
        }
        sum += v[i];
        along += x * v[i];
        square += x * x;
        most = fmax(most, fabs(v[i]));
    }
    *step = along / square;
    *first = sum / (double)count - *step * middle;
    /* More than a quarter of a step would let a gap pass. */
    double room = half_digit(v, count);
    room = room <= 0.25 * fabs(*step) ? room : 0;
    room = fmax(room, fmax(1e-3 * fabs(*step), 2 * FLOAT_EPSILON * most));
    for (size_t i = 0; i < count; i++) {
        if (fabs(v[i] - *first - *step * (double)i) > room) {
            return false;
        }
    }
    return *step != 0 && room <= 0.25 * fabs(*step);
}

/* The steps of a dimension; false, without a fault: it has no coordinates. */
static bool steps(GDALDimensionH dim, double *first, double *step,
                  enum pel_err *err, struct pel_fault *fault)
{
    GDALMDArrayH v = GDALDimensionGetIndexingVariable(dim);
    size_t count = (size_t)GDALDimensionGetSize(dim);
    double *values = malloc(count * sizeof *values);
    const GUInt64 start[] = { 0 };
    const size_t counts[] = { count };
    GDALExtendedDataTypeH type = GDALExtendedDataTypeCreate(GDT_Float64);
    bool has = v && values && GDALMDArrayGetDimensionCount(v) == 1 &&
               GDALMDArrayRead(v, start, counts, NULL, NULL, type, values,
                               values, count * sizeof *values);
    for (size_t i = 0; has && v && i < count; i++) {
        int scaled = 0, moved = 0;
        double scale = GDALMDArrayGetScale(v, &scaled);
        double offset = GDALMDArrayGetOffset(v, &moved);
        values[i] = values[i] * (scaled ? scale : 1) + (moved ? offset : 0);
    }
    if (has && !fit(values, count, first, step)) {
        *err = pel_fault_set(
            fault, PEL_ERR_INVALID,
            "its %.40s are not equal steps (%.9g, %.9g … %.9g): bring it to a "
            "grid, as by cdo remapbil,GRID FILE OUT",
            GDALDimensionGetName(dim), values[0], values[1], values[count - 1]);
        has = false;
    }
    free(values);
    GDALExtendedDataTypeRelease(type);
    if (v) {
        GDALMDArrayRelease(v);
    }
    return has;
}

/* Whether it is the transform that the data set has. */
static bool same(GDALDatasetH set, const double t[6])
{
    double has[6];
    if (GDALGetGeoTransform(set, has)) {
        return false;
    }
    double columns = GDALGetRasterXSize(set), rows = GDALGetRasterYSize(set);
    return has[2] == 0 && has[4] == 0 &&
           fabs(has[0] - t[0]) < 1e-3 * fabs(t[1]) &&
           fabs(has[3] - t[3]) < 1e-3 * fabs(t[5]) &&
           fabs(has[1] - t[1]) * columns < 1e-3 * fabs(t[1]) &&
           fabs(has[5] - t[5]) * rows < 1e-3 * fabs(t[5]);
}

/* --- what GDAL leaves to others --------------------------------------------
 */

#define MOST_NONE 8

/* Numbers that stand for no height, and a scale that is a text. */
struct odd {
    double least, most, none[MOST_NONE], scale, offset;
    size_t count;
    bool any;
    bool range_of_values, none_of_values; /* of values after the scale */
};

/* An attribute's numbers, or the one that it has as a text. *real: they are
 * floating, or a text. */
static size_t numbers(GDALMDArrayH array, const char *name, size_t most,
                      double *out, bool *real)
{
    char text[48], *end = text;
    GDALAttributeH a = GDALMDArrayGetAttribute(array, name);
    if (!a) {
        return 0;
    }
    GDALExtendedDataTypeH type = GDALAttributeGetDataType(a);
    GDALDataType plain = GDALExtendedDataTypeGetNumericDataType(type);
    bool is_text = GDALExtendedDataTypeGetClass(type) != GEDTC_NUMERIC;
    *real = is_text || plain == GDT_Float32 || plain == GDT_Float64;
    size_t count = 0;
    double *values = is_text ? NULL : GDALAttributeReadAsDoubleArray(a, &count);
    count = values ? count < most ? count : most : 0;
    for (size_t i = 0; values && i < count; i++) {
        out[i] = values[i];
    }
    CPLFree(values);
    GDALExtendedDataTypeRelease(type);
    GDALAttributeRelease(a);
    if (is_text) {
        attribute(array, name, text, sizeof text);
        double v = strtod(text, &end);
        if (end > text && end[strspn(end, " ")] == '\0') {
            *out = v;
            count = 1;
        }
    }
    return count;
}

static bool is_whole(GDALMDArrayH array)
{
    GDALExtendedDataTypeH type = GDALMDArrayGetDataType(array);
    GDALDataType plain = GDALExtendedDataTypeGetNumericDataType(type);
    GDALExtendedDataTypeRelease(type);
    return plain != GDT_Float32 && plain != GDT_Float64;
}

/* valid_range, several missing_value or one of values, texts. */
static void find_odd(GDALMDArrayH array, struct odd *o)
{
    bool real = false, whole = is_whole(array);
    double range[2];
    int has = 0;
    *o = (struct odd){ .least = -INFINITY, .most = INFINITY };
    size_t ends = numbers(array, "valid_min", 1, &o->least, &real) +
                  numbers(array, "valid_max", 1, &o->most, &real);
    if (numbers(array, "valid_range", 2, range, &real) == 2) {
        o->least = range[0];
        o->most = range[1];
        ends++;
    }
    o->range_of_values = whole && real;
    o->count = numbers(array, "missing_value", MOST_NONE, o->none, &real);
    o->none_of_values = whole && real;
    o->scale = GDALMDArrayGetScale(array, &has);
    bool text = !has && numbers(array, "scale_factor", 1, &o->scale, &real) > 0;
    o->scale = has || text ? o->scale : 1;
    o->offset = GDALMDArrayGetOffset(array, &has);
    text = text ||
           (!has && numbers(array, "add_offset", 1, &o->offset, &real) > 0);
    o->offset = has || text ? o->offset : 0;
    o->any =
        ends > 0 || o->count > 1 || (o->count > 0 && o->none_of_values) || text;
}

static void take_out(const struct odd *o, struct pel_raster_plain *plain)
{
    size_t nodes = (size_t)plain->columns * (size_t)plain->rows;
    for (size_t i = 0; i < nodes; i++) {
        double raw = (double)plain->values[i];
        double value = raw * o->scale + o->offset;
        double judged = o->range_of_values ? value : raw;
        bool none = judged < o->least || judged > o->most;
        for (size_t k = 0; k < o->count; k++) {
            none = none || (float)raw == (float)o->none[k] ||
                   (o->none_of_values &&
                    fabs(value - o->none[k]) <= 0.5 * fabs(o->scale));
        }
        plain->values[i] = none ? NAN : plain->values[i];
    }
}

/* The numbers in memory, with a transform of ours. */
static enum pel_err replace(GDALDatasetH *set, const double t[6],
                            const struct odd *odd, struct pel_fault *fault)
{
    struct pel_raster_plain plain;
    enum pel_err err = pel_raster_read_plain(*set, &plain, fault);
    if (err) {
        return err;
    }
    take_out(odd, &plain);
    GDALDatasetH to = pel_raster_of_plain(&plain);
    if (!to || GDALSetGeoTransform(to, (double *)t)) {
        return pel_fault_set(fault, PEL_ERR_NO_MEMORY, "%.160s",
                             CPLGetLastErrorMsg());
    }
    GDALRasterBandH band = GDALGetRasterBand(to, 1);
    GDALSetRasterNoDataValue(band, NAN);
    GDALSetRasterScale(band, odd->scale);
    GDALSetRasterOffset(band, odd->offset);
    GDALSetSpatialRef(to, GDALGetSpatialRef(*set));
    *set = to;
    return PEL_OK;
}

/* Kilometres of projected coordinates, which GDAL takes for the CRS's unit, and
 * degrees of a grid whose pole is elsewhere, which look like any. */
static enum pel_err check_unit(GDALDimensionH dim, bool has_frame,
                               struct pel_fault *fault)
{
    GDALMDArrayH v = GDALDimensionGetIndexingVariable(dim);
    char unit[48], standard[48];
    attribute(v, "units", unit, sizeof unit);
    attribute(v, "standard_name", standard, sizeof standard);
    if (!has_frame && strncmp(standard, "grid_", 5) == 0) {
        return pel_fault_set(fault, PEL_ERR_INVALID,
                             "its %.40s are of a rotated pole that the file "
                             "does not name by a grid mapping: bring it to "
                             "latitude and longitude, as by cdo "
                             "remapbil,GRID FILE OUT",
                             GDALDimensionGetName(dim));
    }
    if (*unit == '\0' && v) {
        snprintf(unit, sizeof unit, "%s", GDALMDArrayGetUnit(v));
    }
    bool other = strcasecmp(unit, "km") == 0 || strcasecmp(unit, "rad") == 0 ||
                 strncasecmp(unit, "kilomet", 7) == 0 ||
                 strncasecmp(unit, "radian", 6) == 0;
    return other ? pel_fault_set(fault, PEL_ERR_INVALID,
                                 "its coordinates %.40s are in \"%.30s\"; "
                                 "degrees or metres are read: convert them, as "
                                 "by ncap2 -s '%.40s=%.40s*1000' FILE OUT",
                                 GDALDimensionGetName(dim), unit,
                                 GDALDimensionGetName(dim),
                                 GDALDimensionGetName(dim))
                 : PEL_OK;
}

static void say(GDALMDArrayH array, struct pel_raster_said *out)
{
    static const char *const more[] = { "description", "note", "convention",
                                        "direction" };
    *out = (struct pel_raster_said){ .netcdf = true };
    snprintf(out->name, sizeof out->name, "%s", GDALMDArrayGetName(array));
    attribute(array, "standard_name", out->standard, sizeof out->standard);
    attribute(array, "long_name", out->long_name, sizeof out->long_name);
    attribute(array, "positive", out->positive, sizeof out->positive);
    attribute(array, "units", out->unit, sizeof out->unit);
    attribute(array, "comment", out->comment, sizeof out->comment);
    for (size_t i = 0; !*out->comment && i < sizeof more / sizeof *more; i++) {
        attribute(array, more[i], out->comment, sizeof out->comment);
    }
    GDALExtendedDataTypeH type = GDALMDArrayGetDataType(array);
    out->type = pel_raster_letter(GDALExtendedDataTypeGetNumericDataType(type));
    GDALExtendedDataTypeRelease(type);
    if (!*out->unit) { /* the driver takes it as its own */
        const char *unit = GDALMDArrayGetUnit(array);
        snprintf(out->unit, sizeof out->unit, "%s", unit ? unit : "");
    }
}

enum pel_err pel_raster_open_netcdf(const char *path, GDALDatasetH *out,
                                    struct pel_raster_said *said,
                                    struct pel_fault *fault)
{
    static const char *const only[] = { "netCDF", NULL };
    struct array a = { .is = NULL };
    struct odd odd;
    double x[2], y[2];
    bool several = false;
    enum pel_err err = PEL_OK;
    GDALDatasetH whole =
        GDALOpenEx(path, GDAL_OF_MULTIDIM_RASTER, only, NULL, NULL);
    GDALGroupH root = whole ? GDALDatasetGetRootGroup(whole) : NULL;
    *out = NULL;
    if (!root || !choose(root, &a, &several) || several ||
        !steps(a.dims[a.east], &x[0], &x[1], &err, fault) ||
        !steps(a.dims[a.north], &y[0], &y[1], &err, fault)) {
        return err; /* for GDAL's own way, if it is none of the above */
    }
    err = check_rest(&a, fault);
    bool has_frame = GDALMDArrayGetSpatialRef(a.is) != NULL;
    err = err ? err : check_unit(a.dims[a.east], has_frame, fault);
    err = err ? err : check_unit(a.dims[a.north], has_frame, fault);
    if (err) {
        return err;
    }
    say(a.is, said);
    *out = GDALMDArrayAsClassicDataset(a.is, (size_t)a.east, (size_t)a.north);
    if (!*out) {
        return pel_fault_set(fault, PEL_ERR_MALFORMED, "%.160s",
                             CPLGetLastErrorMsg());
    }
    const double transform[6] = {
        x[0] - 0.5 * x[1], x[1], 0, y[0] - 0.5 * y[1], 0, y[1],
    };
    find_odd(a.is, &odd);
    return same(*out, transform) && !odd.any
               ? PEL_OK
               : replace(out, transform, &odd, fault);
}
