#include "encode/encode.h"

#include <pthread.h>
#include <stdlib.h>
#include <string.h>
#include <turbojpeg.h>

/* What a thread keeps between pictures, so that the frame path allocates no
 * more than the bytes it hands out. */
struct compressor {
    tjhandle handle;
    unsigned char *scratch;
    unsigned long scratch_size;
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

/* Makes room for the largest JPEG of this size. */
static enum pel_err compressor_reserve(struct compressor *compressor,
                                       uint32_t width, uint32_t height)
{
    unsigned long need = tjBufSize((int)width, (int)height, TJSAMP_420);
    if (need == (unsigned long)-1) {
        return PEL_ERR_INVALID;
    }
    if (need > compressor->scratch_size) {
        free(compressor->scratch);
        compressor->scratch_size = 0;
        compressor->scratch = malloc(need);
        if (!compressor->scratch) {
            return PEL_ERR_NO_MEMORY;
        }
        compressor->scratch_size = need;
    }
    return PEL_OK;
}

enum pel_err pel_jpeg_encode(const uint8_t *rgba, uint32_t width,
                             uint32_t height, int quality,
                             struct pel_bytes *out)
{
    *out = (struct pel_bytes){ 0 };
    if (!rgba || width < 1 || width > PEL_ENCODE_MAX_SIZE || height < 1 ||
        height > PEL_ENCODE_MAX_SIZE || quality < 1 || quality > 100) {
        return PEL_ERR_INVALID;
    }
    struct compressor *compressor = compressor_get();
    if (!compressor) {
        return PEL_ERR_NO_MEMORY;
    }
    enum pel_err err = compressor_reserve(compressor, width, height);
    if (err != PEL_OK) {
        return err;
    }
    unsigned long size = compressor->scratch_size;
    if (tjCompress2(compressor->handle, rgba, (int)width, 0, (int)height,
                    TJPF_RGBA, &compressor->scratch, &size, TJSAMP_420, quality,
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
