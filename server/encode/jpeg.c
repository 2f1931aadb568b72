#include "encode/encode.h"

#include <pthread.h>
#include <setjmp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <jpeglib.h>

#include "encode/planes.h"

/* Rows that the library takes at a time: of luma, of the others half. */
#define ROWS (2 * DCTSIZE)

/* What a thread keeps between pictures, so that the frame path allocates no
 * more than the bytes it hands out. */
struct compressor {
    struct jpeg_compress_struct library;
    struct jpeg_error_mgr errors;
    jmp_buf failed;
    unsigned char *scratch; /* the file being made */
    unsigned long scratch_size;
    uint8_t *planes; /* a strip, or a whole picture of another size */
    size_t planes_size;
    struct pel_planes_scratch between;
};

static pthread_key_t compressor_key;
static pthread_once_t compressor_once = PTHREAD_ONCE_INIT;
static int compressor_key_error;

static void compressor_destroy(void *pointer)
{
    struct compressor *compressor = pointer;
    jpeg_destroy_compress(&compressor->library);
    free(compressor->scratch);
    free(compressor->planes);
    pel_planes_scratch_finish(&compressor->between);
    free(compressor);
}

static void compressor_make_key(void)
{
    compressor_key_error =
        pthread_key_create(&compressor_key, compressor_destroy);
}

/* The library's way out: it must not return. */
static void give_up(j_common_ptr library)
{
    struct compressor *compressor = (struct compressor *)library;
    longjmp(compressor->failed, 1);
}

static void keep_silent(j_common_ptr library)
{
    (void)library;
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
    compressor->library.err = jpeg_std_error(&compressor->errors);
    compressor->errors.error_exit = give_up;
    compressor->errors.output_message = keep_silent;
    if (setjmp(compressor->failed) != 0) {
        compressor_destroy(compressor);
        return NULL;
    }
    jpeg_create_compress(&compressor->library);
    if (pthread_setspecific(compressor_key, compressor) != 0) {
        compressor_destroy(compressor);
        return NULL;
    }
    return compressor;
}

/* Makes room for the largest JPEG of this size, as turbojpeg reckons it, and
 * for `rows` rows of planes, as wide as blocks go. */
static enum pel_err reserve(struct compressor *compressor, uint32_t width,
                            uint32_t height, uint32_t rows,
                            struct pel_planes *planes)
{
    size_t wide = ((size_t)width + ROWS - 1) / ROWS * ROWS;
    size_t high = ((size_t)height + ROWS - 1) / ROWS * ROWS;
    size_t need = wide * high * 3 + 2048 + sizeof(struct pel_photo_blocks);
    size_t luma = wide * rows, size = luma * 3 / 2;
    if (need > compressor->scratch_size) {
        free(compressor->scratch);
        compressor->scratch = malloc(need);
        compressor->scratch_size = compressor->scratch ? need : 0;
    }
    if (size > compressor->planes_size) {
        free(compressor->planes);
        compressor->planes = malloc(size);
        compressor->planes_size = compressor->planes ? size : 0;
    }
    if (!compressor->scratch || !compressor->planes) {
        return PEL_ERR_NO_MEMORY;
    }
    *planes = (struct pel_planes){
        .y = compressor->planes,
        .u = compressor->planes + luma,
        .v = compressor->planes + luma * 5 / 4,
        .y_stride = (int)wide,
        .u_stride = (int)(wide / 2),
        .v_stride = (int)(wide / 2),
        .width = width,
        .height = height,
    };
    return PEL_OK;
}

/* --- blocks are whole ----------------------------------------------------- */

/* The last column and the last row, repeated to the end of the blocks. */
static void extend(uint8_t *plane, size_t stride, size_t width, size_t height,
                   size_t rows)
{
    for (size_t i = 0; width < stride && i < height; i++) {
        uint8_t *row = plane + i * stride;
        memset(row + width, row[width - 1], stride - width);
    }
    for (size_t i = height; i < rows; i++) {
        memcpy(plane + i * stride, plane + (height - 1) * stride, stride);
    }
}

static void extend_all(const struct pel_planes *p, size_t height, size_t rows)
{
    size_t columns = (p->width + 1) / 2;
    extend(p->y, (size_t)p->y_stride, p->width, height, rows);
    extend(p->u, (size_t)p->u_stride, columns, (height + 1) / 2, rows / 2);
    extend(p->v, (size_t)p->v_stride, columns, (height + 1) / 2, rows / 2);
}

/* --- compression ---------------------------------------------------------- */

/* As EXIF and XMP have it: APP1, behind a name. */
static void write_block(struct jpeg_compress_struct *library, const char *name,
                        size_t name_size, const void *block, size_t size)
{
    const unsigned char *p = block;
    if (size == 0) {
        return;
    }
    jpeg_write_m_header(library, JPEG_APP0 + 1, (unsigned)(name_size + size));
    for (size_t i = 0; i < name_size; i++) {
        jpeg_write_m_byte(library, name[i]);
    }
    for (size_t i = 0; i < size; i++) {
        jpeg_write_m_byte(library, p[i]);
    }
}

static void write_photo(struct jpeg_compress_struct *library,
                        const struct pel_photo_blocks *photo)
{
    static const char exif[] = "Exif\0"; /* two zeros end it */
    static const char xmp[] = "http://ns.adobe.com/xap/1.0/";
    write_block(library, exif, sizeof exif, photo->exif, photo->exif_size);
    write_block(library, xmp, sizeof xmp, photo->xmp, photo->xmp_size);
}

static void set_up(struct compressor *compressor, uint32_t width,
                   uint32_t height, const struct pel_encode_input *in)
{
    int quality = in->quality;
    struct jpeg_compress_struct *library = &compressor->library;
    jpeg_mem_dest(library, &compressor->scratch, &compressor->scratch_size);
    library->image_width = width;
    library->image_height = height;
    library->input_components = 3;
    library->in_color_space = JCS_YCbCr;
    jpeg_set_defaults(library);
    jpeg_set_quality(library, quality, TRUE);
    library->raw_data_in = TRUE;
    /* As turbojpeg does: the exact transform where it can be seen. */
    library->dct_method = quality >= 96 ? JDCT_ISLOW : JDCT_FASTEST;
    library->comp_info[0].h_samp_factor = 2;
    library->comp_info[0].v_samp_factor = 2;
    jpeg_start_compress(library, TRUE);
    if (in->photo) {
        write_photo(library, in->photo);
    }
}

/* ROWS rows from row `first` of the planes on. */
static void write_rows(struct compressor *compressor,
                       const struct pel_planes *p, size_t first)
{
    JSAMPROW y[ROWS], u[ROWS / 2], v[ROWS / 2];
    JSAMPARRAY parts[] = { y, u, v };
    for (size_t i = 0; i < ROWS; i++) {
        y[i] = p->y + (first + i) * (size_t)p->y_stride;
    }
    for (size_t i = 0; i < ROWS / 2; i++) {
        u[i] = p->u + (first / 2 + i) * (size_t)p->u_stride;
        v[i] = p->v + (first / 2 + i) * (size_t)p->v_stride;
    }
    jpeg_write_raw_data(&compressor->library, parts, ROWS);
}

/* A strip of the picture is converted when its turn has come, so that its
 * planes never leave the processor's cache, and the pixels of the next one are
 * fetched while it is compressed. */
static enum pel_err write_strips(struct compressor *compressor,
                                 const uint8_t *rgba, uint32_t width,
                                 uint32_t height, struct pel_planes *strip)
{
    size_t stride = (size_t)width * 4;
    for (uint32_t first = 0; first < height; first += ROWS) {
        uint32_t left = height - first;
        strip->height = left < ROWS ? left : ROWS;
        enum pel_err err =
            pel_planes_fill(rgba + first * stride, (int)stride, width,
                            strip->height, true, NULL, strip);
        if (err != PEL_OK) {
            return err;
        }
        if (left > ROWS) {
            uint32_t next = left - ROWS < ROWS ? left - ROWS : ROWS;
            pel_planes_fetch(rgba + (first + ROWS) * stride, next * stride);
        }
        extend_all(strip, strip->height, ROWS);
        write_rows(compressor, strip, 0);
    }
    return PEL_OK;
}

/* Planes with whole blocks; the rows of the next ones are fetched. */
static void write_planes(struct compressor *compressor,
                         const struct pel_planes *p)
{
    for (size_t first = 0; first < p->height; first += ROWS) {
        size_t next = first + ROWS;
        if (next < p->height) {
            pel_planes_fetch(p->y + next * (size_t)p->y_stride,
                             ROWS * (size_t)p->y_stride);
            pel_planes_fetch(p->u + next / 2 * (size_t)p->u_stride,
                             ROWS / 2 * (size_t)p->u_stride);
            pel_planes_fetch(p->v + next / 2 * (size_t)p->v_stride,
                             ROWS / 2 * (size_t)p->v_stride);
        }
        write_rows(compressor, p, first);
    }
}

/* Nobody writes them, as libjpeg does not say. */
static struct pel_planes writable(const struct pel_planes_given *p)
{
    return (struct pel_planes){
        .y = (uint8_t *)(uintptr_t)p->y,
        .u = (uint8_t *)(uintptr_t)p->u,
        .v = (uint8_t *)(uintptr_t)p->v,
        .y_stride = p->y_stride,
        .u_stride = p->u_stride,
        .v_stride = p->v_stride,
        .width = p->width,
        .height = p->height,
    };
}

/* What was made, in memory of the caller's. */
static enum pel_err hand_out(const struct compressor *compressor, size_t size,
                             struct pel_bytes *out)
{
    out->data = malloc(size);
    if (!out->data) {
        return PEL_ERR_NO_MEMORY;
    }
    memcpy(out->data, compressor->scratch, size);
    out->size = size;
    return PEL_OK;
}

/* RGBA, or NULL: the planes are filled already. */
static enum pel_err compress(struct compressor *compressor, const uint8_t *rgba,
                             struct pel_planes *planes,
                             const struct pel_encode_input *in,
                             struct pel_bytes *out)
{
    uint32_t width = planes->width, height = planes->height;
    unsigned char *own = compressor->scratch;
    unsigned long own_size = compressor->scratch_size;
    enum pel_err err = PEL_OK;
    if (setjmp(compressor->failed) == 0) {
        set_up(compressor, width, height, in);
        if (rgba) {
            err = write_strips(compressor, rgba, width, height, planes);
        } else {
            write_planes(compressor, planes);
        }
        if (err == PEL_OK) {
            jpeg_finish_compress(&compressor->library);
            err = hand_out(compressor, compressor->scratch_size, out);
        }
    } else {
        err = PEL_ERR_INTERNAL;
    }
    jpeg_abort_compress(&compressor->library);
    /* The file has its size in the library's variables; the room stays. */
    compressor->scratch = own;
    compressor->scratch_size = own_size;
    return err;
}

/* --- a scan that is there ------------------------------------------------- */

/* Where the scan begins in a file that has one; 0: it has none. */
static size_t scan_at(const uint8_t *file, size_t size)
{
    size_t at = 2;
    while (at + 4 <= size && file[at] == 0xFF) {
        bool last = file[at + 1] == 0xDA;
        at += 2 + ((size_t)file[at + 2] << 8 | file[at + 3]);
        if (last) {
            return at <= size ? at : 0;
        }
    }
    return 0;
}

/* All that the library writes before the first strip's codes: of a grey one,
 * which takes microseconds. Bytes of it in *end, 0: it failed. */
static void write_head(struct compressor *compressor,
                       const struct pel_planes *strip,
                       const struct pel_encode_input *in, size_t *end)
{
    *end = 0;
    memset(strip->y, 128, (size_t)strip->y_stride * ROWS * 3 / 2);
    if (setjmp(compressor->failed) == 0) {
        set_up(compressor, strip->width, strip->height, in);
        write_rows(compressor, strip, 0);
        const struct jpeg_destination_mgr *to = compressor->library.dest;
        *end = scan_at(compressor->scratch,
                       (size_t)(to->next_output_byte - compressor->scratch));
    }
    jpeg_abort_compress(&compressor->library);
}

static enum pel_err take_scan(struct compressor *compressor,
                              const struct pel_planes *strip,
                              const struct pel_encode_input *in,
                              struct pel_bytes *out)
{
    size_t room = compressor->scratch_size, end;
    unsigned char *own = compressor->scratch;
    write_head(compressor, strip, in, &end);
    compressor->scratch = own;
    compressor->scratch_size = room;
    size_t need =
        end + pel_jpeg_scan_most(in->scan, strip->width, strip->height) + 2;
    if (need > room) {
        unsigned char *more = realloc(compressor->scratch, need);
        if (!more) {
            return PEL_ERR_NO_MEMORY;
        }
        compressor->scratch = more;
        compressor->scratch_size = need;
    }
    uint8_t *to =
        end == 0 ? NULL
                 : pel_jpeg_scan_write(in->scan, strip->width, strip->height,
                                       compressor->scratch + end);
    if (!to) {
        return PEL_ERR_INTERNAL;
    }
    *to++ = 0xFF; /* the end of the image */
    *to++ = 0xD9;
    return hand_out(compressor, (size_t)(to - compressor->scratch), out);
}

enum pel_err pel_jpeg_encode(const struct pel_encode_input *in,
                             struct pel_bytes *out)
{
    struct pel_planes planes;
    uint32_t width = in->out_width ? in->out_width : in->width;
    uint32_t height = in->out_height ? in->out_height : in->height;
    *out = (struct pel_bytes){ 0 };
    bool as_it_is = in->width == width && in->height == height;
    if ((!in->rgba && !in->scan && (!in->planes || !in->planes->v)) ||
        (in->scan && (!as_it_is || in->scan->quality != in->quality ||
                      in->quality > PEL_JPEG_BEST)) ||
        in->width - 1 >= PEL_ENCODE_MAX_SIZE ||
        in->height - 1 >= PEL_ENCODE_MAX_SIZE ||
        width - 1 >= PEL_ENCODE_MAX_SIZE || height - 1 >= PEL_ENCODE_MAX_SIZE ||
        in->quality < 1 || in->quality > 100) {
        return PEL_ERR_INVALID;
    }
    struct compressor *compressor = compressor_get();
    if (!compressor) {
        return PEL_ERR_NO_MEMORY;
    }
    uint32_t rows = as_it_is ? ROWS : (height + ROWS - 1) / ROWS * ROWS;
    enum pel_err err = reserve(compressor, width, height, rows, &planes);
    if (err == PEL_OK && in->scan) {
        return take_scan(compressor, &planes, in, out);
    }
    if (err == PEL_OK && !as_it_is) {
        err = in->rgba ? pel_planes_fill(in->rgba, (int)in->width * 4,
                                         in->width, in->height, true,
                                         &compressor->between, &planes)
                       : pel_planes_take(in->planes, true, &compressor->between,
                                         &planes);
        if (err == PEL_OK) {
            extend_all(&planes, height, rows);
        }
    } else if (!in->rgba) {
        planes = writable(in->planes);
    }
    return err == PEL_OK ? compress(compressor, as_it_is ? in->rgba : NULL,
                                    &planes, in, out)
                         : err;
}
