#include "encode/encode.h"

#include <pthread.h>
#include <stdlib.h>
#include <string.h>
#include <turbojpeg.h>

#include "encode/planes.h"

/* What a thread keeps between pictures, so that the frame path allocates no
 * more than the bytes it hands out. */
struct compressor {
    tjhandle handle;
    unsigned char *scratch;
    unsigned long scratch_size;
    uint8_t *yuv; /* the planes */
    size_t yuv_size;
    struct pel_planes_scratch between;
};

static pthread_key_t compressor_key;
static pthread_once_t compressor_once = PTHREAD_ONCE_INIT;
static int compressor_key_error;

static void compressor_destroy(void *pointer)
{
    struct compressor *compressor = pointer;
    if (compressor->handle) {
        tjDestroy(compressor->handle);
    }
    free(compressor->scratch);
    free(compressor->yuv);
    pel_planes_scratch_finish(&compressor->between);
    free(compressor);
}

static void compressor_make_key(void)
{
    compressor_key_error =
        pthread_key_create(&compressor_key, compressor_destroy);
}

static struct compressor *compressor_get(void)
{
    pthread_once(&compressor_once, compressor_make_key);
    if (compressor_key_error != 0) {
        return NULL;
    }
    struct compressor *compressor = pthread_getspecific(compressor_key);
    if (compressor) {
        return compressor;
    }
    compressor = calloc(1, sizeof *compressor);
    if (!compressor) {
        return NULL;
    }
    compressor->handle = tjInitCompress();
    if (!compressor->handle ||
        pthread_setspecific(compressor_key, compressor) != 0) {
        compressor_destroy(compressor);
        return NULL;
    }
    return compressor;
}

/* Makes room for the largest JPEG of this size, and lays out its planes. */
static enum pel_err compressor_reserve(struct compressor *compressor,
                                       uint32_t width, uint32_t height,
                                       struct pel_planes *planes)
{
    unsigned long need = tjBufSize((int)width, (int)height, TJSAMP_420);
    if (need == (unsigned long)-1) {
        return PEL_ERR_INVALID;
    }
    if (need > compressor->scratch_size) {
        free(compressor->scratch);
        compressor->scratch = malloc(need);
        compressor->scratch_size = compressor->scratch ? need : 0;
    }
    size_t columns = (width + 1) / 2, rows = (height + 1) / 2;
    size_t luma = (size_t)width * height, size = luma + 2 * columns * rows;
    if (size > compressor->yuv_size) {
        free(compressor->yuv);
        compressor->yuv = malloc(size);
        compressor->yuv_size = compressor->yuv ? size : 0;
    }
    if (!compressor->scratch || !compressor->yuv) {
        return PEL_ERR_NO_MEMORY;
    }
    *planes = (struct pel_planes){
        .y = compressor->yuv,
        .u = compressor->yuv + luma,
        .v = compressor->yuv + luma + columns * rows,
        .y_stride = (int)width,
        .u_stride = (int)columns,
        .v_stride = (int)columns,
        .width = width,
        .height = height,
    };
    return PEL_OK;
}

static enum pel_err compress(struct compressor *compressor,
                             const struct pel_planes *planes, int quality,
                             struct pel_bytes *out)
{
    const unsigned char *parts[] = { planes->y, planes->u, planes->v };
    const int strides[] = { planes->y_stride, planes->u_stride,
                            planes->v_stride };
    unsigned long size = compressor->scratch_size;
    if (tjCompressFromYUVPlanes(compressor->handle, parts, (int)planes->width,
                                strides, (int)planes->height, TJSAMP_420,
                                &compressor->scratch, &size, quality,
                                TJFLAG_NOREALLOC) != 0) {
        return PEL_ERR_INTERNAL;
    }
    out->data = malloc(size);
    if (!out->data) {
        return PEL_ERR_NO_MEMORY;
    }
    memcpy(out->data, compressor->scratch, size);
    out->size = size;
    return PEL_OK;
}

enum pel_err pel_jpeg_encode_scaled(const uint8_t *rgba, uint32_t width,
                                    uint32_t height, uint32_t out_width,
                                    uint32_t out_height, int quality,
                                    struct pel_bytes *out)
{
    struct pel_planes planes;
    *out = (struct pel_bytes){ 0 };
    if (!rgba || width - 1 >= PEL_ENCODE_MAX_SIZE ||
        height - 1 >= PEL_ENCODE_MAX_SIZE ||
        out_width - 1 >= PEL_ENCODE_MAX_SIZE ||
        out_height - 1 >= PEL_ENCODE_MAX_SIZE || quality < 1 || quality > 100) {
        return PEL_ERR_INVALID;
    }
    struct compressor *compressor = compressor_get();
    if (!compressor) {
        return PEL_ERR_NO_MEMORY;
    }
    enum pel_err err =
        compressor_reserve(compressor, out_width, out_height, &planes);
    if (err == PEL_OK) {
        err = pel_planes_fill(rgba, (int)width * 4, width, height, true,
                              &compressor->between, &planes);
    }
    return err == PEL_OK ? compress(compressor, &planes, quality, out) : err;
}

enum pel_err pel_jpeg_encode(const uint8_t *rgba, uint32_t width,
                             uint32_t height, int quality,
                             struct pel_bytes *out)
{
    return pel_jpeg_encode_scaled(rgba, width, height, width, height, quality,
                                  out);
}
