#include <setjmp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <jpeglib.h>
#include <spng.h>

#include "models/reader/meshfile.h"

#define MOST_SIDE 16384u
#define MOST_PIXELS (1u << 28)

/* Rows of a picture come in from above and are averaged, factor × factor of
 * them a texel. Alpha is averaged too; colours as they are stored, which is
 * what filtering in hardware does at worst. */
struct shrink {
    unsigned width, height, factor, row;
    uint32_t *sums; /* of one row of texels */
    uint8_t *texels;
    int out_width, out_height;
};

static enum pel_err check_size(unsigned width, unsigned height,
                               struct pel_fault *fault)
{
    return width < 1 || height < 1 || width > MOST_SIDE || height > MOST_SIDE ||
                   (uint64_t)width * height > MOST_PIXELS
               ? pel_fault_set(fault, PEL_ERR_OUT_OF_RANGE,
                               "a texture of %u x %u pixels; at most %u a side "
                               "and %u in all: make it smaller",
                               width, height, MOST_SIDE, MOST_PIXELS)
               : PEL_OK;
}

static bool begin(struct shrink *s, unsigned width, unsigned height, int most)
{
    *s = (struct shrink){ .width = width, .height = height, .factor = 1 };
    while (width / s->factor > (unsigned)most ||
           height / s->factor > (unsigned)most) {
        s->factor *= 2;
    }
    s->out_width = (int)(width / s->factor > 0 ? width / s->factor : 1);
    s->out_height = (int)(height / s->factor > 0 ? height / s->factor : 1);
    s->sums = calloc((size_t)s->out_width * 4, sizeof *s->sums);
    s->texels = malloc((size_t)s->out_width * (size_t)s->out_height * 4);
    return s->sums && s->texels;
}

/* The next row from above, of `channels` 3 or 4. */
static void add_row(struct shrink *s, const uint8_t *row, unsigned channels)
{
    size_t line = s->row / s->factor;
    unsigned columns = s->factor < s->width ? s->factor : s->width;
    unsigned rows = s->factor < s->height ? s->factor : s->height;
    if (line >= (size_t)s->out_height) {
        return;
    }
    for (int x = 0; x < s->out_width; x++) {
        for (unsigned i = 0; i < columns; i++) {
            const uint8_t *p = row + ((size_t)x * s->factor + i) * channels;
            for (unsigned c = 0; c < 4; c++) {
                s->sums[4 * x + (int)c] += c < channels ? p[c] : 255;
            }
        }
    }
    s->row++;
    if (s->row % rows == 0) {
        uint8_t *to = s->texels + ((size_t)s->out_height - 1 - line) *
                                      (size_t)s->out_width * 4;
        for (int k = 0; k < 4 * s->out_width; k++) {
            to[k] =
                (uint8_t)((s->sums[k] + columns * rows / 2) / (columns * rows));
            s->sums[k] = 0;
        }
    }
}

static void finish(struct shrink *s, struct pel_model_texture *out)
{
    free(s->sums);
    *out = (struct pel_model_texture){ s->out_width, s->out_height, s->texels };
}

/* --- PNG
 * ------------------------------------------------------------------------ */

static enum pel_err decode_png(spng_ctx *png, const uint8_t *bytes, size_t size,
                               int most, struct pel_model_texture *out,
                               struct pel_fault *fault)
{
    struct spng_ihdr head;
    struct shrink s;
    if (spng_set_png_buffer(png, bytes, size) || spng_get_ihdr(png, &head)) {
        return pel_fault_set(fault, PEL_ERR_INVALID, "a damaged PNG");
    }
    enum pel_err err = check_size(head.width, head.height, fault);
    if (err) {
        return err;
    }
    size_t width = 4 * (size_t)head.width;
    bool whole = head.interlace_method != 0;
    uint8_t *pixels = malloc(whole ? width * head.height : width);
    if (!pixels || !begin(&s, head.width, head.height, most)) {
        return pel_fault_set(fault, PEL_ERR_NO_MEMORY,
                             "a texture of %u x %u pixels takes too much "
                             "memory; make it smaller",
                             head.width, head.height);
    }
    int bad = spng_decode_image(png, whole ? pixels : NULL,
                                whole ? width * head.height : 0, SPNG_FMT_RGBA8,
                                SPNG_DECODE_TRNS |
                                    (whole ? 0 : SPNG_DECODE_PROGRESSIVE));
    for (unsigned y = 0; y < head.height && !bad; y++) {
        if (!whole) {
            bad = spng_decode_row(png, pixels, width);
            bad = bad == SPNG_EOI ? 0 : bad;
        }
        add_row(&s, whole ? pixels + y * width : pixels, 4);
    }
    free(pixels);
    finish(&s, out);
    return bad ? pel_fault_set(fault, PEL_ERR_INVALID, "a damaged PNG: %s",
                               spng_strerror(bad))
               : PEL_OK;
}

static enum pel_err read_png(const uint8_t *bytes, size_t size, int most,
                             struct pel_model_texture *out,
                             struct pel_fault *fault)
{
    spng_ctx *png = spng_ctx_new(0);
    if (!png) {
        return pel_fault_set(fault, PEL_ERR_NO_MEMORY, "out of memory");
    }
    spng_set_crc_action(png, SPNG_CRC_USE, SPNG_CRC_USE);
    enum pel_err err = decode_png(png, bytes, size, most, out, fault);
    spng_ctx_free(png);
    return err;
}

/* --- JPEG
 * ------------------------------------------------------------------------- */

struct failure {
    struct jpeg_error_mgr base; /* first */
    jmp_buf back;
    char message[JMSG_LENGTH_MAX];
};

static void fail(j_common_ptr jpeg)
{
    struct failure *f = (struct failure *)jpeg->err;
    jpeg->err->format_message(jpeg, f->message);
    longjmp(f->back, 1);
}

static void be_quiet(j_common_ptr jpeg)
{
    (void)jpeg;
}

static enum pel_err decode_jpeg(struct jpeg_decompress_struct *jpeg, int most,
                                struct pel_model_texture *out,
                                struct pel_fault *fault)
{
    struct shrink s;
    jpeg_read_header(jpeg, TRUE);
    enum pel_err err = check_size(jpeg->image_width, jpeg->image_height, fault);
    if (err) {
        return err;
    }
    jpeg->out_color_space = JCS_RGB;
    jpeg_start_decompress(jpeg);
    uint8_t *row = malloc(3 * (size_t)jpeg->output_width);
    if (!row || !begin(&s, jpeg->output_width, jpeg->output_height, most)) {
        return pel_fault_set(fault, PEL_ERR_NO_MEMORY, "out of memory");
    }
    while (jpeg->output_scanline < jpeg->output_height) {
        jpeg_read_scanlines(jpeg, &row, 1);
        add_row(&s, row, 3);
    }
    free(row);
    finish(&s, out);
    return PEL_OK;
}

static enum pel_err read_jpeg(const uint8_t *bytes, size_t size, int most,
                              struct pel_model_texture *out,
                              struct pel_fault *fault)
{
    struct jpeg_decompress_struct jpeg;
    struct failure failure;
    jpeg.err = jpeg_std_error(&failure.base);
    failure.base.error_exit = fail;
    failure.base.output_message = be_quiet;
    if (setjmp(failure.back)) {
        jpeg_destroy_decompress(&jpeg);
        return pel_fault_set(fault, PEL_ERR_INVALID, "a damaged JPEG: %.120s",
                             failure.message);
    }
    jpeg_create_decompress(&jpeg);
    jpeg_mem_src(&jpeg, bytes, (unsigned long)size);
    enum pel_err err = decode_jpeg(&jpeg, most, out, fault);
    jpeg_destroy_decompress(&jpeg);
    return err;
}

enum pel_err pel_picture_read(const uint8_t *bytes, size_t size, int most,
                              struct pel_model_texture *out,
                              struct pel_fault *fault)
{
    if (size > 8 && memcmp(bytes, "\x89PNG\r\n\x1a\n", 8) == 0) {
        return read_png(bytes, size, most, out, fault);
    }
    if (size > 3 && memcmp(bytes, "\xff\xd8\xff", 3) == 0) {
        return read_jpeg(bytes, size, most, out, fault);
    }
    return pel_fault_set(fault, PEL_ERR_INVALID, "no PNG or JPEG");
}
