#include <hdf5.h>

#include "seabed/reader/gdal.h"

/* What was found, while the walk goes on. */
struct walk {
    const char *found;
};

static const char *storage_of(hid_t set)
{
    const char *found = NULL;
    hid_t list = H5Dget_create_plist(set);
    if (list < 0) {
        return NULL;
    }
    if (H5Pget_external_count(list) > 0) {
        found = "external storage";
    } else if (H5Pget_layout(list) == H5D_VIRTUAL) {
        found = "a virtual data set";
    }
    H5Pclose(list);
    return found;
}

static herr_t look(hid_t group, const char *name, const H5L_info_t *info,
                   void *user)
{
    struct walk *walk = user;
    if (info->type == H5L_TYPE_SOFT) {
        return 0;
    }
    if (info->type != H5L_TYPE_HARD) {
        walk->found = "an external link";
        return 1;
    }
    hid_t object = H5Oopen(group, name, H5P_DEFAULT);
    if (object < 0) {
        return 0;
    }
    if (H5Iget_type(object) == H5I_DATASET) {
        walk->found = storage_of(object);
    }
    H5Oclose(object);
    return walk->found ? 1 : 0;
}

enum pel_err pel_gdal_check_hdf5(const char *path, struct pel_fault *fault)
{
    struct walk walk = { NULL };
    H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
    H5PLset_loading_state(0); /* no filters from elsewhere */
    hid_t file =
        H5Fis_hdf5(path) > 0 ? H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT) : -1;
    if (file < 0) {
        return PEL_OK; /* whoever reads it says what is wrong */
    }
    herr_t walked = H5Lvisit(file, H5_INDEX_NAME, H5_ITER_NATIVE, look, &walk);
    H5Fclose(file);
    if (walk.found) {
        return pel_fault_set(fault, PEL_ERR_INVALID,
                             "it hands on to another file by %s; such HDF5 "
                             "files are not read",
                             walk.found);
    }
    return walked < 0 ? pel_fault_set(fault, PEL_ERR_MALFORMED,
                                      "its HDF5 groups cannot be listed")
                      : PEL_OK;
}
