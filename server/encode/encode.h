/* Image encoders: pixels in, file bytes out. Pure functions, any thread; no
 * GL, no sockets. Pixels are top row first, tightly packed. */
#pragma once

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

/* RGBA to JPEG 4:2:0 (libturbojpeg); quality 1..100. */
PEL_CHECK enum pel_err pel_jpeg_encode(const uint8_t *rgba, uint32_t width,
                                       uint32_t height, int quality,
                                       struct pel_bytes *out);

/* RGBA to 8-bit RGB PNG (libspng), sRGB chunk set. */
PEL_CHECK enum pel_err pel_png_encode(const uint8_t *rgba, uint32_t width,
                                      uint32_t height, struct pel_bytes *out);

/* One EXR layer: `components` channels taken from pixels that are `stride`
 * floats apart. Channel names: "R" for layer NULL, else "layer.R". */
struct pel_exr_layer {
    const char *name; /* NULL: the default layer */
    const char *channels; /* "RGB", "XYZ", "Z": one letter a component */
    const float *pixels;
    int stride;
    bool full_float; /* 32-bit even in a half file (depth) */
};

struct pel_exr_attribute {
    const char *name;
    enum { PEL_EXR_STRING, PEL_EXR_DOUBLE, PEL_EXR_INT } type;
    const char *string;
    double number;
};

struct pel_exr_image {
    uint32_t width, height;
    bool float_samples; /* else half */
    const struct pel_exr_layer *layers;
    size_t layer_count;
    const struct pel_exr_attribute *attributes;
    size_t attribute_count;
};

/* Single-part scan-line OpenEXR, ZIP compressed (OpenEXRCore). */
PEL_CHECK enum pel_err pel_exr_encode(const struct pel_exr_image *image,
                                      struct pel_bytes *out);
