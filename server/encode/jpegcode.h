/* Baseline JPEGs, 4:2:0, whose scans a device codes (shaders/jpeg.comp): what
 * it has to know for that, and what it gives. The files have the same bytes as
 * those that pel_jpeg_encode makes of the pictures' planes. Any thread. */
#pragma once

#include <stddef.h>
#include <stdint.h>

#include "base/err.h"
#include "shaders/lib/blocks.h"

/* ITU-T T.81's tables of luma and of chroma, as the library has them, and as
 * shaders read them. */
struct pel_jpeg_tables {
    /* Codes of differences by their size, and of coefficients by 16 times the
     * run of zeros before and their size: bits of the code, and from bit 16 on
     * how many they are. */
    uint32_t dc[2][16], ac[2][256];
    uint32_t order[64]; /* of coefficients in the scan: 8 row + column */
    uint32_t place[64]; /* the other way round */
    /* By quality less 1: what the fast transform's coefficients, row after
     * row, are divided by, rounded to nearest, halves away from 0. */
    uint32_t divisors[PEL_JPEG_BEST][2][64];
};

/* NO_MEMORY. */
PEL_CHECK enum pel_err pel_jpeg_tables_fill(struct pel_jpeg_tables *tables);

/* A picture's scan. */
struct pel_jpeg_scan {
    /* PEL_JPEG_GROUP_WORDS a group: a number of bits, then these, the first the
     * highest of its word. */
    const uint32_t *words;
    int quality; /* it was made with, 1..PEL_JPEG_BEST */
};

/* Groups of a picture of this size [px]. */
size_t pel_jpeg_groups(uint32_t width, uint32_t height);

/* Bytes that such a scan fills at most, as in the file. */
size_t pel_jpeg_scan_most(const struct pel_jpeg_scan *scan, uint32_t width,
                          uint32_t height);

/* Writes the scan as it is in the file, up to where its next marker is; where
 * it ends. NULL: a group has more bits than it can have. */
uint8_t *pel_jpeg_scan_write(const struct pel_jpeg_scan *scan, uint32_t width,
                             uint32_t height, uint8_t *out);
