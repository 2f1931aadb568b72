#include "encode/planes.h"

#include <stdlib.h>

#include <libyuv.h>

#define MAX_SIZE 16384
#define ROWS 8 /* at a time; even, as chroma is of two */
#define CACHE_LINE 64

void pel_planes_scratch_finish(struct pel_planes_scratch *scratch)
{
    free(scratch->data);
    *scratch = (struct pel_planes_scratch){ 0 };
}

/* libyuv names channels from the last byte of a little-endian word to the
 * first: its ABGR is our RGBA. */
static int convert_rows(const uint8_t *rgba, int stride, bool full_range,
                        const struct pel_planes *out, int first, int rows)
{
    int width = (int)out->width;
    const uint8_t *from = rgba + (ptrdiff_t)first * stride;
    uint8_t *y = out->y + (ptrdiff_t)first * out->y_stride;
    uint8_t *u = out->u + (ptrdiff_t)first / 2 * out->u_stride;
    if (!out->v) {
        return ABGRToNV12(from, stride, y, out->y_stride, u, out->u_stride,
                          width, rows);
    }
    uint8_t *v = out->v + (ptrdiff_t)first / 2 * out->v_stride;
    return (full_range ? ABGRToJ420 : ABGRToI420)(
        from, stride, y, out->y_stride, u, out->u_stride, v, out->v_stride,
        width, rows);
}

void pel_planes_fetch(const uint8_t *pixels, size_t size)
{
    for (size_t i = 0; i < size; i += CACHE_LINE) {
        __builtin_prefetch(pixels + i);
    }
}

/* Memory is slower than the conversion: the next rows are on their way while
 * these are converted. */
static int convert(const uint8_t *rgba, int stride, bool full_range,
                   const struct pel_planes *out)
{
    int height = (int)out->height, status = 0;
    for (int first = 0; first < height && status == 0; first += ROWS) {
        int rows = height - first < ROWS ? height - first : ROWS;
        int next = height - first - rows < ROWS ? height - first - rows : ROWS;
        pel_planes_fetch(rgba + (ptrdiff_t)(first + rows) * stride,
                         (size_t)next * (size_t)stride);
        status = convert_rows(rgba, stride, full_range, out, first, rows);
    }
    return status;
}

static int scale(const struct pel_planes_given *from,
                 const struct pel_planes *to)
{
    bool smaller = to->width < from->width || to->height < from->height;
    enum FilterMode filter = smaller ? kFilterBox : kFilterBilinear;
    if (!to->v) {
        return NV12Scale(from->y, from->y_stride, from->u, from->u_stride,
                         (int)from->width, (int)from->height, to->y,
                         to->y_stride, to->u, to->u_stride, (int)to->width,
                         (int)to->height, filter);
    }
    return I420Scale(from->y, from->y_stride, from->u, from->u_stride, from->v,
                     from->v_stride, (int)from->width, (int)from->height, to->y,
                     to->y_stride, to->u, to->u_stride, to->v, to->v_stride,
                     (int)to->width, (int)to->height, filter);
}

/* Planes of this size in the scratch, laid out as `like`. */
static bool lay_out(struct pel_planes_scratch *scratch, uint32_t width,
                    uint32_t height, const struct pel_planes *like,
                    struct pel_planes *out)
{
    size_t columns = (width + 1) / 2, rows = (height + 1) / 2;
    size_t luma = (size_t)width * height, size = luma + 2 * columns * rows;
    if (size > scratch->size) {
        free(scratch->data);
        scratch->data = malloc(size);
        scratch->size = scratch->data ? size : 0;
    }
    uint8_t *u = scratch->data + luma;
    *out = (struct pel_planes){
        .y = scratch->data,
        .u = u,
        .v = like->v ? u + columns * rows : NULL,
        .y_stride = (int)width,
        .u_stride = (int)(like->v ? columns : 2 * columns),
        .v_stride = (int)columns,
        .width = width,
        .height = height,
    };
    return scratch->data != NULL;
}

static struct pel_planes_given given(const struct pel_planes *p)
{
    return (struct pel_planes_given){ p->y,        p->u,        p->v,
                                      p->y_stride, p->u_stride, p->v_stride,
                                      p->width,    p->height };
}

enum pel_err pel_planes_fill(const uint8_t *rgba, int stride, uint32_t width,
                             uint32_t height, bool full_range,
                             struct pel_planes_scratch *scratch,
                             const struct pel_planes *out)
{
    struct pel_planes between;
    if (!rgba || width - 1 >= MAX_SIZE || height - 1 >= MAX_SIZE ||
        out->width - 1 >= MAX_SIZE || out->height - 1 >= MAX_SIZE) {
        return PEL_ERR_INVALID;
    }
    if (width == out->width && height == out->height) {
        return convert(rgba, stride, full_range, out) == 0 ? PEL_OK
                                                           : PEL_ERR_INVALID;
    }
    if (!lay_out(scratch, width, height, out, &between)) {
        return PEL_ERR_NO_MEMORY;
    }
    const struct pel_planes_given made = given(&between);
    return convert(rgba, stride, full_range, &between) == 0 &&
                   scale(&made, out) == 0
               ? PEL_OK
               : PEL_ERR_INVALID;
}

/* The first columns and rows, pairs taken apart where `to` has planes. */
static int copy(const struct pel_planes_given *from,
                const struct pel_planes *to)
{
    int width = (int)to->width, height = (int)to->height;
    if (from->v) {
        return I420Copy(from->y, from->y_stride, from->u, from->u_stride,
                        from->v, from->v_stride, to->y, to->y_stride, to->u,
                        to->u_stride, to->v, to->v_stride, width, height);
    }
    if (to->v) {
        return NV12ToI420(from->y, from->y_stride, from->u, from->u_stride,
                          to->y, to->y_stride, to->u, to->u_stride, to->v,
                          to->v_stride, width, height);
    }
    return NV12Copy(from->y, from->y_stride, from->u, from->u_stride, to->y,
                    to->y_stride, to->u, to->u_stride, width, height);
}

enum pel_err pel_planes_take(const struct pel_planes_given *from, bool scaled,
                             struct pel_planes_scratch *scratch,
                             const struct pel_planes *out)
{
    struct pel_planes between;
    struct pel_planes_given here = *from;
    if ((from->v && !out->v) || from->width - 1 >= MAX_SIZE ||
        from->height - 1 >= MAX_SIZE || out->width - 1 >= MAX_SIZE ||
        out->height - 1 >= MAX_SIZE ||
        (!scaled && (out->width > from->width || out->height > from->height))) {
        return PEL_ERR_INVALID;
    }
    if (!scaled) {
        return copy(from, out) == 0 ? PEL_OK : PEL_ERR_INVALID;
    }
    if (!from->v && out->v) {
        if (!lay_out(scratch, from->width, from->height, out, &between)) {
            return PEL_ERR_NO_MEMORY;
        }
        if (copy(from, &between) != 0) {
            return PEL_ERR_INVALID;
        }
        here = given(&between);
    }
    return scale(&here, out) == 0 ? PEL_OK : PEL_ERR_INVALID;
}
