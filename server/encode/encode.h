/* Image encoders: pixels in, file bytes out. Pure functions, any thread; no
 * GL, no sockets. Pixels are top row first, tightly packed. */
#pragma once

#include <stdatomic.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/err.h"
#include "encode/jpegcode.h"
#include "encode/photo.h"
#include "encode/planes.h"

/* Bytes owned by the struct's holder; free with pel_bytes_finish. */
struct pel_bytes {
    uint8_t *data;
    size_t size;
};
void pel_bytes_finish(struct pel_bytes *bytes);

/* Largest width and height of a picture [px]. */
#define PEL_ENCODE_MAX_SIZE 16384

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

/* What an encoder is given: each reads what its format has, the rest may be
 * zero. */
struct pel_encode_input {
    uint32_t width, height;    /* 1..PEL_ENCODE_MAX_SIZE */
    const atomic_bool *cancel; /* NULL, or true: give up soon with CONFLICT */

    /* 8-bit colour */
    const uint8_t *rgba;
    /* Instead of rgba, for JPEG: full range, whole blocks of 16x16 pixels,
     * beyond the picture its last column and row again. */
    const struct pel_planes_given *planes;
    /* Instead of both: what a device coded of them, in the file's size and
     * with its quality. */
    const struct pel_jpeg_scan *scan;
    uint32_t out_width, out_height;       /* of the file; 0: as they are */
    int quality;                          /* 1..100 */
    const struct pel_photo_blocks *photo; /* into the file; NULL: nothing */

    const char *text; /* ended by 0 */

    /* linear, by layers */
    bool float_samples; /* else half, rounded to nearest even */
    const struct pel_exr_layer *layers;
    size_t layer_count;
    const struct pel_exr_attribute *attributes;
    size_t attribute_count;
    /* Screen window at distance 1 of the standard header; width 0: 1. */
    float window_center[2], window_width;
    float pixel_aspect; /* width of a pixel over its height; 0: 1 */
};

/* The one form of an encoder. The same input gives the same bytes; on an error
 * *out is empty. INVALID for a size or a member out of its range, CONFLICT
 * when cancelled, NO_MEMORY, INTERNAL for what the library refuses. */
typedef enum pel_err pel_encode(const struct pel_encode_input *in,
                                struct pel_bytes *out);

/* RGBA, planes or a scan, quality and the file's size to JPEG 4:2:0 (libyuv's
 * planes, libjpeg-turbo); not cancelled, it takes milliseconds. INTERNAL too
 * where the scan is none. */
PEL_CHECK pel_encode pel_jpeg_encode;

/* RGBA to 8-bit RGB PNG (libspng), sRGB chunk set; alpha is dropped. INVALID
 * for another size of the file. */
PEL_CHECK pel_encode pel_png_encode;

/* Layers and attributes to single-part scan-line OpenEXR, ZIP compressed
 * (OpenEXRCore). INVALID for no or too many (64) channels, a name twice. NaN
 * and infinity are kept. */
PEL_CHECK pel_encode pel_exr_encode;

/* The text as it is. INVALID without one. */
PEL_CHECK pel_encode pel_text_encode;
