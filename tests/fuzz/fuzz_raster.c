/* Rasters of heights as pelagos-seabed reads them, and over the wire to the
 * daemon, which takes what the reader gives. The first byte: 1 placed by the
 * request, 2 depths, 4 a NetCDF file that the text behind it describes, else a
 * file as it is; 8: that NetCDF file is HDF5, 16 and has what hands on to
 * another file, by the first letter behind it. */
#include <math.h>
#include <stdio.h>

#include "fuzz_file.h"
#include "fuzz_kept.h"
#include "seabed/wire.h"

#include <cpl_string.h>
#include <gdal.h>
#include <gdal_alg.h>
#include <gdal_utils.h>
#include <hdf5.h>
#include <ogr_srs_api.h>

/* What GDAL gives and the reader's end takes back. */
enum kind { SET, TRANSFORMER, SRS, OPTIONS, LIST };
static struct {
    enum kind kind;
    void *what;
} given[256];
static size_t given_count;

static void *keep(enum kind kind, void *what)
{
    if (what && given_count < sizeof given / sizeof *given) {
        given[given_count].kind = kind;
        given[given_count++].what = what;
    }
    return what;
}

/* The newest first: data sets refer to others. */
static void give_back(void)
{
    while (given_count > 0) {
        void *what = given[--given_count].what;
        switch (given[given_count].kind) {
        case SET:
            GDALClose(what);
            break;
        case TRANSFORMER:
            GDALDestroyGenImgProjTransformer(what);
            break;
        case SRS:
            OSRDestroySpatialReference(what);
            break;
        case OPTIONS:
            GDALWarpAppOptionsFree(what);
            break;
        case LIST:
            CSLDestroy(what);
            break;
        }
    }
}

/* A list that grows is another; only its last form is kept. */
static char **grow(char **list, const char *word)
{
    for (size_t i = 0; list && i < given_count; i++) {
        if (given[i].what == (void *)list) {
            given[i].what = NULL;
        }
    }
    return keep(LIST, CSLAddString(list, word));
}

#define malloc(n) fuzz_keep(malloc(n))
#define calloc(n, s) fuzz_keep(calloc(n, s))
#define free(p) fuzz_drop(p)
#define GDALOpenEx(a, b, c, d, e) keep(SET, GDALOpenEx(a, b, c, d, e))
#define GDALCreate(a, b, c, d, e, f, g)                                        \
    keep(SET, GDALCreate(a, b, c, d, e, f, g))
#define GDALWarp(a, b, c, d, e, f) keep(SET, GDALWarp(a, b, c, d, e, f))
#define GDALCreateGenImgProjTransformer2(a, b, c)                              \
    keep(TRANSFORMER, GDALCreateGenImgProjTransformer2(a, b, c))
#define OSRNewSpatialReference(a) keep(SRS, OSRNewSpatialReference(a))
#define GDALWarpAppOptionsNew(a, b) keep(OPTIONS, GDALWarpAppOptionsNew(a, b))
#define CSLAddString(list, word) grow(list, word)
#include "seabed/reader/geo.c" /* NOLINT(bugprone-suspicious-include) */
#undef malloc
#undef calloc
#undef free

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static void demand(bool fine)
{
    if (!fine) {
        abort();
    }
}

/* e: an external link, s: a soft one, d: external storage, v: a virtual data
 * set, o: none of them. */
static void hand_on(const char *path, char how)
{
    hsize_t size = 4;
    hid_t file = H5Fopen(path, H5F_ACC_RDWR, H5P_DEFAULT);
    hid_t space = H5Screate_simple(1, &size, NULL);
    hid_t list = H5Pcreate(H5P_DATASET_CREATE);
    if (file >= 0 && how == 'e') {
        (void)H5Lcreate_external("other.h5", "/a", file, "away", H5P_DEFAULT,
                                 H5P_DEFAULT);
    } else if (file >= 0 && how == 's') {
        (void)H5Lcreate_soft("/nowhere", file, "soft", H5P_DEFAULT,
                             H5P_DEFAULT);
    } else if (file >= 0 && (how == 'd' || how == 'v')) {
        (void)(how == 'd'
                   ? H5Pset_external(list, "other", 0, 16)
                   : H5Pset_virtual(list, space, "other.h5", "/a", space));
        hid_t set = H5Dcreate2(file, "away", H5T_NATIVE_INT, space, H5P_DEFAULT,
                               list, H5P_DEFAULT);
        if (set >= 0) {
            H5Dclose(set);
        }
    }
    H5Pclose(list);
    H5Sclose(space);
    if (file >= 0) {
        H5Fclose(file);
    }
}

static const char *make_file(const uint8_t *data, size_t size)
{
    if (!(data[0] & 4)) {
        return fuzz_file(data + 1, size - 1);
    }
    if (!(data[0] & 8) || size < 2) {
        return fuzz_netcdf(data + 1, size - 1, NC_CLOBBER);
    }
    const char *path = fuzz_netcdf(data + 2, size - 2, NC_CLOBBER | NC_NETCDF4);
    if (path && data[0] & 16) {
        hand_on(path, (char)data[1]);
    }
    return path;
}

static void hand_over(const struct pel_raster_field *field)
{
    const struct pel_seabed *bed = NULL;
    struct pel_fault fault = { 0 };
    size_t values =
        sizeof(float) * (size_t)field->columns * (size_t)field->rows;
    unsigned char *bytes = malloc(PEL_SEABED_WIRE_HEAD + values);
    demand(bytes != NULL && field->columns <= PEL_SEABED_MOST &&
           field->rows <= PEL_SEABED_MOST);
    pel_seabed_wire_head(field->columns, field->rows, field->west_m,
                         field->south_m, field->spacing_m, bytes);
    memcpy(bytes + PEL_SEABED_WIRE_HEAD, field->heights, values);
    if (pel_seabed_wire_read(bytes, PEL_SEABED_WIRE_HEAD + values, &bed,
                             &fault)) {
        demand(fault.code != PEL_ERR_MALFORMED && fault.message[0] != '\0');
    } else {
        pel_seabed_unref(bed);
    }
    free(bytes);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static bool prepared;
    const char *places[PEL_GDAL_MOST_PLACES + 1];
    struct pel_raster_request request = { .origin_latitude = 52.6,
                                          .origin_longitude = 5.2,
                                          .latitude = 52.61,
                                          .longitude = 5.21,
                                          .spacing_m = 10 };
    struct pel_raster_field field = { 0 };
    struct pel_fault fault = { 0 };
    if (!prepared) {
        pel_raster_prepare(places);
        prepared = true;
    }
    if (size == 0) {
        return 0;
    }
    request.placed = data[0] & 1;
    request.depths = data[0] & 2;
    request.path = make_file(data, size);
    if (request.path && pel_raster_read(&request, &field, &fault)) {
        demand(fault.message[0] != '\0');
    } else if (request.path) {
        hand_over(&field);
    }
    give_back();
    fuzz_release();
    return 0;
}
