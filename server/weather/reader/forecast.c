#include "weather/reader/forecast.h"

#include <cpl_error.h>
#include <cpl_string.h>
#include <gdal.h>
#include <gdal_frmts.h>
#include <math.h>
#include <ogr_srs_api.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#define MOST_BANDS 65536
#define MOST_PARTS 64

/* A band that holds one of our numbers at one time. */
struct band {
    struct pel_forecast_kind kind;
    double unix_s;
    GDALRasterBandH band;
};

struct file {
    struct band *bands;
    size_t count;
    bool untimed;      /* one of our numbers had no time */
    GDALDatasetH grid; /* the first with one of our numbers */
};

/* Both read the file that they are given, and none that it names. */
static void (*const drivers[])(void) = { GDALRegister_GRIB,
                                         GDALRegister_netCDF };

void pel_forecast_prepare(const char *places[PEL_GDAL_MOST_PLACES + 1])
{
    pel_gdal_prepare(drivers, sizeof drivers / sizeof *drivers, places);
}

static const char *name_of(enum pel_weather_number number)
{
    static const char *const names[] = {
        [PEL_WEATHER_WIND_EAST] = "wind to the east (UGRD, u10)",
        [PEL_WEATHER_WIND_NORTH] = "wind to the north (VGRD, v10)",
        [PEL_WEATHER_HEIGHT] = "significant wave height (HTSGW, swh)",
        [PEL_WEATHER_PERIOD] = "peak period (PWPER, PERPW, pp1d, mwp)",
        [PEL_WEATHER_DIRECTION] = "wave direction (WWSDIR, DIRPW, mwd)",
        [PEL_WEATHER_WIND_HEIGHT] = "height of the wind sea (WVHGT, shww)",
        [PEL_WEATHER_SWELL_PERIOD] = "period of the swell (SWPER, mpts)",
        [PEL_WEATHER_SWELL_DIRECTION] = "direction of the swell (SWDIR, mdts)",
    };
    return names[number];
}

static const char *when(double unix_s, char out[32])
{
    time_t t = (time_t)unix_s;
    struct tm at;
    if (!gmtime_r(&t, &at) || !strftime(out, 32, "%Y-%m-%dT%H:%M:%SZ", &at)) {
        snprintf(out, 32, "%.0f s", unix_s);
    }
    return out;
}

/* --- what the bands are --------------------------------------------------- */

/* GRIB says it of each band, NetCDF by a dimension whose units have "since". */
static bool time_of(GDALDatasetH set, GDALRasterBandH band, double *unix_s)
{
    const char *valid = GDALGetMetadataItem(band, "GRIB_VALID_TIME", NULL);
    if (valid) {
        *unix_s = strtod(valid, NULL);
        return fabs(*unix_s) < PEL_FORECAST_MOST_UNIX_S;
    }
    char **items = GDALGetMetadata(band, NULL);
    for (int i = 0; items && items[i]; i++) {
        static const char start[] = "NETCDF_DIM_";
        char key[96];
        const char *equals = strchr(items[i], '=');
        if (!equals || strncmp(items[i], start, sizeof start - 1) != 0) {
            continue;
        }
        const char *dimension = items[i] + sizeof start - 1;
        snprintf(key, sizeof key, "%.*s#units", (int)(equals - dimension),
                 dimension);
        const char *units = GDALGetMetadataItem(set, key, NULL);
        if (units &&
            pel_forecast_time(units, strtod(equals + 1, NULL), unix_s)) {
            return true;
        }
    }
    return false;
}

static void name_band(GDALDatasetH set, GDALRasterBandH band,
                      struct pel_forecast_name *out)
{
    char key[160];
    const char *discipline = GDALGetMetadataItem(band, "GRIB_DISCIPLINE", NULL);
    const char *numbers =
        GDALGetMetadataItem(band, "GRIB_PDS_TEMPLATE_NUMBERS", NULL);
    *out = (struct pel_forecast_name){
        .element = GDALGetMetadataItem(band, "GRIB_ELEMENT", NULL),
        .level = GDALGetMetadataItem(band, "GRIB_SHORT_NAME", NULL),
        .parameter = { -1, -1, -1 },
    };
    if (discipline && numbers &&
        sscanf(numbers, "%d %d", &out->parameter[1], &out->parameter[2]) == 2) {
        out->parameter[0] = atoi(discipline);
    }
    if (!out->element) {
        out->element = GDALGetMetadataItem(band, "NETCDF_VARNAME", NULL);
        out->standard = GDALGetMetadataItem(band, "standard_name", NULL);
    }
    if (!out->standard && out->element) {
        snprintf(key, sizeof key, "%.120s#standard_name", out->element);
        out->standard = GDALGetMetadataItem(set, key, NULL);
    }
}

static bool same_grid(GDALDatasetH a, GDALDatasetH b)
{
    double s[6] = { 0 }, t[6] = { 0 };
    bool placed = GDALGetGeoTransform(a, s) == GDALGetGeoTransform(b, t);
    bool same = placed && GDALGetRasterXSize(a) == GDALGetRasterXSize(b) &&
                GDALGetRasterYSize(a) == GDALGetRasterYSize(b);
    for (int i = 0; i < 6; i++) {
        same = same && fabs(s[i] - t[i]) < 1e-4;
    }
    return same;
}

static enum pel_err list_bands(GDALDatasetH set, struct file *file,
                               struct pel_fault *fault)
{
    for (int i = 1; i <= GDALGetRasterCount(set); i++) {
        struct pel_forecast_name name;
        struct band b = { .band = GDALGetRasterBand(set, i) };
        name_band(set, b.band, &name);
        if (!pel_forecast_kind_of(&name, &b.kind)) {
            continue;
        }
        if (!time_of(set, b.band, &b.unix_s)) {
            file->untimed = true;
            continue;
        }
        if (file->grid && !same_grid(file->grid, set)) {
            return pel_fault_set(fault, PEL_ERR_INVALID,
                                 "its %s is on another grid than the rest: "
                                 "bring all to one, as by cdo remapbil",
                                 name_of(b.kind.number));
        }
        if (file->count == MOST_BANDS) {
            return pel_fault_set(fault, PEL_ERR_OUT_OF_RANGE,
                                 "it has more than %d fields that are read",
                                 MOST_BANDS);
        }
        file->grid = file->grid ? file->grid : set;
        file->bands[file->count++] = b;
    }
    return PEL_OK;
}

static enum pel_err list_file(const char *path, struct file *file,
                              struct pel_fault *fault)
{
    static const char *const options[] = { "USE_IDX=NO", NULL };
    GDALDatasetH whole = GDALOpenEx(
        path, GDAL_OF_RASTER | GDAL_OF_VERBOSE_ERROR, NULL, options, NULL);
    file->bands = calloc(MOST_BANDS, sizeof *file->bands);
    if (!file->bands) {
        return pel_fault_set(fault, PEL_ERR_NO_MEMORY, "out of memory");
    }
    if (!whole) {
        const char *why = CPLGetLastErrorMsg();
        return pel_fault_set(fault, PEL_ERR_INVALID,
                             "no GRIB or NetCDF with grids%s%.120s",
                             *why ? ": " : "", why);
    }
    enum pel_err err = list_bands(whole, file, fault);
    char **parts = GDALGetMetadata(whole, "SUBDATASETS");
    for (int i = 1; !err && i <= MOST_PARTS; i++) {
        char key[40];
        snprintf(key, sizeof key, "SUBDATASET_%d_NAME", i);
        const char *part = CSLFetchNameValue(parts, key);
        GDALDatasetH set =
            part ? GDALOpenEx(part, GDAL_OF_RASTER, NULL, NULL, NULL) : NULL;
        err = set ? list_bands(set, file, fault) : PEL_OK;
    }
    return err;
}

/* --- which of them count -------------------------------------------------- */

static int by_time(const void *a, const void *b)
{
    const double *p = a, *q = b;
    return (*p > *q) - (*p < *q);
}

/* Times of the wind, which everything else must have too. */
static enum pel_err find_times(const struct file *file, double **out,
                               int *count, struct pel_fault *fault)
{
    size_t n = 0;
    double *times = calloc(file->count + 1, sizeof *times);
    if (!times) {
        return pel_fault_set(fault, PEL_ERR_NO_MEMORY, "out of memory");
    }
    for (size_t i = 0; i < file->count; i++) {
        if (file->bands[i].kind.number == PEL_WEATHER_WIND_EAST) {
            times[n++] = file->bands[i].unix_s;
        }
    }
    if (n == 0) {
        return pel_fault_set(
            fault, PEL_ERR_INVALID,
            file->untimed ? "its fields have no time: NetCDF needs a dimension "
                            "with units \"hours since 1970-01-01\" or the like"
                          : "it has no wind 10 m above the sea (UGRD and VGRD, "
                            "u10 and v10)");
    }
    qsort(times, n, sizeof *times, by_time);
    size_t kept = 1;
    for (size_t i = 1; i < n; i++) {
        if (times[i] > times[kept - 1]) {
            times[kept++] = times[i];
        }
    }
    if (kept > PEL_WEATHER_MOST_TIMES) {
        return pel_fault_set(fault, PEL_ERR_OUT_OF_RANGE,
                             "it has %zu times; at most %d", kept,
                             PEL_WEATHER_MOST_TIMES);
    }
    *out = times;
    *count = (int)kept;
    return PEL_OK;
}

/* Of the kinds of one number that with the least rank; −1: none. */
static int best_rank(const struct file *file, enum pel_weather_number number)
{
    int best = -1;
    for (size_t i = 0; i < file->count; i++) {
        const struct pel_forecast_kind *k = &file->bands[i].kind;
        if (k->number == number && (best < 0 || k->rank < best)) {
            best = k->rank;
        }
    }
    return best;
}

static const struct band *find_band(const struct file *file,
                                    enum pel_weather_number number, int rank,
                                    double unix_s)
{
    for (size_t i = 0; i < file->count; i++) {
        const struct band *b = &file->bands[i];
        if (b->kind.number == number && b->kind.rank == rank &&
            b->unix_s == unix_s) {
            return b;
        }
    }
    return NULL;
}

/* --- the grid ------------------------------------------------------------- */

static enum pel_err place_grid(GDALDatasetH set, struct pel_weather_grid *out,
                               bool *north_up, struct pel_fault *fault)
{
    double t[6];
    OGRSpatialReferenceH srs = GDALGetSpatialRef(set);
    if (GDALGetGeoTransform(set, t) || t[2] != 0 || t[4] != 0 || !(t[1] > 0) ||
        t[5] == 0 || (srs && !OSRIsGeographic(srs))) {
        return pel_fault_set(
            fault, PEL_ERR_INVALID,
            "its grid has no equal steps of latitude and "
            "longitude: bring it to one, as by gdalwarp -t_srs "
            "EPSG:4326 or cdo remapbil");
    }
    out->columns = GDALGetRasterXSize(set);
    out->rows = GDALGetRasterYSize(set);
    out->east_step = t[1];
    out->north_step = fabs(t[5]);
    out->west_deg = t[0] + 0.5 * t[1];
    *north_up = t[5] < 0;
    out->south_deg = t[3] + (*north_up ? (out->rows - 0.5) * t[5] : 0.5 * t[5]);
    /* Rounded single precision, as files have it. */
    if (fabs(fabs(out->south_deg) - 90) < 1e-3) {
        out->south_deg = copysign(90, out->south_deg);
        out->north_step =
            fmin(out->north_step, (90 - out->south_deg) / (out->rows - 1));
    }
    if (out->columns > PEL_WEATHER_MOST_COLUMNS ||
        out->rows > PEL_WEATHER_MOST_ROWS) {
        return pel_fault_set(fault, PEL_ERR_OUT_OF_RANGE,
                             "%d × %d nodes; at most %d × %d", out->columns,
                             out->rows, PEL_WEATHER_MOST_COLUMNS,
                             PEL_WEATHER_MOST_ROWS);
    }
    return PEL_OK;
}

/* What a number may be, before it is said to be a mistake of the file. */
static bool is_possible(enum pel_weather_number number, double v)
{
    switch (number) {
    case PEL_WEATHER_WIND_EAST:
    case PEL_WEATHER_WIND_NORTH:
        return fabs(v) <= 120;
    case PEL_WEATHER_DIRECTION:
    case PEL_WEATHER_SWELL_DIRECTION:
        return fabs(v) <= 720;
    default:
        return v >= -0.1 && v <= 31.9;
    }
}

static int16_t keep(const struct pel_forecast_kind *kind, double v)
{
    switch (kind->number) {
    case PEL_WEATHER_DIRECTION:
    case PEL_WEATHER_SWELL_DIRECTION:
        v = remainder(v * kind->factor + kind->offset, 360) * (M_PI / 180);
        break;
    case PEL_WEATHER_WIND_EAST:
    case PEL_WEATHER_WIND_NORTH:
        break;
    default:
        v = fmax(v * kind->factor, 0);
    }
    return pel_weather_quantise(kind->number, v);
}

/* One band: `plane` is room for its nodes, `to` where they go, rows from
 * south. */
static enum pel_err read_band(const struct band *b,
                              const struct pel_weather_grid *g, bool north_up,
                              double *plane, int16_t *to,
                              struct pel_fault *fault)
{
    char at[32];
    int has_none = 0, scaled = 0, moved = 0;
    double none = GDALGetRasterNoDataValue(b->band, &has_none);
    double scale = GDALGetRasterScale(b->band, &scaled);
    double offset = GDALGetRasterOffset(b->band, &moved);
    size_t width = (size_t)g->columns, height = (size_t)g->rows;
    if (GDALRasterIO(b->band, GF_Read, 0, 0, g->columns, g->rows, plane,
                     g->columns, g->rows, GDT_Float64, 0, 0)) {
        return pel_fault_set(
            fault, PEL_ERR_MALFORMED, "%s at %s cannot be read: %.100s",
            name_of(b->kind.number), when(b->unix_s, at), CPLGetLastErrorMsg());
    }
    for (size_t y = 0; y < height; y++) {
        const double *from = plane + (north_up ? height - 1 - y : y) * width;
        for (size_t x = 0; x < width; x++) {
            double v = from[x];
            if (!isfinite(v) || (has_none && v == none)) {
                to[y * width + x] = PEL_WEATHER_NONE;
                continue;
            }
            v = scaled || moved ? v * scale + offset : v;
            if (!is_possible(b->kind.number, v)) {
                return pel_fault_set(fault, PEL_ERR_OUT_OF_RANGE,
                                     "%s at %s has %g, which cannot be; a fill "
                                     "value that is not declared?",
                                     name_of(b->kind.number),
                                     when(b->unix_s, at), v);
            }
            to[y * width + x] = keep(&b->kind, v);
        }
    }
    return PEL_OK;
}

static enum pel_err read_number(const struct file *file,
                                enum pel_weather_number number, bool north_up,
                                double *plane, struct pel_weather_grid *g,
                                struct pel_fault *fault)
{
    char at[32];
    int rank = best_rank(file, number);
    size_t nodes = (size_t)g->columns * (size_t)g->rows;
    int16_t *values = malloc(sizeof *values * nodes * (size_t)g->times);
    enum pel_err err = PEL_OK;
    if (!values) {
        return pel_fault_set(fault, PEL_ERR_NO_MEMORY, "out of memory");
    }
    for (int t = 0; !err && t < g->times; t++) {
        const struct band *b = find_band(file, number, rank, g->unix_s[t]);
        err = b ? read_band(b, g, north_up, plane, values + nodes * (size_t)t,
                            fault)
                : pel_fault_set(fault, PEL_ERR_INVALID,
                                "it has no %s at %s, when it has wind",
                                name_of(number), when(g->unix_s[t], at));
    }
    g->values[number] = values;
    return err;
}

/* Which numbers there are: waves that lack one of theirs are refused, parts
 * that do are left out. */
static enum pel_err choose(const struct file *file, unsigned *out,
                           struct pel_fault *fault)
{
    unsigned has = 0;
    for (int n = 0; n < PEL_WEATHER_NUMBERS; n++) {
        has |= best_rank(file, (enum pel_weather_number)n) >= 0 ? 1u << n : 0;
    }
    unsigned need =
        PEL_WEATHER_WIND | (has & PEL_WEATHER_WAVES ? PEL_WEATHER_WAVES : 0);
    for (int n = 0; n < PEL_WEATHER_NUMBERS; n++) {
        if (need & ~has & 1u << n) {
            return pel_fault_set(fault, PEL_ERR_INVALID, "it has no %s",
                                 name_of((enum pel_weather_number)n));
        }
    }
    bool whole = (has & PEL_WEATHER_PARTS) == PEL_WEATHER_PARTS &&
                 (has & PEL_WEATHER_WAVES);
    *out = whole ? has : has & ~PEL_WEATHER_PARTS;
    return PEL_OK;
}

enum pel_err pel_forecast_read(const char *path, struct pel_weather_grid *out,
                               struct pel_fault *fault)
{
    struct file file = { 0 };
    double *times = NULL, *plane = NULL;
    bool north_up = true;
    unsigned has = 0;
    *out = (struct pel_weather_grid){ 0 };
    enum pel_err err = pel_gdal_check_hdf5(path, fault);
    if (!err) {
        err = list_file(path, &file, fault);
    }
    if (!err) {
        err = find_times(&file, &times, &out->times, fault);
    }
    if (!err) {
        out->unix_s = times;
        err = choose(&file, &has, fault);
    }
    if (!err) {
        err = place_grid(file.grid, out, &north_up, fault);
    }
    if (!err) {
        size_t nodes = (size_t)out->columns * (size_t)out->rows;
        size_t values =
            nodes * (size_t)out->times * (size_t)__builtin_popcount(has);
        if (values > PEL_WEATHER_MOST_VALUES) {
            return pel_fault_set(fault, PEL_ERR_OUT_OF_RANGE,
                                 "%d × %d nodes of %d numbers at %d times are "
                                 "more than %zu: a coarser grid, a smaller "
                                 "region or fewer times",
                                 out->columns, out->rows,
                                 __builtin_popcount(has), out->times,
                                 PEL_WEATHER_MOST_VALUES);
        }
        plane = malloc(sizeof *plane * nodes);
        err = plane ? PEL_OK
                    : pel_fault_set(fault, PEL_ERR_NO_MEMORY, "out of memory");
    }
    for (int n = 0; !err && n < PEL_WEATHER_NUMBERS; n++) {
        if (has & 1u << n) {
            err = read_number(&file, (enum pel_weather_number)n, north_up,
                              plane, out, fault);
        }
    }
    free(plane);
    return err;
}
