/* Pictures and texts that readers decode themselves: a panorama's Radiance and
 * OpenEXR, a height field's OpenEXR, a texture's PNG and JPEG, glTF's required
 * extensions. The first byte says which. */
#include <math.h>

#include "fuzz_file.h"
#include "fuzz_kept.h"
#include "models/reader/meshfile.h"
#include "panorama/reader/equirect.h"

#define malloc(n) fuzz_keep(malloc(n))
#define calloc(n, s) fuzz_keep(calloc(n, s))
#define free(p) fuzz_drop(p)
#include "models/reader/picture.c" /* NOLINT(bugprone-suspicious-include) */
#undef MOST_SIDE
#include "seabed/reader/exr.c" /* NOLINT(bugprone-suspicious-include) */
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

static void panorama(const uint8_t *data, size_t size, bool exr)
{
    struct pel_equirect e = { 0 };
    struct pel_fault fault = { 0 };
    const char *path = fuzz_file(data, size);
    if (exr ? pel_equirect_read_exr(path, &e, &fault)
            : pel_equirect_read_radiance(path, &e, &fault)) {
        demand(fault.message[0] != '\0');
    } else {
        demand(e.columns == 2 * e.rows && e.values != NULL);
        for (int i = 0; i < 3 * e.columns * e.rows; i++) {
            demand(e.values[i] >= 0);
        }
    }
    free(e.values);
}

static void heights(const uint8_t *data, size_t size)
{
    struct pel_raster_plain plain = { 0 };
    struct pel_fault fault = { 0 };
    if (pel_raster_read_exr(fuzz_file(data, size), &plain, &fault)) {
        demand(fault.message[0] != '\0');
    } else {
        demand(plain.columns >= 2 && plain.rows >= 2 && plain.values != NULL);
    }
}

static void texture(const uint8_t *data, size_t size)
{
    struct pel_model_texture t = { 0 };
    struct pel_fault fault = { 0 };
    int most = 64;
    if (pel_picture_read(data, size, most, &t, &fault)) {
        demand(fault.message[0] != '\0');
    } else {
        demand(t.width > 0 && t.width <= most && t.height > 0 &&
               t.height <= most && t.rgba != NULL);
    }
}

static void extensions(const uint8_t *data, size_t size)
{
    struct pel_fault fault = { 0 };
    if (pel_gltf_check(fuzz_file(data, size), &fault)) {
        demand(fault.message[0] != '\0');
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    if (size == 0) {
        return 0;
    }
    switch (data[0]) {
    case 'R':
    case 'E':
        panorama(data + 1, size - 1, data[0] == 'E');
        break;
    case 'H':
        heights(data + 1, size - 1);
        break;
    case 'T':
        texture(data + 1, size - 1);
        break;
    default:
        extensions(data + 1, size - 1);
        break;
    }
    fuzz_release();
    return 0;
}
