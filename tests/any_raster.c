/* What a height file could do without the reader's list of formats: opens it
 * with every driver that GDAL has, behind chosen walls of the sandbox or none,
 * and prints the first value of its first band. And makes HDF5 files that
 * hand on to others.
 *
 *   any_raster read none|files|calls|all FILE
 *   any_raster walls: those that this system has
 *   any_raster hdf5 storage|link|virtual|plain FILE OTHER */
#include <cpl_conv.h>
#include <cpl_error.h>
#include <gdal.h>
#include <hdf5.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/sandbox.h"

#define SIDE 64

static unsigned walls_of(const char *word)
{
    return strcmp(word, "all") == 0     ? PEL_SANDBOX_ALL
           : strcmp(word, "files") == 0 ? PEL_SANDBOX_FILES
           : strcmp(word, "calls") == 0 ? PEL_SANDBOX_CALLS
                                        : 0;
}

static int read_it(unsigned walls, const char *name)
{
    static const char *const readable[] = { ".", "/usr/share/proj",
                                            "/usr/share/gdal", NULL };
    const struct pel_sandbox sandbox = { readable, NULL, 10, 1u << 30, walls };
    struct pel_fault fault;
    float value = 0;
    CPLPushErrorHandler(CPLQuietErrorHandler);
    GDALAllRegister();
    if (walls && pel_sandbox_close(&sandbox, &fault)) {
        fprintf(stderr, "%s\n", fault.message);
        return 2;
    }
    GDALDatasetH set = GDALOpen(name, GA_ReadOnly);
    if (!set || GDALGetRasterCount(set) < 1 ||
        GDALRasterIO(GDALGetRasterBand(set, 1), GF_Read, 0, 0, 1, 1, &value, 1,
                     1, GDT_Float32, 0, 0)) {
        fprintf(stderr, "%s\n", CPLGetLastErrorMsg());
        return 1;
    }
    printf("%g\n", (double)value);
    GDALClose(set);
    return 0;
}

static bool make_set(hid_t file, const char *kind, const char *other)
{
    const hsize_t sides[] = { SIDE, SIDE };
    hid_t space = H5Screate_simple(2, sides, NULL);
    hid_t list = H5Pcreate(H5P_DATASET_CREATE);
    if (strcmp(kind, "storage") == 0) {
        H5Pset_external(list, other, 0, 4 * SIDE * SIDE);
    } else if (strcmp(kind, "virtual") == 0) {
        H5Pset_virtual(list, space, other, "/elevation", space);
    }
    hid_t set = H5Dcreate2(file, "elevation", H5T_IEEE_F32LE, space,
                           H5P_DEFAULT, list, H5P_DEFAULT);
    bool good = set >= 0;
    if (good && strcmp(kind, "plain") == 0) {
        static float values[SIDE * SIDE];
        for (int i = 0; i < SIDE * SIDE; i++) {
            values[i] = 777;
        }
        good = H5Dwrite(set, H5T_NATIVE_FLOAT, H5S_ALL, H5S_ALL, H5P_DEFAULT,
                        values) >= 0;
    }
    H5Dclose(set);
    H5Pclose(list);
    H5Sclose(space);
    return good;
}

static int make_hdf5(const char *kind, const char *name, const char *other)
{
    hid_t file = H5Fcreate(name, H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
    bool good = file >= 0;
    if (good && strcmp(kind, "link") == 0) {
        good = H5Lcreate_external(other, "/elevation", file, "elevation",
                                  H5P_DEFAULT, H5P_DEFAULT) >= 0;
    } else if (good) {
        good = make_set(file, kind, other);
    }
    H5Fclose(file);
    return good ? 0 : 1;
}

int main(int argc, char **argv)
{
    if (argc == 4 && strcmp(argv[1], "read") == 0) {
        const int status = read_it(walls_of(argv[2]), argv[3]);
        fflush(stdout);
        _exit(status); /* LSan has no eyes behind walls, and may wait for them
                        * for good */
    }
    if (argc == 5 && strcmp(argv[1], "hdf5") == 0) {
        return make_hdf5(argv[2], argv[3], argv[4]);
    }
    if (argc == 2 && strcmp(argv[1], "walls") == 0) {
        unsigned has = pel_sandbox_walls();
        printf("%s%s%s\n", has & PEL_SANDBOX_FILES ? "files " : "",
               has & PEL_SANDBOX_CALLS ? "calls " : "",
               has == PEL_SANDBOX_ALL ? "all" : "");
        return 0;
    }
    return 2;
}
