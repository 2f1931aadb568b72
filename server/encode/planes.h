/* RGBA pictures as 4:2:0 planes, of another size if wanted (libyuv): what
 * encoders take. Pure functions of their input; any thread. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/err.h"

struct pel_planes {
    uint8_t *y, *u, *v; /* v NULL: u holds pairs of u and v (NV12) */
    int y_stride, u_stride, v_stride;
    uint32_t width, height;
};

/* Planes that are only read. */
struct pel_planes_given {
    const uint8_t *y, *u, *v; /* v NULL: pairs, as above */
    int y_stride, u_stride, v_stride;
    uint32_t width, height;
};

/* Memory for pictures of another size, kept between them. All zero at the
 * start; free with pel_planes_scratch_finish. */
struct pel_planes_scratch {
    uint8_t *data;
    size_t size;
};
void pel_planes_scratch_finish(struct pel_planes_scratch *scratch);

/* Prefetches so many bytes of a picture into the processor's caches. */
void pel_planes_fetch(const uint8_t *pixels, size_t size);

/* Fills `out` from `rgba`, width x height pixels (1 .. 16384), rows `stride`
 * bytes apart, top row first. BT.601, studio range (16 .. 235) or, full_range,
 * JPEG's. Of the same size the pixels go straight into `out`; else through the
 * scratch (else it may be NULL), bilinear, by means of 2x2 or more where it
 * becomes smaller. NO_MEMORY; INVALID for a size out of range. */
PEL_CHECK enum pel_err pel_planes_fill(const uint8_t *rgba, int stride,
                                       uint32_t width, uint32_t height,
                                       bool full_range,
                                       struct pel_planes_scratch *scratch,
                                       const struct pel_planes *out);

/* The same from planes of the range that `out` is to have, and its bytes: the
 * first columns and rows of `from`, or scaled to out's size; through the
 * scratch where pairs become planes and are scaled. INVALID too for planes that
 * are to become pairs. */
PEL_CHECK enum pel_err pel_planes_take(const struct pel_planes_given *from,
                                       bool scaled,
                                       struct pel_planes_scratch *scratch,
                                       const struct pel_planes *out);
