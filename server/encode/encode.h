/* Image encoders: pixels in, file bytes out. Pure functions, any thread; no
 * GL, no sockets. Pixels are top row first, tightly packed. */
#pragma once

#include <stdatomic.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/err.h"

/* Bytes owned by whoever holds the struct; free with pel_bytes_finish. */
struct pel_bytes {
    uint8_t *data;
    size_t size;
};
void pel_bytes_finish(struct pel_bytes *bytes);

/* Largest width and height of a picture [px]. */
#define PEL_ENCODE_MAX_SIZE 16384

/* RGBA to JPEG 4:2:0 (libyuv's planes, libjpeg-turbo); quality 1..100. INVALID
 * for a size outside 1..PEL_ENCODE_MAX_SIZE or a quality out of range,
 * NO_MEMORY. The same pixels give the same bytes. */
PEL_CHECK enum pel_err pel_jpeg_encode(const uint8_t *rgba, uint32_t width,
                                       uint32_t height, int quality,
                                       struct pel_bytes *out);

/* The same, scaled to out_width x out_height. */
PEL_CHECK enum pel_err pel_jpeg_encode_scaled(const uint8_t *rgba,
                                              uint32_t width, uint32_t height,
                                              uint32_t out_width,
                                              uint32_t out_height, int quality,
                                              struct pel_bytes *out);

/* RGBA to 8-bit RGB PNG (libspng), sRGB chunk set; alpha is dropped. Errors as
 * above. */
PEL_CHECK enum pel_err pel_png_encode(const uint8_t *rgba, uint32_t width,
                                      uint32_t height, struct pel_bytes *out);

/* The same; CONFLICT soon after *cancel became true. */
PEL_CHECK enum pel_err pel_png_encode_until(const uint8_t *rgba, uint32_t width,
                                            uint32_t height,
                                            const atomic_bool *cancel,
                                            struct pel_bytes *out);

/* One EXR layer: `channels` components taken from pixels that are `stride`
 * floats apart. Channel names: "R" for layer NULL, else "layer.R". */
struct pel_exr_layer {
    const char *name;     /* NULL: the default layer */
    const char *channels; /* "RGB", "XYZ", "Z": one letter a component */
    const float *pixels;
    int stride;
    bool full_float; /* 32-bit even in a half file (depth) */
};

struct pel_exr_attribute {
    const char *name; /* 1..31 characters */
    enum {
        PEL_EXR_STRING,
        PEL_EXR_DOUBLE,
        PEL_EXR_FLOAT,
        PEL_EXR_INT,
        PEL_EXR_MATRIX, /* m44f, row vectors: v' = v M */
    } type;
    const char *string;
    double number;
    const float *matrix; /* 16 numbers, row after row */
};

struct pel_exr_image {
    uint32_t width, height;
    bool float_samples; /* else half, rounded to nearest even */
    const struct pel_exr_layer *layers;
    size_t layer_count;
    const struct pel_exr_attribute *attributes;
    size_t attribute_count;
    /* Screen window at distance 1 of the standard header; width 0: 1. */
    float window_center[2], window_width;
    float pixel_aspect;        /* width of a pixel over its height; 0: 1 */
    const atomic_bool *cancel; /* NULL, or true: give up with CONFLICT */
};

/* Single-part scan-line OpenEXR, ZIP compressed (OpenEXRCore). INVALID for a
 * bad size, no or too many (64) channels, a name twice; CONFLICT when
 * cancelled; NO_MEMORY; INTERNAL for what the library refuses. NaN and
 * infinity are kept. */
PEL_CHECK enum pel_err pel_exr_encode(const struct pel_exr_image *image,
                                      struct pel_bytes *out);
