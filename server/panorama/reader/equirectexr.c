#include <openexr.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "panorama/reader/equirect.h"

static void ignore_message(exr_const_context_t context, exr_result_t code,
                           const char *message)
{
    (void)context;
    (void)code;
    (void)message;
}

struct lines {
    float *rgb;  /* interleaved */
    float *rest; /* what else the file has */
    int columns;
    bool grey;
};

/* Where a channel goes: 0, 1, 2; -1: it is not wanted. */
static int place_of(const char *name, bool grey)
{
    static const char *const names[] = { "R", "G", "B" };
    for (int i = 0; i < 3; i++) {
        if (strcmp(name, grey ? "Y" : names[i]) == 0) {
            return i;
        }
    }
    return -1;
}

static exr_result_t decode(exr_context_t file, int y, const struct lines *to)
{
    exr_chunk_info_t chunk;
    exr_decode_pipeline_t pipe = EXR_DECODE_PIPELINE_INITIALIZER;
    exr_result_t rc = exr_read_scanline_chunk_info(file, 0, y, &chunk);
    if (rc == EXR_ERR_SUCCESS) {
        rc = exr_decoding_initialize(file, 0, &chunk, &pipe);
    }
    for (int i = 0; rc == EXR_ERR_SUCCESS && i < pipe.channel_count; i++) {
        exr_coding_channel_info_t *c = &pipe.channels[i];
        int place = place_of(c->channel_name, to->grey);
        if (place >= 0 && (c->x_samples != 1 || c->y_samples != 1)) {
            rc = EXR_ERR_INVALID_ATTR;
        }
        c->decode_to_ptr = (uint8_t *)(place >= 0 ? to->rgb + place : to->rest);
        c->user_bytes_per_element = 4;
        c->user_data_type = EXR_PIXEL_FLOAT;
        c->user_pixel_stride = place >= 0 ? 12 : 4;
        c->user_line_stride = to->columns * c->user_pixel_stride;
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

static enum pel_err find_channels(exr_context_t file, bool *grey,
                                  struct pel_fault *fault)
{
    const exr_attr_chlist_t *list = NULL;
    int found = 0;
    *grey = false;
    if (exr_get_channels(file, 0, &list) != EXR_ERR_SUCCESS) {
        return pel_fault_set(fault, PEL_ERR_MALFORMED,
                             "the OpenEXR has no channel");
    }
    for (int i = 0; i < list->num_channels; i++) {
        found += place_of(list->entries[i].name.str, false) >= 0;
        *grey = *grey || place_of(list->entries[i].name.str, true) >= 0;
    }
    *grey = *grey && found < 3;
    return *grey || found == 3
               ? PEL_OK
               : pel_fault_set(fault, PEL_ERR_INVALID,
                               "the OpenEXR has no channels R, G, B");
}

static enum pel_err add_lines(exr_context_t file, int top, int32_t count,
                              const struct lines *lines,
                              struct pel_equirect *out, struct pel_fault *fault)
{
    for (int64_t row = 0; row < out->file_rows; row += count) {
        exr_result_t rc = decode(file, (int)(top + row), lines);
        if (rc != EXR_ERR_SUCCESS) {
            return pel_fault_set(fault, PEL_ERR_MALFORMED,
                                 "row %d of the OpenEXR: %s", (int)row,
                                 exr_get_default_error_message(rc));
        }
        for (int i = 0; i < count && row + i < out->file_rows; i++) {
            float *line = lines->rgb + 3 * (size_t)i * (size_t)lines->columns;
            for (int x = 0; x < lines->columns && lines->grey; x++) {
                line[3 * x + 1] = line[3 * x + 2] = line[3 * x];
            }
            pel_equirect_add(out, (int)row + i, line);
        }
    }
    return PEL_OK;
}

static enum pel_err read_lines(exr_context_t file, int top,
                               struct pel_equirect *out,
                               struct pel_fault *fault)
{
    int32_t count = 0;
    struct lines lines = { .columns = out->file_columns };
    enum pel_err err = find_channels(file, &lines.grey, fault);
    if (err) {
        return err;
    }
    if (exr_get_scanlines_per_chunk(file, 0, &count) || count < 1) {
        return pel_fault_set(fault, PEL_ERR_MALFORMED,
                             "the OpenEXR has no lines");
    }
    size_t texels = (size_t)out->file_columns * (size_t)count;
    lines.rgb = calloc(3 * texels, sizeof *lines.rgb);
    lines.rest = calloc(texels, sizeof *lines.rest);
    err = lines.rgb && lines.rest
              ? add_lines(file, top, count, &lines, out, fault)
              : pel_fault_set(fault, PEL_ERR_NO_MEMORY, "out of memory");
    free(lines.rgb);
    free(lines.rest);
    return err;
}

static enum pel_err read_part(exr_context_t file, struct pel_equirect *out,
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
    if (columns < 1 || rows < 1 || columns > PEL_EQUIRECT_MOST_COLUMNS ||
        rows > PEL_EQUIRECT_MOST_COLUMNS) {
        columns = rows = 0; /* refused with its words */
    }
    enum pel_err err = pel_equirect_begin(out, (int)columns, (int)rows, fault);
    return err ? err : read_lines(file, box.min.y, out, fault);
}

enum pel_err pel_equirect_read_exr(const char *path, struct pel_equirect *out,
                                   struct pel_fault *fault)
{
    exr_context_initializer_t setup = EXR_DEFAULT_CONTEXT_INITIALIZER;
    exr_context_t file = NULL;
    setup.error_handler_fn = ignore_message;
    exr_set_default_maximum_image_size(PEL_EQUIRECT_MOST_COLUMNS,
                                       PEL_EQUIRECT_MOST_COLUMNS);
    exr_result_t rc = exr_start_read(&file, path, &setup);
    if (rc != EXR_ERR_SUCCESS) {
        return pel_fault_set(fault, PEL_ERR_MALFORMED, "no OpenEXR: %s",
                             exr_get_default_error_message(rc));
    }
    enum pel_err err = read_part(file, out, fault);
    exr_finish(&file);
    return err;
}
