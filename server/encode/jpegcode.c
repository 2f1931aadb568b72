#include "encode/jpegcode.h"

#include <math.h>
#include <setjmp.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

#include <jpeglib.h>

#define UNIT 16 /* pixels of a side */
#define MOST_BITS (32 * PEL_JPEG_MOST_WORDS)

/* --- tables --------------------------------------------------------------- */

static void fill_order(struct pel_jpeg_tables *t)
{
    unsigned at = 0;
    for (unsigned diagonal = 0; diagonal < 15; diagonal++) {
        for (unsigned i = 0; i <= diagonal; i++) {
            unsigned row = diagonal % 2 ? i : diagonal - i;
            unsigned column = diagonal - row;
            if (row < 8 && column < 8) {
                t->order[at] = 8 * row + column;
                t->place[8 * row + column] = at++;
            }
        }
    }
}

/* Codes are counted up, and have one more bit from length to length. */
static void fill_codes(const JHUFF_TBL *from, uint32_t *out)
{
    uint32_t code = 0;
    unsigned at = 0;
    for (uint32_t length = 1; length <= 16; length++) {
        for (unsigned i = 0; i < from->bits[length]; i++) {
            out[from->huffval[at++]] = code++ | length << 16;
        }
        code <<= 1;
    }
}

/* Arai, Agui and Nakajima's transform leaves each row and column times a factor
 * of its own, and all times 8; the library keeps 14 bits of their products. */
static void fill_divisors(const JQUANT_TBL *from, uint32_t out[64])
{
    for (int i = 0; i < 64; i++) {
        int row = i / 8, column = i % 8;
        double a = row ? M_SQRT2 * cos(row * M_PI / 16) : 1;
        double b = column ? M_SQRT2 * cos(column * M_PI / 16) : 1;
        uint32_t scale = (uint32_t)lrint(16384 * a * b);
        out[i] = (from->quantval[i] * scale + 1024) >> 11;
    }
}

struct failing {
    struct jpeg_error_mgr errors; /* first: the library knows no other */
    jmp_buf out;
};

_Noreturn static void give_up(j_common_ptr library)
{
    longjmp(((struct failing *)library->err)->out, 1);
}

enum pel_err pel_jpeg_tables_fill(struct pel_jpeg_tables *tables)
{
    struct jpeg_compress_struct library = { 0 };
    struct failing failing;
    library.err = jpeg_std_error(&failing.errors);
    failing.errors.error_exit = give_up;
    memset(tables, 0, sizeof *tables);
    if (setjmp(failing.out) != 0) {
        jpeg_destroy_compress(&library);
        return PEL_ERR_NO_MEMORY;
    }
    jpeg_create_compress(&library);
    library.input_components = 3;
    library.in_color_space = JCS_YCbCr;
    jpeg_set_defaults(&library);
    for (int k = 0; k < 2; k++) {
        fill_codes(library.dc_huff_tbl_ptrs[k], tables->dc[k]);
        fill_codes(library.ac_huff_tbl_ptrs[k], tables->ac[k]);
    }
    for (int quality = 1; quality <= PEL_JPEG_BEST; quality++) {
        jpeg_set_quality(&library, quality, TRUE);
        for (int k = 0; k < 2; k++) {
            fill_divisors(library.quant_tbl_ptrs[k],
                          tables->divisors[quality - 1][k]);
        }
    }
    fill_order(tables);
    jpeg_destroy_compress(&library);
    return PEL_OK;
}

/* --- the scan ------------------------------------------------------------- */

size_t pel_jpeg_groups(uint32_t width, uint32_t height)
{
    size_t units = ((size_t)width + UNIT - 1) / UNIT *
                   (((size_t)height + UNIT - 1) / UNIT);
    return (units + PEL_JPEG_UNITS - 1) / PEL_JPEG_UNITS;
}

static const uint32_t *group(const struct pel_jpeg_scan *scan, size_t i)
{
    return scan->words + i * PEL_JPEG_GROUP_WORDS;
}

size_t pel_jpeg_scan_most(const struct pel_jpeg_scan *scan, uint32_t width,
                          uint32_t height)
{
    size_t groups = pel_jpeg_groups(width, height), bits = 0;
    for (size_t i = 0; i < groups; i++) {
        uint32_t own = *group(scan, i); /* or nonsense, which is not written */
        bits += own <= MOST_BITS ? own : 0;
    }
    return 2 * (bits / 8 + 1); /* each byte may need a zero behind it */
}

struct writer {
    uint8_t *out;
    uint64_t kept; /* bits that fill no word yet: its lowest */
    unsigned count;
};

static void put_byte(struct writer *w, uint8_t byte)
{
    *w->out++ = byte;
    if (byte == 0xFF) {
        *w->out++ = 0;
    }
}

/* Whether a byte of it is 0xFF: of its complement, 0. */
static bool any_full(uint32_t word)
{
    return ((~word - 0x01010101u) & word & 0x80808080u) != 0;
}

static void put_word(struct writer *w, uint32_t word)
{
    if (any_full(word)) {
        for (int shift = 24; shift >= 0; shift -= 8) {
            put_byte(w, (uint8_t)(word >> shift));
        }
        return;
    }
    uint32_t bytes = __builtin_bswap32(word);
    memcpy(w->out, &bytes, sizeof bytes);
    w->out += sizeof bytes;
}

/* The highest `count` bits of a word, 1..32. */
static void put_bits(struct writer *w, uint32_t word, unsigned count)
{
    w->kept = w->kept << count | word >> (32 - count);
    w->count += count;
    if (w->count >= 32) {
        w->count -= 32;
        put_word(w, (uint32_t)(w->kept >> w->count));
    }
}

uint8_t *pel_jpeg_scan_write(const struct pel_jpeg_scan *scan, uint32_t width,
                             uint32_t height, uint8_t *out)
{
    size_t groups = pel_jpeg_groups(width, height);
    struct writer w = { .out = out };
    for (size_t i = 0; i < groups; i++) {
        const uint32_t *word = group(scan, i);
        uint32_t left = *word++;
        if (left > MOST_BITS) {
            return NULL;
        }
        for (; left >= 32; left -= 32) {
            put_bits(&w, *word++, 32);
        }
        if (left > 0) {
            put_bits(&w, *word, left);
        }
    }
    /* Ones to the end of its last byte. */
    unsigned rest = (8 - w.count % 8) % 8;
    w.kept = w.kept << rest | ((1u << rest) - 1);
    for (w.count += rest; w.count > 0; w.count -= 8) {
        put_byte(&w, (uint8_t)(w.kept >> (w.count - 8)));
    }
    return w.out;
}
