#include "encode/encode.h"

#include <openexr.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MAX_CHANNELS 64
#define NAME_SIZE 64

struct channel {
    char name[NAME_SIZE];
    const float *pixels; /* of its first sample */
    int stride;
    bool full_float;
};

struct writer {
    const struct pel_encode_input *image;
    struct channel channels[MAX_CHANNELS];
    int channel_count;
    uint8_t *data;
    size_t size, capacity;
    bool no_memory;
    exr_result_t (*compress)(exr_encode_pipeline_t *pipe); /* the library's */
};

/* --- the file, in memory ------------------------------------------------- */

static int64_t write_bytes(exr_const_context_t context, void *user,
                           const void *buffer, uint64_t size, uint64_t offset,
                           exr_stream_error_func_ptr_t error)
{
    struct writer *w = user;
    uint64_t end = offset + size;
    if (end > w->capacity) {
        size_t capacity = w->capacity + w->capacity / 2 + 65536;
        capacity = capacity < end ? (size_t)end : capacity;
        uint8_t *data = realloc(w->data, capacity);
        if (!data) {
            w->no_memory = true;
            error(context, EXR_ERR_OUT_OF_MEMORY, "no memory for the file");
            return -1;
        }
        w->data = data;
        w->capacity = capacity;
    }
    if (end > w->size) {
        /* A gap (the chunk table, filled at the end) is zero until then. */
        memset(w->data + w->size, 0, (size_t)end - w->size);
        w->size = (size_t)end;
    }
    memcpy(w->data + offset, buffer, (size_t)size);
    return (int64_t)size;
}

/* The result code says it already; the library would print. */
static void ignore_message(exr_const_context_t context, exr_result_t code,
                           const char *message)
{
    (void)context;
    (void)code;
    (void)message;
}

/* --- the header ---------------------------------------------------------- */

static bool has_channel(const struct writer *w, const char *name)
{
    for (int i = 0; i < w->channel_count; i++) {
        if (strcmp(w->channels[i].name, name) == 0) {
            return true;
        }
    }
    return false;
}

static enum pel_err list_layer(struct writer *w,
                               const struct pel_exr_layer *layer)
{
    if (!layer->pixels || !layer->channels || layer->stride < 1 ||
        layer->stride > 64 || (int)strlen(layer->channels) > layer->stride ||
        (layer->name && strlen(layer->name) > 48)) {
        return PEL_ERR_INVALID;
    }
    for (int i = 0; layer->channels[i]; i++) {
        struct channel channel = {
            .pixels = layer->pixels + i,
            .stride = layer->stride,
            .full_float = w->image->float_samples || layer->full_float,
        };
        snprintf(channel.name, sizeof channel.name, "%s%s%c",
                 layer->name ? layer->name : "", layer->name ? "." : "",
                 layer->channels[i]);
        if (w->channel_count == MAX_CHANNELS || has_channel(w, channel.name)) {
            return PEL_ERR_INVALID;
        }
        w->channels[w->channel_count++] = channel;
    }
    return PEL_OK;
}

static enum pel_err list_channels(struct writer *w)
{
    for (size_t i = 0; i < w->image->layer_count; i++) {
        enum pel_err err = list_layer(w, &w->image->layers[i]);
        if (err != PEL_OK) {
            return err;
        }
    }
    return w->channel_count > 0 ? PEL_OK : PEL_ERR_INVALID;
}

static exr_result_t add_attribute(exr_context_t context,
                                  const struct pel_exr_attribute *a)
{
    exr_attr_m44f_t matrix;
    switch (a->type) {
    case PEL_EXR_STRING:
        return exr_attr_set_string(context, 0, a->name, a->string);
    case PEL_EXR_DOUBLE:
        return exr_attr_set_double(context, 0, a->name, a->number);
    case PEL_EXR_FLOAT:
        return exr_attr_set_float(context, 0, a->name, (float)a->number);
    case PEL_EXR_INT:
        return exr_attr_set_int(context, 0, a->name, (int32_t)a->number);
    case PEL_EXR_MATRIX:
        memcpy(matrix.m, a->matrix, sizeof matrix.m);
        return exr_attr_set_m44f(context, 0, a->name, &matrix);
    }
    return EXR_ERR_INVALID_ARGUMENT;
}

static exr_result_t write_header(exr_context_t context, const struct writer *w)
{
    const struct pel_encode_input *image = w->image;
    int part = 0;
    exr_attr_box2i_t window = {
        .max = { .x = (int32_t)image->width - 1,
                 .y = (int32_t)image->height - 1 },
    };
    exr_attr_v2f_t center = { .x = image->window_center[0],
                              .y = image->window_center[1] };
    exr_result_t rc = exr_add_part(context, NULL, EXR_STORAGE_SCANLINE, &part);
    rc = rc ? rc
            : exr_initialize_required_attr(
                  context, part, &window, &window,
                  image->pixel_aspect > 0 ? image->pixel_aspect : 1.0f, &center,
                  image->window_width > 0 ? image->window_width : 1.0f,
                  EXR_LINEORDER_INCREASING_Y, EXR_COMPRESSION_ZIP);
    for (int i = 0; rc == 0 && i < w->channel_count; i++) {
        rc = exr_add_channel(context, part, w->channels[i].name,
                             w->channels[i].full_float ? EXR_PIXEL_FLOAT
                                                       : EXR_PIXEL_HALF,
                             EXR_PERCEPTUALLY_LINEAR, 1, 1);
    }
    for (size_t i = 0; rc == 0 && i < image->attribute_count; i++) {
        rc = add_attribute(context, &image->attributes[i]);
    }
    return rc ? rc : exr_write_header(context);
}

/* --- the pixels ---------------------------------------------------------- */

static const struct channel *find_channel(const struct writer *w,
                                          const char *name)
{
    for (int i = 0; i < w->channel_count; i++) {
        if (strcmp(w->channels[i].name, name) == 0) {
            return &w->channels[i];
        }
    }
    return NULL;
}

/* Points the pipeline at the caller's own pixels, so nothing is copied. */
static exr_result_t aim(const struct writer *w, exr_encode_pipeline_t *pipe,
                        int y)
{
    for (int i = 0; i < pipe->channel_count; i++) {
        exr_coding_channel_info_t *to = &pipe->channels[i];
        const struct channel *from = find_channel(w, to->channel_name);
        if (!from) {
            return EXR_ERR_INVALID_ARGUMENT;
        }
        size_t line = (size_t)w->image->width * (size_t)from->stride;
        to->user_bytes_per_element = sizeof(float);
        to->user_data_type = EXR_PIXEL_FLOAT;
        to->user_pixel_stride = from->stride * (int)sizeof(float);
        to->user_line_stride = (int32_t)(line * sizeof(float));
        to->encode_from_ptr =
            (const uint8_t *)(from->pixels + (size_t)y * line);
    }
    return EXR_ERR_SUCCESS;
}

static bool cancelled(const struct writer *w)
{
    return w->image->cancel && atomic_load(w->image->cancel);
}

/* A chunk as long in the file as in memory is read as it is, but the library
 * (3.1.5) writes the compressed bytes where they happen to be as many. */
static exr_result_t compress(exr_encode_pipeline_t *pipe)
{
    const struct writer *w = pipe->encoding_user_data;
    exr_result_t rc = w->compress(pipe);
    if (rc == 0 && pipe->compressed_bytes == pipe->packed_bytes) {
        memcpy(pipe->compressed_buffer, pipe->packed_buffer,
               pipe->packed_bytes);
    }
    return rc;
}

static exr_result_t write_pixels(exr_context_t context, struct writer *w)
{
    exr_encode_pipeline_t pipe = EXR_ENCODE_PIPELINE_INITIALIZER;
    int32_t lines = 0;
    exr_result_t rc = exr_get_scanlines_per_chunk(context, 0, &lines);
    int height = (int)w->image->height;
    for (int y = 0; rc == 0 && y < height && !cancelled(w); y += lines) {
        exr_chunk_info_t chunk = { 0 };
        rc = exr_write_scanline_chunk_info(context, 0, y, &chunk);
        if (rc == 0) {
            rc = y == 0 ? exr_encoding_initialize(context, 0, &chunk, &pipe)
                        : exr_encoding_update(context, 0, &chunk, &pipe);
        }
        rc = rc ? rc : aim(w, &pipe, y);
        if (rc == 0 && y == 0) {
            rc = exr_encoding_choose_default_routines(context, 0, &pipe);
            w->compress = pipe.compress_fn;
            pipe.compress_fn = compress;
            pipe.encoding_user_data = w;
        }
        rc = rc ? rc : exr_encoding_run(context, 0, &pipe);
    }
    exr_encoding_destroy(context, &pipe);
    return rc;
}

static enum pel_err write_file(struct writer *w)
{
    exr_context_initializer_t init = EXR_DEFAULT_CONTEXT_INITIALIZER;
    init.error_handler_fn = ignore_message;
    init.user_data = w;
    init.write_fn = write_bytes;
    init.max_image_width = PEL_ENCODE_MAX_SIZE;
    init.max_image_height = PEL_ENCODE_MAX_SIZE;
    init.zip_level = 4; /* 1 saves a tenth of the time */
    exr_context_t context = NULL;
    exr_result_t rc =
        exr_start_write(&context, "memory", EXR_WRITE_FILE_DIRECTLY, &init);
    if (rc == 0) {
        rc = write_header(context, w);
        rc = rc ? rc : write_pixels(context, w);
        exr_result_t end = exr_finish(&context);
        rc = rc ? rc : end;
    }
    if (cancelled(w)) {
        return PEL_ERR_CONFLICT;
    }
    if (w->no_memory || rc == EXR_ERR_OUT_OF_MEMORY) {
        return PEL_ERR_NO_MEMORY;
    }
    return rc == 0 ? PEL_OK : PEL_ERR_INTERNAL;
}

enum pel_err pel_exr_encode(const struct pel_encode_input *image,
                            struct pel_bytes *out)
{
    *out = (struct pel_bytes){ 0 };
    if (image->width < 1 || image->width > PEL_ENCODE_MAX_SIZE ||
        image->height < 1 || image->height > PEL_ENCODE_MAX_SIZE) {
        return PEL_ERR_INVALID;
    }
    struct writer w = { .image = image };
    enum pel_err err = list_channels(&w);
    if (err == PEL_OK) {
        err = write_file(&w);
    }
    if (err != PEL_OK) {
        free(w.data);
        return err;
    }
    *out = (struct pel_bytes){ .data = w.data, .size = w.size };
    return PEL_OK;
}
