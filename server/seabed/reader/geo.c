#include <cpl_conv.h>
#include <cpl_error.h>
#include <cpl_string.h>
#include <gdal.h>
#include <gdal_alg.h>
#include <gdal_frmts.h>
#include <gdal_utils.h>
#include <math.h>
#include <ogr_srs_api.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/file.h"
#include "seabed/reader/gdal.h"
#include "seabed/reader/meaning.h"
#include "seabed/reader/netcdf.h"
#include "seabed/reader/raster.h"
#include "seabed/seabed.h"

#define EDGE 32             /* samples along an edge */
#define FARTHEST_M 200000.0 /* from the origin to the nearest of the raster */

/* All the drivers there are in this process. Each reads the file that it is
 * given and those of the same name beside it; none takes the names of others
 * from a file, nor speaks to the network. */
static void (*const drivers[])(void) = {
    GDALRegister_GTiff, GDALRegister_netCDF,  GDALRegister_BAG,
    GDALRegister_HDF5,  GDALRegister_AAIGrid, GDALRegister_EHdr,
    GDALRegister_ENVI,  GDALRegister_MEM,
};
static const char formats[] =
    "GeoTIFF, netCDF, BAG, HDF5, ASCII grid, ESRI .hdr, ENVI or OpenEXR";

/* --- opening -------------------------------------------------------------- */

bool pel_raster_is_height_name(const char *name)
{
    static const char *const words[] = {
        "elevation", "z",     "topo",   "height",     "altitude",
        "Band1",     "depth", "deptho", "bathymetry",
    };
    for (size_t i = 0; i < sizeof words / sizeof *words; i++) {
        if (strcasecmp(name, words[i]) == 0) {
            return true;
        }
    }
    return false;
}

/* A file of several rasters: the one that is called like heights. */
static GDALDatasetH open_part(GDALDatasetH whole)
{
    char **parts = GDALGetMetadata(whole, "SUBDATASETS");
    const char *name = NULL;
    for (int i = 1; !name; i++) {
        char key[40];
        snprintf(key, sizeof key, "SUBDATASET_%d_NAME", i);
        const char *part = CSLFetchNameValue(parts, key);
        if (!part) {
            break;
        }
        const char *last = strrchr(part, ':');
        name = last && pel_raster_is_height_name(last + 1) ? part : NULL;
    }
    return name ? GDALOpenEx(name, GDAL_OF_RASTER, NULL, NULL, NULL) : NULL;
}

static enum pel_err open_raster(const char *path, GDALDatasetH *out,
                                struct pel_fault *fault)
{
    *out = GDALOpenEx(path, GDAL_OF_RASTER | GDAL_OF_VERBOSE_ERROR, NULL, NULL,
                      NULL);
    if (!*out) {
        const char *why = CPLGetLastErrorMsg();
        return pel_fault_set(fault, PEL_ERR_INVALID,
                             "no raster that is read (%s)%s%.100s", formats,
                             *why ? ": " : "", why);
    }
    if (GDALGetRasterCount(*out) == 0) {
        *out = open_part(*out);
    }
    if (!*out || GDALGetRasterCount(*out) == 0) {
        return pel_fault_set(fault, PEL_ERR_INVALID,
                             "it has several rasters and none is called "
                             "elevation, z, topo, height, depth or bathymetry");
    }
    if (GDALGetRasterXSize(*out) < 2 || GDALGetRasterYSize(*out) < 2) {
        return pel_fault_set(fault, PEL_ERR_OUT_OF_RANGE,
                             "the raster is less than 2 × 2");
    }
    return PEL_OK;
}

/* --- placing -------------------------------------------------------------- */

static void local_frame(double latitude, double longitude, char out[160])
{
    snprintf(out, 160,
             "+proj=aeqd +lat_0=%.12f +lon_0=%.12f +datum=WGS84 +units=m "
             "+no_defs",
             latitude, longitude);
}

GDALDatasetH pel_raster_of_plain(const struct pel_raster_plain *plain)
{
    char place[96];
    GDALDatasetH set =
        GDALCreate(GDALGetDriverByName("MEM"), "", plain->columns, plain->rows,
                   0, GDT_Float32, NULL);
    snprintf(place, sizeof place, "DATAPOINTER=%llu",
             (unsigned long long)(uintptr_t)plain->values);
    char **options = CSLAddString(NULL, place);
    return set && GDALAddBand(set, GDT_Float32, options) == CE_None ? set
                                                                    : NULL;
}

/* A raster in memory of the values, its middle at the place of the request. */
static GDALDatasetH place_plain(const struct pel_raster_request *request,
                                const struct pel_raster_plain *plain)
{
    char frame[160];
    double s = request->spacing_m;
    double transform[] = { -0.5 * s * plain->columns, s, 0,
                           0.5 * s * plain->rows,     0, -s };
    GDALDatasetH set = pel_raster_of_plain(plain);
    local_frame(request->latitude, request->longitude, frame);
    OGRSpatialReferenceH srs = OSRNewSpatialReference(NULL);
    if (!set || OSRImportFromProj4(srs, frame) || GDALSetSpatialRef(set, srs) ||
        GDALSetGeoTransform(set, transform)) {
        return NULL;
    }
    return set;
}

static void swap_ends(float *values, size_t count, size_t stride)
{
    for (size_t i = 0; i < count / 2; i++) {
        float other = values[i * stride];
        values[i * stride] = values[(count - 1 - i) * stride];
        values[(count - 1 - i) * stride] = other;
    }
}

/* Rows from north, columns from west. */
static void turn(const struct pel_raster_plain *plain, const double t[6])
{
    size_t columns = (size_t)plain->columns, rows = (size_t)plain->rows;
    for (size_t x = 0; x < columns && t[5] > 0 && t[4] == 0; x++) {
        swap_ends(plain->values + x, rows, columns);
    }
    for (size_t y = 0; y < rows && t[1] < 0 && t[2] == 0; y++) {
        swap_ends(plain->values + y * columns, columns, 1);
    }
}

enum pel_err pel_raster_read_plain(GDALDatasetH set,
                                   struct pel_raster_plain *out,
                                   struct pel_fault *fault)
{
    int columns = GDALGetRasterXSize(set), rows = GDALGetRasterYSize(set);
    if ((int64_t)columns * rows > PEL_RASTER_MOST_PIXELS) {
        return pel_fault_set(fault, PEL_ERR_OUT_OF_RANGE,
                             "%d × %d pixels without a georeference; at most "
                             "%d in all",
                             columns, rows, PEL_RASTER_MOST_PIXELS);
    }
    GDALRasterBandH band = GDALGetRasterBand(set, 1);
    *out = (struct pel_raster_plain){ columns, rows, NULL };
    out->values = malloc(sizeof *out->values * (size_t)columns * (size_t)rows);
    if (!out->values ||
        GDALRasterIO(band, GF_Read, 0, 0, columns, rows, out->values, columns,
                     rows, GDT_Float32, 0, 0)) {
        return pel_fault_set(fault, PEL_ERR_MALFORMED, "%.160s",
                             CPLGetLastErrorMsg());
    }
    int has = 0;
    float none = (float)GDALGetRasterNoDataValue(band, &has);
    for (int64_t i = 0; has && i < (int64_t)columns * rows; i++) {
        out->values[i] = out->values[i] == none ? NAN : out->values[i];
    }
    return PEL_OK;
}

/* Whether degrees can be meant: rasters of plain latitude and longitude often
 * come without saying so. */
static bool looks_geographic(GDALDatasetH set, const double t[6])
{
    double east = t[0] + t[1] * GDALGetRasterXSize(set);
    double south = t[3] + t[5] * GDALGetRasterYSize(set);
    return t[2] == 0 && t[4] == 0 && fabs(t[0]) <= 361 && fabs(east) <= 361 &&
           fabs(t[3]) <= 91 && fabs(south) <= 91;
}

/* The raster with a place: by the request or by itself. *frame: of its
 * coordinates, in the order east, north; NULL: the data set says it. */
static enum pel_err place_raster(const struct pel_raster_request *request,
                                 GDALDatasetH *set, const char **frame,
                                 struct pel_fault *fault)
{
    double transform[6];
    bool has = GDALGetGeoTransform(*set, transform) == CE_None;
    OGRSpatialReferenceH srs = GDALGetSpatialRef(*set);
    *frame = NULL;
    if (request->placed) {
        struct pel_raster_plain plain;
        enum pel_err err = pel_raster_read_plain(*set, &plain, fault);
        if (!err && has) {
            turn(&plain, transform);
        }
        *set = err ? NULL : place_plain(request, &plain);
        return !err && !*set ? pel_fault_set(fault, PEL_ERR_NO_MEMORY, "%s",
                                             CPLGetLastErrorMsg())
                             : err;
    }
    if (!has && GDALGetGCPCount(*set) == 0) {
        return pel_fault_set(fault, PEL_ERR_INVALID,
                             "it has no georeference: set seabed.latitude, "
                             "seabed.longitude and seabed.spacing");
    }
    if (!srs && has && looks_geographic(*set, transform)) {
        *frame = "EPSG:4326";
    }
    if (!srs && !*frame && GDALGetGCPCount(*set) == 0) {
        return pel_fault_set(fault, PEL_ERR_INVALID,
                             "it does not say its coordinate reference "
                             "system: give it one, as by gdal_edit.py -a_srs "
                             "EPSG:32631 FILE");
    }
    return PEL_OK;
}

/* --- the area ------------------------------------------------------------- */

/* From pixels of the raster to metres of the frame; false: none are finite. */
static bool project(void *transformer, double x, double y, double *east_m,
                    double *north_m)
{
    double z = 0;
    int ok = 0;
    *east_m = x;
    *north_m = y;
    return GDALGenImgProjTransform(transformer, FALSE, 1, east_m, north_m, &z,
                                   &ok) &&
           ok && isfinite(*east_m) && isfinite(*north_m);
}

/* Spacing of the raster where it is nearest to the origin. */
static double spacing_of(void *transformer, int columns, int rows)
{
    double x = 0, y = 0, z = 0, at[3][2];
    int ok = 0;
    if (!GDALGenImgProjTransform(transformer, TRUE, 1, &x, &y, &z, &ok) ||
        !ok || !isfinite(x) || !isfinite(y)) {
        x = 0.5 * columns;
        y = 0.5 * rows;
    }
    x = fmin(fmax(x, 0), columns - 1.0);
    y = fmin(fmax(y, 0), rows - 1.0);
    if (!project(transformer, x, y, &at[0][0], &at[0][1]) ||
        !project(transformer, x + 1, y, &at[1][0], &at[1][1]) ||
        !project(transformer, x, y + 1, &at[2][0], &at[2][1])) {
        return NAN;
    }
    double across = hypot(at[1][0] - at[0][0], at[1][1] - at[0][1]);
    double down = hypot(at[2][0] - at[0][0], at[2][1] - at[0][1]);
    /* Never coarser than the raster in either direction, or GDAL would smooth;
     * near the poles four times as fine is enough. */
    return fmax(fmin(across, down), 0.25 * fmax(across, down));
}

struct area {
    double west, south, east, north;
};

/* What the raster covers. Where its edge does not project, without end. */
static struct area cover(void *transformer, int columns, int rows)
{
    const double far = 1e7;
    struct area a = { far, far, -far, -far };
    for (int i = 0; i < 4 * (EDGE + 1); i++) {
        double f = (double)(i / 4) / EDGE, x, y;
        if (!project(transformer, i & 1 ? f * columns : (i & 2 ? columns : 0),
                     i & 1 ? (i & 2 ? rows : 0) : f * rows, &x, &y)) {
            return (struct area){ -far, -far, far, far };
        }
        a.west = fmin(a.west, x);
        a.east = fmax(a.east, x);
        a.south = fmin(a.south, y);
        a.north = fmax(a.north, y);
    }
    return a;
}

/* The part of `a` that fits into PEL_SEABED_MOST nodes, about the origin. */
static enum pel_err choose(struct area *a, double spacing_m,
                           struct pel_fault *fault)
{
    double x = fmin(fmax(0, a->west), a->east);
    double y = fmin(fmax(0, a->south), a->north);
    if (hypot(x, y) > FARTHEST_M) {
        return pel_fault_set(fault, PEL_ERR_CONFLICT,
                             "the raster lies %.0f km from the scene's origin; "
                             "at most %.0f km: set origin.latitude and "
                             "origin.longitude near it",
                             hypot(x, y) / 1000, FARTHEST_M / 1000);
    }
    double most = PEL_SEABED_MOST * spacing_m;
    if (a->east - a->west > most) {
        double low = fmin(fmax(x - 0.5 * most, a->west), a->east - most);
        a->west = low;
        a->east = low + most;
    }
    if (a->north - a->south > most) {
        double low = fmin(fmax(y - 0.5 * most, a->south), a->north - most);
        a->south = low;
        a->north = low + most;
    }
    return PEL_OK;
}

static enum pel_err plan(const struct pel_raster_request *request,
                         GDALDatasetH set, const char *source,
                         const char *frame, struct pel_raster_field *out,
                         struct pel_fault *fault)
{
    char target[176];
    snprintf(target, sizeof target, "DST_SRS=%s", frame);
    char **options = CSLAddString(NULL, target);
    if (source) {
        options = CSLAddString(options, CPLSPrintf("SRC_SRS=%s", source));
    }
    int columns = GDALGetRasterXSize(set), rows = GDALGetRasterYSize(set);
    void *transformer = GDALCreateGenImgProjTransformer2(set, NULL, options);
    double spacing = transformer ? spacing_of(transformer, columns, rows) : NAN;
    if (!isfinite(spacing)) {
        return pel_fault_set(fault, PEL_ERR_INVALID,
                             "it cannot be brought into the scene's frame: "
                             "%.120s",
                             CPLGetLastErrorMsg());
    }
    if (request->placed) {
        spacing = request->spacing_m;
    }
    if (!(spacing >= PEL_SEABED_SPACING_MIN &&
          spacing <= PEL_SEABED_SPACING_MAX)) {
        return pel_fault_set(fault, PEL_ERR_OUT_OF_RANGE,
                             "its heights are %g m apart; it must be %g to %g "
                             "m",
                             spacing, PEL_SEABED_SPACING_MIN,
                             PEL_SEABED_SPACING_MAX);
    }
    struct area a = cover(transformer, columns, rows);
    enum pel_err err = choose(&a, spacing, fault);
    *out = (struct pel_raster_field){
        .columns = (int)fmax(2, round((a.east - a.west) / spacing)),
        .rows = (int)fmax(2, round((a.north - a.south) / spacing)),
        .spacing_m = spacing,
        .west_m = a.west + 0.5 * spacing,
        .south_m = a.south + 0.5 * spacing,
    };
    return err;
}

/* --- the heights ---------------------------------------------------------- */

static enum pel_err warp(GDALDatasetH set, const char *source,
                         const char *frame, const struct pel_raster_field *to,
                         GDALDatasetH *out, struct pel_fault *fault)
{
    char numbers[6][32];
    const double edges[] = {
        to->west_m - 0.5 * to->spacing_m,
        to->south_m - 0.5 * to->spacing_m,
        to->west_m + (to->columns - 0.5) * to->spacing_m,
        to->south_m + (to->rows - 0.5) * to->spacing_m,
    };
    for (int i = 0; i < 4; i++) {
        snprintf(numbers[i], sizeof *numbers, "%.9f", edges[i]);
    }
    snprintf(numbers[4], sizeof *numbers, "%d", to->columns);
    snprintf(numbers[5], sizeof *numbers, "%d", to->rows);
    const char *const words[] = {
        "-of",      "MEM",      "-ot",      "Float32",    "-b_srs",
        "",         "-t_srs",   frame,      "-te",        numbers[0],
        numbers[1], numbers[2], numbers[3], "-ts",        numbers[4],
        numbers[5], "-r",       "bilinear", "-dstnodata", "nan",
        "-wm",      "64",       "-et",      "0.001",      "-q"
    };
    char **list = NULL;
    for (size_t i = 0; i < sizeof words / sizeof *words; i++) {
        if (strcmp(words[i], "-b_srs") == 0) {
            i++; /* the source's, which it says itself or which is assumed */
            if (source) {
                list = CSLAddString(CSLAddString(list, "-s_srs"), source);
            }
            continue;
        }
        list = CSLAddString(list, words[i]);
    }
    int usage = FALSE;
    GDALWarpAppOptions *options = GDALWarpAppOptionsNew(list, NULL);
    *out = options ? GDALWarp("", NULL, 1, &set, options, &usage) : NULL;
    return *out ? PEL_OK
                : pel_fault_set(fault, PEL_ERR_MALFORMED, "%.160s",
                                CPLGetLastErrorMsg());
}

/* The meaning of the file's numbers. */
struct numbers {
    double scale, offset;
    struct pel_raster_meaning meaning;
    struct pel_raster_said said;
};

static enum pel_err take(GDALDatasetH warped, const struct numbers *numbers,
                         bool depths, struct pel_raster_field *out,
                         struct pel_fault *fault)
{
    double least = INFINITY, greatest = -INFINITY, factor = 1;
    int columns = out->columns, rows = out->rows;
    size_t count = (size_t)columns * (size_t)rows;
    float *from = malloc(sizeof *from * count);
    out->heights = malloc(sizeof *out->heights * count);
    if (!from || !out->heights ||
        GDALRasterIO(GDALGetRasterBand(warped, 1), GF_Read, 0, 0, columns, rows,
                     from, columns, rows, GDT_Float32, 0, 0)) {
        return pel_fault_set(fault, PEL_ERR_NO_MEMORY, "%.160s",
                             CPLGetLastErrorMsg());
    }
    for (size_t i = 0; i < count; i++) {
        double value = (double)from[i] * numbers->scale + numbers->offset;
        least = fmin(least, value); /* false for NaN */
        greatest = fmax(greatest, value);
    }
    /* Before its sign, which a fill value would decide. */
    enum pel_err err =
        pel_raster_check_fills(from, count, numbers->scale, numbers->offset,
                               numbers->meaning.metres, &numbers->said, fault);
    err = err ? err
              : pel_raster_sign(&numbers->meaning, depths, least, greatest,
                                &factor, fault);
    double scale = factor * numbers->scale, offset = factor * numbers->offset;
    for (int y = 0; y < rows && !err; y++) {
        const float *row = from + (size_t)(rows - 1 - y) * (size_t)columns;
        for (int x = 0; x < columns; x++) {
            out->heights[(size_t)y * (size_t)columns + (size_t)x] =
                (float)((double)row[x] * scale + offset);
        }
    }
    free(from);
    return err;
}

static enum pel_err find_exr(const char *path, bool *out,
                             struct pel_fault *fault)
{
    unsigned char magic[4] = { 0 };
    int fd;
    *out = false;
    enum pel_err err = pel_file_open(path, &fd, fault);
    if (!err) {
        *out = read(fd, magic, 4) == 4 &&
               memcmp(magic, "\x76\x2f\x31\x01", 4) == 0;
        close(fd);
    }
    return err;
}

static enum pel_err open_exr(const struct pel_raster_request *request,
                             GDALDatasetH *out, struct pel_fault *fault)
{
    struct pel_raster_plain plain;
    if (!request->placed) {
        return pel_fault_set(fault, PEL_ERR_INVALID,
                             "an OpenEXR has no georeference: set "
                             "seabed.latitude, seabed.longitude and "
                             "seabed.spacing");
    }
    enum pel_err err = pel_raster_read_exr(request->path, &plain, fault);
    *out = err ? NULL : place_plain(request, &plain);
    return !err && !*out ? pel_fault_set(fault, PEL_ERR_NO_MEMORY, "%s",
                                         CPLGetLastErrorMsg())
                         : err;
}

void pel_raster_prepare(const char *places[PEL_GDAL_MOST_PLACES + 1])
{
    pel_gdal_prepare(drivers, sizeof drivers / sizeof *drivers, places);
}

/* The CRS of its plane alone: GDAL's warp would convert the unit of a vertical
 * one, which pel_raster_mean has done. */
static char *plane_of(OGRSpatialReferenceH srs)
{
    char *wkt = NULL;
    OGRSpatialReferenceH plane = OSRClone(srs);
    OSRStripVertical(plane);
    OSRExportToWkt(plane, &wkt);
    OSRDestroySpatialReference(plane);
    return wkt;
}

/* Opens the raster, finds what its numbers mean and where it lies. */
static enum pel_err open_georaster(const struct pel_raster_request *request,
                                   GDALDatasetH *out, const char **frame,
                                   struct numbers *numbers,
                                   struct pel_fault *fault)
{
    struct pel_raster_said *said = &numbers->said;
    char *wkt = NULL;
    enum pel_err err = pel_raster_open_netcdf(request->path, out, said, fault);
    bool by_dims = *out != NULL;
    if (!err && !by_dims) {
        err = open_raster(request->path, out, fault);
    }
    if (err) {
        return err;
    }
    GDALRasterBandH band = GDALGetRasterBand(*out, 1);
    OGRSpatialReferenceH srs = GDALGetSpatialRef(*out);
    if (!by_dims) {
        pel_raster_said_by_band(band, said);
        const char *driver = GDALGetDriverShortName(GDALGetDatasetDriver(*out));
        said->up_by_bag = strcmp(driver, "BAG") == 0;
        said->netcdf = strcmp(driver, "netCDF") == 0;
    }
    if (srs && (by_dims || OSRIsVertical(srs))) {
        wkt = plane_of(srs);
    }
    numbers->scale = GDALGetRasterScale(band, NULL);
    numbers->offset = GDALGetRasterOffset(band, NULL);
    err = pel_raster_mean(said, srs, request->depths, &numbers->meaning, fault);
    err = err ? err : place_raster(request, out, frame, fault);
    if (!err && wkt && !request->placed) {
        *frame = wkt;
    }
    return err;
}

enum pel_err pel_raster_read(const struct pel_raster_request *request,
                             struct pel_raster_field *out,
                             struct pel_fault *fault)
{
    GDALDatasetH set = NULL, warped = NULL;
    bool exr = false;
    char frame[160];
    const char *source = NULL;
    struct numbers numbers = {
        .scale = 1, .meaning = { 1, PEL_RASTER_AS_ASKED, false, "" }
    };
    local_frame(request->origin_latitude, request->origin_longitude, frame);
    enum pel_err err = find_exr(request->path, &exr, fault);
    if (!err) {
        err = pel_gdal_check_hdf5(request->path, fault);
    }
    if (!err) {
        err = exr ? open_exr(request, &set, fault)
                  : open_georaster(request, &set, &source, &numbers, fault);
    }
    if (!err) {
        err = plan(request, set, source, frame, out, fault);
    }
    if (!err) {
        err = warp(set, source, frame, out, &warped, fault);
    }
    return err ? err : take(warped, &numbers, request->depths, out, fault);
}
