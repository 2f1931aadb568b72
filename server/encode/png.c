#include "encode/encode.h"

#include <spng.h>
#include <stdlib.h>

static void pack_rgb(const uint8_t *rgba, uint32_t width, uint8_t *rgb)
{
    for (uint32_t x = 0; x < width; x++) {
        rgb[3 * x] = rgba[4 * x];
        rgb[3 * x + 1] = rgba[4 * x + 1];
        rgb[3 * x + 2] = rgba[4 * x + 2];
    }
}

/* EXIF and XMP, where there are any. */
static int set_photo(spng_ctx *png, const struct pel_photo_blocks *photo)
{
    static char none[1]; /* spng reads it when rows are encoded */
    struct spng_exif exif = { .length = photo->exif_size,
                              .data = (char *)photo->exif };
    struct spng_text xmp = { .keyword = "XML:com.adobe.xmp",
                             .type = SPNG_ITXT,
                             .length = photo->xmp_size,
                             .text = (char *)photo->xmp,
                             .language_tag = none,
                             .translated_keyword = none };
    int rc = photo->exif_size ? spng_set_exif(png, &exif) : 0;
    return rc || !photo->xmp_size ? rc : spng_set_text(png, &xmp, 1);
}

/* A sea is smooth along the row and noisy across: one fixed filter and the
 * fastest deflate cost a fifth of the defaults and 10 % of the size. */
static int set_up(spng_ctx *png, uint32_t width, uint32_t height,
                  const struct pel_photo_blocks *photo)
{
    struct spng_ihdr header = {
        .width = width,
        .height = height,
        .bit_depth = 8,
        .color_type = SPNG_COLOR_TYPE_TRUECOLOR,
    };
    int rc = spng_set_option(png, SPNG_ENCODE_TO_BUFFER, 1);
    rc = rc ? rc : spng_set_option(png, SPNG_IMG_COMPRESSION_LEVEL, 1);
    rc = rc ? rc
            : spng_set_option(png, SPNG_FILTER_CHOICE, SPNG_FILTER_CHOICE_SUB);
    rc = rc ? rc : spng_set_ihdr(png, &header);
    rc = rc ? rc : spng_set_srgb(png, 0);
    rc = rc || !photo ? rc : set_photo(png, photo);
    return rc ? rc
              : spng_encode_image(png, NULL, 0, SPNG_FMT_PNG,
                                  SPNG_ENCODE_PROGRESSIVE |
                                      SPNG_ENCODE_FINALIZE);
}

enum pel_err pel_png_encode(const struct pel_encode_input *in,
                            struct pel_bytes *out)
{
    uint32_t width = in->width, height = in->height;
    *out = (struct pel_bytes){ 0 };
    if (!in->rgba || width < 1 || width > PEL_ENCODE_MAX_SIZE || height < 1 ||
        height > PEL_ENCODE_MAX_SIZE ||
        (in->out_width && in->out_width != width) ||
        (in->out_height && in->out_height != height)) {
        return PEL_ERR_INVALID;
    }
    enum pel_err err = PEL_ERR_NO_MEMORY;
    spng_ctx *png = spng_ctx_new(SPNG_CTX_ENCODER);
    uint8_t *row = malloc((size_t)width * 3);
    if (!png || !row) {
        goto done;
    }
    err = PEL_ERR_INTERNAL;
    int rc = set_up(png, width, height, in->photo);
    for (uint32_t y = 0; rc == 0 && y < height; y++) {
        if (in->cancel && atomic_load(in->cancel)) {
            err = PEL_ERR_CONFLICT;
            break;
        }
        pack_rgb(in->rgba + (size_t)y * width * 4, width, row);
        rc = spng_encode_row(png, row, (size_t)width * 3);
    }
    if (rc == SPNG_EMEM) {
        err = PEL_ERR_NO_MEMORY;
    }
    if (rc == SPNG_EOI) {
        out->data = spng_get_png_buffer(png, &out->size, &rc);
        err = out->data ? PEL_OK : PEL_ERR_NO_MEMORY;
    }
done:
    spng_ctx_free(png);
    free(row);
    return err;
}
