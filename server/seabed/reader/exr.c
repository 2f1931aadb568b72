#include <math.h>
#include <openexr.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "seabed/reader/raster.h"

#define MOST_SIDE 16384

static void ignore_message(exr_const_context_t context, exr_result_t code,
                           const char *message)
{
    (void)context;
    (void)code;
    (void)message;
}

static int channel_of(const exr_attr_chlist_t *list)
{
    static const char *const names[] = { "Y", "Z", "height" };
    for (size_t n = 0; n < sizeof names / sizeof *names; n++) {
        for (int i = 0; i < list->num_channels; i++) {
            if (strcmp(list->entries[i].name.str, names[n]) == 0) {
                return i;
            }
        }
    }
    return 0;
}

/* Decodes the chunk that begins at line y; the channel named `name` goes to
 * `lines`, the others to `rest`: the library writes them whether they have a
 * place or not. */
static exr_result_t decode(exr_context_t file, int y, const char *name,
                           float *lines, float *rest, int columns)
{
    exr_chunk_info_t chunk;
    exr_decode_pipeline_t pipe = EXR_DECODE_PIPELINE_INITIALIZER;
    exr_result_t rc = exr_read_scanline_chunk_info(file, 0, y, &chunk);
    if (rc == EXR_ERR_SUCCESS) {
        rc = exr_decoding_initialize(file, 0, &chunk, &pipe);
    }
    for (int i = 0; rc == EXR_ERR_SUCCESS && i < pipe.channel_count; i++) {
        exr_coding_channel_info_t *c = &pipe.channels[i];
        bool wanted = strcmp(c->channel_name, name) == 0;
        if (wanted && (c->x_samples != 1 || c->y_samples != 1)) {
            rc = EXR_ERR_INVALID_ATTR;
        }
        c->decode_to_ptr = (uint8_t *)(wanted ? lines : rest);
        c->user_bytes_per_element = 4;
        c->user_data_type = EXR_PIXEL_FLOAT;
        c->user_pixel_stride = 4;
        c->user_line_stride = columns * 4;
    }
    if (rc == EXR_ERR_SUCCESS) {
        rc = exr_decoding_choose_default_routines(file, 0, &pipe);
    }
    if (rc == EXR_ERR_SUCCESS) {
        rc = exr_decoding_run(file, 0, &pipe);
    }
    exr_decoding_destroy(file, &pipe);
    return rc;
}

static enum pel_err read_lines(exr_context_t file, const exr_attr_box2i_t *box,
                               struct pel_raster_plain *out,
                               struct pel_fault *fault)
{
    const exr_attr_chlist_t *list = NULL;
    int32_t lines = 0;
    exr_result_t rc = exr_get_channels(file, 0, &list);
    if (rc == EXR_ERR_SUCCESS) {
        rc = exr_get_scanlines_per_chunk(file, 0, &lines);
    }
    if (rc != EXR_ERR_SUCCESS || list->num_channels < 1 || lines < 1) {
        return pel_fault_set(fault, PEL_ERR_MALFORMED,
                             "the OpenEXR has no channel");
    }
    const char *name = list->entries[channel_of(list)].name.str;
    float *rest = calloc((size_t)out->columns * (size_t)lines, sizeof *rest);
    if (!rest) {
        return pel_fault_set(fault, PEL_ERR_NO_MEMORY, "out of memory");
    }
    for (int64_t row = 0; row < out->rows; row += lines) {
        rc = decode(file, (int)(box->min.y + row), name,
                    out->values + row * out->columns, rest, out->columns);
        if (rc != EXR_ERR_SUCCESS) {
            return pel_fault_set(fault, PEL_ERR_MALFORMED,
                                 "row %d of the OpenEXR: %s", (int)row,
                                 exr_get_default_error_message(rc));
        }
    }
    return PEL_OK;
}

static enum pel_err read_part(exr_context_t file, struct pel_raster_plain *out,
                              struct pel_fault *fault)
{
    exr_attr_box2i_t box;
    exr_storage_t storage;
    int parts = 0;
    if (exr_get_count(file, &parts) || parts != 1 ||
        exr_get_storage(file, 0, &storage) || storage != EXR_STORAGE_SCANLINE) {
        return pel_fault_set(fault, PEL_ERR_INVALID,
                             "an OpenEXR of one part in scan lines is wanted");
    }
    if (exr_get_data_window(file, 0, &box)) {
        return pel_fault_set(fault, PEL_ERR_MALFORMED,
                             "the OpenEXR has no data window");
    }
    int64_t columns = (int64_t)box.max.x - box.min.x + 1;
    int64_t rows = (int64_t)box.max.y - box.min.y + 1;
    if (columns < 2 || rows < 2 || columns > MOST_SIDE || rows > MOST_SIDE ||
        columns * rows > PEL_RASTER_MOST_PIXELS) {
        return pel_fault_set(fault, PEL_ERR_OUT_OF_RANGE,
                             "the OpenEXR has %lld × %lld pixels; it must be "
                             "2 to %d each way and %d in all",
                             (long long)columns, (long long)rows, MOST_SIDE,
                             PEL_RASTER_MOST_PIXELS);
    }
    out->columns = (int)columns;
    out->rows = (int)rows;
    out->values = calloc((size_t)(columns * rows), sizeof *out->values);
    if (!out->values) {
        return pel_fault_set(fault, PEL_ERR_NO_MEMORY, "out of memory");
    }
    return read_lines(file, &box, out, fault);
}

enum pel_err pel_raster_read_exr(const char *path, struct pel_raster_plain *out,
                                 struct pel_fault *fault)
{
    exr_context_initializer_t setup = EXR_DEFAULT_CONTEXT_INITIALIZER;
    exr_context_t file = NULL;
    setup.error_handler_fn = ignore_message;
    exr_set_default_maximum_image_size(MOST_SIDE, MOST_SIDE);
    exr_result_t rc = exr_start_read(&file, path, &setup);
    if (rc != EXR_ERR_SUCCESS) {
        return pel_fault_set(fault, PEL_ERR_MALFORMED, "no OpenEXR: %s",
                             exr_get_default_error_message(rc));
    }
    enum pel_err err = read_part(file, out, fault);
    exr_finish(&file);
    return err;
}
