/* Encoders against readers of their files. With PEL_SAMPLES=DIR the pictures
 * are also left there for readers that are not ours (tests/encode_readers.sh).
 */
#include "encode/encode.h"

#include <math.h>
#include <openexr.h>
#include <setjmp.h>
#include <spng.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <turbojpeg.h>

#include "encode/planes.h"

#include <cmocka.h>

enum { WIDTH = 131, HEIGHT = 77 };

static uint8_t *make_rgba(uint32_t width, uint32_t height)
{
    uint8_t *rgba = malloc((size_t)width * height * 4);
    assert_non_null(rgba);
    for (uint32_t y = 0; y < height; y++) {
        for (uint32_t x = 0; x < width; x++) {
            uint8_t *p = rgba + ((size_t)y * width + x) * 4;
            p[0] = (uint8_t)(128 + 100 * sin(x * 0.05));
            p[1] = (uint8_t)(128 + 100 * cos(y * 0.04));
            p[2] = (uint8_t)(x + y);
            p[3] = 255;
        }
    }
    return rgba;
}

static void keep_sample(const char *name, const struct pel_bytes *bytes)
{
    const char *folder = getenv("PEL_SAMPLES");
    char path[512];
    if (!folder) {
        return;
    }
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(bytes->data, 1, bytes->size, file), bytes->size);
    assert_int_equal(fclose(file), 0);
}

static double mean_difference(const uint8_t *a, const uint8_t *b, size_t pixels)
{
    double sum = 0;
    for (size_t i = 0; i < pixels; i++) {
        for (int c = 0; c < 3; c++) {
            sum += abs(a[4 * i + (size_t)c] - b[4 * i + (size_t)c]);
        }
    }
    return sum / (3.0 * (double)pixels);
}

static enum pel_err jpeg(const uint8_t *rgba, uint32_t width, uint32_t height,
                         int quality, struct pel_bytes *out)
{
    const struct pel_encode_input in = {
        .rgba = rgba, .width = width, .height = height, .quality = quality
    };
    return pel_jpeg_encode(&in, out);
}

static enum pel_err png(const uint8_t *rgba, uint32_t width, uint32_t height,
                        struct pel_bytes *out)
{
    const struct pel_encode_input in = { .rgba = rgba,
                                         .width = width,
                                         .height = height };
    return pel_png_encode(&in, out);
}

static void jpeg_decodes_to_the_picture(void **state)
{
    (void)state;
    static const uint32_t sizes[][2] = {
        { WIDTH, HEIGHT }, { 1, 1 }, { 16, 3 }, { 640, 360 }
    };
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        uint32_t width = sizes[i][0], height = sizes[i][1];
        uint8_t *rgba = make_rgba(width, height);
        uint8_t *back = malloc((size_t)width * height * 4);
        struct pel_bytes bytes, again;
        assert_int_equal(jpeg(rgba, width, height, 95, &bytes), PEL_OK);
        assert_int_equal(jpeg(rgba, width, height, 95, &again), PEL_OK);
        assert_int_equal(bytes.size, again.size);
        assert_memory_equal(bytes.data, again.data, bytes.size);
        tjhandle reader = tjInitDecompress();
        int w, h, sampling, space;
        assert_int_equal(tjDecompressHeader3(reader, bytes.data, bytes.size, &w,
                                             &h, &sampling, &space),
                         0);
        assert_int_equal(w, width);
        assert_int_equal(h, height);
        assert_int_equal(sampling, TJSAMP_420);
        assert_int_equal(tjDecompress2(reader, bytes.data, bytes.size, back, w,
                                       0, h, TJPF_RGBA, 0),
                         0);
        tjDestroy(reader);
        /* Quality 95 quantises luma by 1..10 levels and halves the chroma:
         * a smooth picture comes back within 4 levels on average (blue has a
         * step at 256); a swapped channel or line is off by tens. */
        assert_true(mean_difference(rgba, back, (size_t)width * height) < 4.0);
        if (i == 0) {
            keep_sample("odd.jpg", &bytes);
        }
        pel_bytes_finish(&bytes);
        pel_bytes_finish(&again);
        assert_null(bytes.data);
        free(rgba);
        free(back);
    }
}

/* Strips, one after another, are what turbojpeg makes of whole planes. */
static void jpeg_is_turbojpegs(void **state)
{
    (void)state;
    static const uint32_t sizes[][2] = { { 64, 48 }, { 2, 2 },   { 18, 34 },
                                         { 32, 8 },  { 34, 18 }, { 640, 362 } };
    for (size_t i = 0; i < 2 * (sizeof sizes / sizeof *sizes); i++) {
        uint32_t width = sizes[i / 2][0], height = sizes[i / 2][1];
        int quality = i % 2 ? 96 : 80;
        size_t columns = (width + 1) / 2, luma = (size_t)width * height;
        size_t chroma = columns * ((height + 1) / 2);
        uint8_t *rgba = make_rgba(width, height);
        uint8_t *yuv = malloc(luma + 2 * chroma);
        const struct pel_planes planes = { .y = yuv,
                                           .u = yuv + luma,
                                           .v = yuv + luma + chroma,
                                           .y_stride = (int)width,
                                           .u_stride = (int)columns,
                                           .v_stride = (int)columns,
                                           .width = width,
                                           .height = height };
        assert_int_equal(pel_planes_fill(rgba, (int)width * 4, width, height,
                                         true, NULL, &planes),
                         PEL_OK);
        const unsigned char *parts[] = { planes.y, planes.u, planes.v };
        const int strides[] = { (int)width, (int)columns, (int)columns };
        unsigned char *want = NULL;
        unsigned long want_size = 0;
        tjhandle writer = tjInitCompress();
        assert_int_equal(tjCompressFromYUVPlanes(
                             writer, parts, (int)width, strides, (int)height,
                             TJSAMP_420, &want, &want_size, quality, 0),
                         0);
        struct pel_bytes bytes;
        assert_int_equal(jpeg(rgba, width, height, quality, &bytes), PEL_OK);
        assert_int_equal(bytes.size, want_size);
        assert_memory_equal(bytes.data, want, want_size);
        pel_bytes_finish(&bytes);
        tjFree(want);
        tjDestroy(writer);
        free(yuv);
        free(rgba);
    }
}

static void png_decodes_to_the_same_pixels(void **state)
{
    (void)state;
    static const uint32_t sizes[][2] = { { WIDTH, HEIGHT },
                                         { 1, 1 },
                                         { 3, 9 } };
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        uint32_t width = sizes[i][0], height = sizes[i][1];
        size_t size = (size_t)width * height * 4;
        uint8_t *rgba = make_rgba(width, height);
        uint8_t *back = malloc(size);
        struct pel_bytes bytes;
        assert_int_equal(png(rgba, width, height, &bytes), PEL_OK);
        spng_ctx *reader = spng_ctx_new(0);
        assert_int_equal(spng_set_png_buffer(reader, bytes.data, bytes.size),
                         0);
        struct spng_ihdr header;
        assert_int_equal(spng_get_ihdr(reader, &header), 0);
        assert_int_equal(header.width, width);
        assert_int_equal(header.height, height);
        assert_int_equal(header.color_type, SPNG_COLOR_TYPE_TRUECOLOR);
        uint8_t intent = 9;
        assert_int_equal(spng_get_srgb(reader, &intent), 0);
        assert_int_equal(intent, 0);
        assert_int_equal(
            spng_decode_image(reader, back, size, SPNG_FMT_RGBA8, 0), 0);
        spng_ctx_free(reader);
        assert_memory_equal(rgba, back, size);
        if (i == 0) {
            keep_sample("odd.png", &bytes);
        }
        pel_bytes_finish(&bytes);
        free(rgba);
        free(back);
    }
}

/* --- EXR ----------------------------------------------------------------- */

static int64_t read_bytes(exr_const_context_t context, void *user, void *buffer,
                          uint64_t size, uint64_t offset,
                          exr_stream_error_func_ptr_t error)
{
    const struct pel_bytes *bytes = user;
    (void)context;
    (void)error;
    if (offset > bytes->size) {
        return -1;
    }
    uint64_t left = bytes->size - offset;
    uint64_t count = size < left ? size : left;
    memcpy(buffer, bytes->data + offset, count);
    return (int64_t)count;
}

static int64_t size_of_bytes(exr_const_context_t context, void *user)
{
    const struct pel_bytes *bytes = user;
    (void)context;
    return (int64_t)bytes->size;
}

static exr_context_t open_exr(struct pel_bytes *bytes)
{
    exr_context_initializer_t init = EXR_DEFAULT_CONTEXT_INITIALIZER;
    exr_context_t context;
    init.user_data = bytes;
    init.read_fn = read_bytes;
    init.size_fn = size_of_bytes;
    assert_int_equal(exr_start_read(&context, "memory", &init), 0);
    return context;
}

/* Reads one channel as the file has it: raw 16 or 32 bits a sample. */
static exr_pixel_type_t read_channel(exr_context_t context, const char *name,
                                     int width, int height, uint32_t *out)
{
    int32_t lines;
    exr_decode_pipeline_t pipe = EXR_DECODE_PIPELINE_INITIALIZER;
    exr_pixel_type_t type = EXR_PIXEL_LAST_TYPE;
    assert_int_equal(exr_get_scanlines_per_chunk(context, 0, &lines), 0);
    uint8_t *raw = calloc((size_t)width * (size_t)height, 4);
    for (int y = 0; y < height; y += lines) {
        exr_chunk_info_t chunk;
        assert_int_equal(exr_read_scanline_chunk_info(context, 0, y, &chunk),
                         0);
        if (y == 0) {
            assert_int_equal(exr_decoding_initialize(context, 0, &chunk, &pipe),
                             0);
        } else {
            assert_int_equal(exr_decoding_update(context, 0, &chunk, &pipe), 0);
        }
        for (int i = 0; i < pipe.channel_count; i++) {
            exr_coding_channel_info_t *c = &pipe.channels[i];
            c->decode_to_ptr = NULL;
            if (strcmp(c->channel_name, name) == 0) {
                type = (exr_pixel_type_t)c->data_type;
                c->user_bytes_per_element =
                    c->data_type == EXR_PIXEL_HALF ? 2 : 4;
                c->user_data_type = c->data_type;
                c->user_pixel_stride = 4;
                c->user_line_stride = 4 * width;
                c->decode_to_ptr = raw + (size_t)y * (size_t)width * 4;
            }
        }
        if (y == 0) {
            assert_int_equal(
                exr_decoding_choose_default_routines(context, 0, &pipe), 0);
        }
        assert_int_equal(exr_decoding_run(context, 0, &pipe), 0);
    }
    exr_decoding_destroy(context, &pipe);
    for (int i = 0; i < width * height; i++) {
        uint16_t half;
        memcpy(&half, raw + 4 * i, 2);
        memcpy(&out[i], raw + 4 * i, 4);
        out[i] = type == EXR_PIXEL_HALF ? half : out[i];
    }
    free(raw);
    return type;
}

/* Value of a half by its definition (IEEE 754). */
static double half_value(uint32_t half)
{
    int exponent = (int)(half >> 10 & 31);
    double fraction = half & 1023;
    double sign = half & 0x8000 ? -1 : 1;
    if (exponent == 31) {
        return fraction > 0 ? NAN : sign * INFINITY;
    }
    return exponent == 0 ? sign * ldexp(fraction, -24)
                         : sign * ldexp(1024 + fraction, exponent - 25);
}

static uint32_t float_bits(float f)
{
    uint32_t bits;
    memcpy(&bits, &f, sizeof bits);
    return bits;
}

static float radiance[WIDTH * HEIGHT * 4];
static float depth[WIDTH * HEIGHT];

/* Every exponent a half has, infinities, NaN, and what does not fit. */
static void fill_samples(void)
{
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        float *p = radiance + (size_t)i * 4;
        p[0] = ldexpf(1.0f + (float)(i % 97) / 97.0f, i % 46 - 28);
        p[1] = -p[0];
        p[2] = (float)i / 3.0f;
        p[3] = 1.0f;
        depth[i] = 0.1f * (float)i;
    }
    radiance[0] = INFINITY;
    radiance[4] = NAN;
    radiance[8] = 1e9f;
    radiance[12] = 65519.0f; /* the last that rounds to 65504 */
    radiance[16] = 65520.0f; /* half way to what is not there: infinity */
    radiance[20] = 1.0f + 1.0f / 2048.0f; /* tie: to even, down */
    radiance[24] = 1.0f + 3.0f / 2048.0f; /* tie: to even, up */
    depth[0] = INFINITY;
    depth[1] = NAN;
}

static const struct pel_exr_layer layers[] = {
    { .channels = "RGB", .pixels = radiance, .stride = 4 },
    { .name = "depth",
      .channels = "Z",
      .pixels = depth,
      .stride = 1,
      .full_float = true },
};

static const float matrix[16] = { 1, 2,  3,  4,  5,  6,  7,  8,
                                  9, 10, 11, 12, 13, 14, 15, 16 };

static const struct pel_exr_attribute attributes[] = {
    { .name = "pelagos.view", .type = PEL_EXR_STRING, .string = "bridge" },
    { .name = "pelagos.time", .type = PEL_EXR_DOUBLE, .number = 12.25 },
    { .name = "pelagos.seed", .type = PEL_EXR_INT, .number = 7 },
    { .name = "longitude", .type = PEL_EXR_FLOAT, .number = 5.25 },
    { .name = "worldToCamera", .type = PEL_EXR_MATRIX, .matrix = matrix },
};

static struct pel_encode_input make_image(bool float_samples)
{
    return (struct pel_encode_input){
        .width = WIDTH,
        .height = HEIGHT,
        .float_samples = float_samples,
        .layers = layers,
        .layer_count = 2,
        .attributes = attributes,
        .attribute_count = 5,
        .window_center = { 0.25f, -0.5f },
        .window_width = 1.5f,
    };
}

static void exr_halves_are_the_nearest(void **state)
{
    (void)state;
    fill_samples();
    struct pel_encode_input image = make_image(false);
    struct pel_bytes bytes;
    assert_int_equal(pel_exr_encode(&image, &bytes), PEL_OK);
    keep_sample("half.exr", &bytes);
    exr_context_t context = open_exr(&bytes);
    static uint32_t red[WIDTH * HEIGHT], z[WIDTH * HEIGHT];
    assert_int_equal(read_channel(context, "R", WIDTH, HEIGHT, red),
                     EXR_PIXEL_HALF);
    assert_int_equal(read_channel(context, "depth.Z", WIDTH, HEIGHT, z),
                     EXR_PIXEL_FLOAT);
    assert_int_equal(red[0], 0x7c00);
    assert_true(isnan(half_value(red[1])));
    assert_int_equal(red[2], 0x7c00);
    assert_int_equal(red[3], 0x7bff);
    assert_int_equal(red[4], 0x7c00);
    assert_int_equal(red[5], 0x3c00);
    assert_int_equal(red[6], 0x3c02);
    for (int i = 7; i < WIDTH * HEIGHT; i++) {
        /* No other half is nearer than the one that was written. */
        double want = (double)radiance[4 * i];
        if (red[i] == 0x7c00) {
            assert_true(want >= 65520);
            continue;
        }
        double off = fabs(half_value(red[i]) - want);
        assert_true(off <= fabs(half_value(red[i] + 1) - want));
        if (red[i] > 0) {
            assert_true(off <= fabs(half_value(red[i] - 1) - want));
        }
    }
    assert_int_equal(z[0], 0x7f800000);
    assert_true((z[1] & 0x7fffffff) > 0x7f800000);
    for (int i = 2; i < WIDTH * HEIGHT; i++) {
        assert_int_equal(z[i], float_bits(depth[i]));
    }
    assert_int_equal(exr_finish(&context), 0);
    pel_bytes_finish(&bytes);
}

static void exr_floats_are_the_same_bits(void **state)
{
    (void)state;
    fill_samples();
    struct pel_encode_input image = make_image(true);
    struct pel_bytes bytes;
    assert_int_equal(pel_exr_encode(&image, &bytes), PEL_OK);
    keep_sample("float.exr", &bytes);
    exr_context_t context = open_exr(&bytes);
    static uint32_t samples[WIDTH * HEIGHT];
    for (int c = 0; c < 3; c++) {
        const char name[] = { "RGB"[c], 0 };
        assert_int_equal(read_channel(context, name, WIDTH, HEIGHT, samples),
                         EXR_PIXEL_FLOAT);
        for (int i = 0; i < WIDTH * HEIGHT; i++) {
            assert_int_equal(samples[i], float_bits(radiance[4 * i + c]));
        }
    }
    assert_int_equal(exr_finish(&context), 0);
    pel_bytes_finish(&bytes);
}

/* Noise of which ever more is zero: at 69 bytes its compressed size is that
 * of the noise itself, which no reader can tell from stored noise. */
static void exr_noise_is_the_same_bits(void **state)
{
    (void)state;
    enum { SIDE = 16, COUNT = SIDE * SIDE };
    static float noise[COUNT];
    static uint32_t samples[COUNT];
    const struct pel_exr_layer layer = { .name = "Z",
                                         .channels = "Z",
                                         .pixels = noise,
                                         .stride = 1,
                                         .full_float = true };
    const struct pel_encode_input image = {
        .width = SIDE, .height = SIDE, .layers = &layer, .layer_count = 1
    };
    for (int zeros = 0; zeros < 120; zeros++) {
        uint32_t random = 1;
        for (int i = 0; i < COUNT; i++) {
            random = random * 1664525u + 1013904223u;
            uint32_t bits = (random >> 3) ^ random << 13;
            bits &= 0xbfffffff; /* finite */
            memcpy(&noise[i], &bits, sizeof bits);
        }
        memset(noise, 0, (size_t)zeros);
        struct pel_bytes bytes;
        assert_int_equal(pel_exr_encode(&image, &bytes), PEL_OK);
        exr_context_t context = open_exr(&bytes);
        assert_int_equal(read_channel(context, "Z.Z", SIDE, SIDE, samples),
                         EXR_PIXEL_FLOAT);
        for (int i = 0; i < COUNT; i++) {
            assert_int_equal(samples[i], float_bits(noise[i]));
        }
        assert_int_equal(exr_finish(&context), 0);
        pel_bytes_finish(&bytes);
    }
}

static void exr_header_says_what_it_was_told(void **state)
{
    (void)state;
    fill_samples();
    struct pel_encode_input image = make_image(false);
    struct pel_bytes bytes, again;
    assert_int_equal(pel_exr_encode(&image, &bytes), PEL_OK);
    assert_int_equal(pel_exr_encode(&image, &again), PEL_OK);
    assert_int_equal(bytes.size, again.size);
    assert_memory_equal(bytes.data, again.data, bytes.size);
    exr_context_t context = open_exr(&bytes);
    int32_t length, seed;
    const char *text;
    double time;
    float longitude, width;
    exr_attr_m44f_t m;
    exr_attr_v2f_t center;
    assert_int_equal(
        exr_attr_get_string(context, 0, "pelagos.view", &length, &text), 0);
    assert_string_equal(text, "bridge");
    assert_int_equal(exr_attr_get_double(context, 0, "pelagos.time", &time), 0);
    assert_true(time == 12.25);
    assert_int_equal(exr_attr_get_int(context, 0, "pelagos.seed", &seed), 0);
    assert_int_equal(seed, 7);
    assert_int_equal(exr_attr_get_float(context, 0, "longitude", &longitude),
                     0);
    assert_true(longitude == 5.25f);
    assert_int_equal(exr_attr_get_m44f(context, 0, "worldToCamera", &m), 0);
    assert_memory_equal(m.m, matrix, sizeof matrix);
    assert_int_equal(exr_get_screen_window_center(context, 0, &center), 0);
    assert_true(center.x == 0.25f && center.y == -0.5f);
    assert_int_equal(exr_get_screen_window_width(context, 0, &width), 0);
    assert_true(width == 1.5f);
    assert_int_equal(exr_finish(&context), 0);
    pel_bytes_finish(&bytes);
    pel_bytes_finish(&again);
}

/* What is told goes into the file, and the pixels are those without. */
static void photos_say_where_they_were_taken(void **state)
{
    (void)state;
    struct pel_photo photo = {
        .software = "pelagosd test",
        .view = "bridge <&\">",
        .unix_s = 1591588800.25, /* 2020-06-08T04:00:00.25Z */
        .time_s = 12.25,
        .latitude_deg = -33.5125,
        .longitude_deg = 151.2500125,
        .altitude_m = 18.5,
        .heading_deg = 270.125,
        .pitch_deg = -3.5,
        .roll_deg = 1.25,
        .horizontal_fov_deg = 60,
        .vertical_fov_deg = 36,
        .exposure_ev = 14.5,
        .width = 131,
        .height = 77,
    };
    struct pel_photo_blocks blocks;
    pel_photo_write(&photo, &blocks);
    assert_true(blocks.exif_size > 100 && blocks.xmp_size > 500);
    uint8_t *rgba = make_rgba(131, 77);
    const struct pel_encode_input plain = {
        .rgba = rgba, .width = 131, .height = 77, .quality = 90
    };
    struct pel_encode_input with = plain;
    with.photo = &blocks;
    pel_encode *const both[] = { pel_jpeg_encode, pel_png_encode };
    for (int i = 0; i < 2; i++) {
        struct pel_bytes bare, told;
        assert_int_equal(both[i](&plain, &bare), PEL_OK);
        assert_int_equal(both[i](&with, &told), PEL_OK);
        size_t more = told.size - bare.size;
        assert_true(more > blocks.exif_size + blocks.xmp_size);
        assert_true(more < blocks.exif_size + blocks.xmp_size + 120);
        /* What follows the blocks is what was there before. */
        assert_memory_equal(told.data + told.size - 600,
                            bare.data + bare.size - 600, 600);
        keep_sample(i ? "photo.png" : "photo.jpg", &told);
        pel_bytes_finish(&bare);
        pel_bytes_finish(&told);
    }
    free(rgba);
    /* Whatever is told, the blocks end within their bounds. */
    photo.unix_s = NAN;
    photo.latitude_deg = photo.longitude_deg = INFINITY;
    photo.altitude_m = photo.heading_deg = NAN;
    photo.horizontal_fov_deg = 0;
    pel_photo_write(&photo, &blocks);
    assert_true(blocks.exif_size > 8 && blocks.exif_size < 400);
}

static void bad_input_is_refused(void **state)
{
    (void)state;
    uint8_t pixel[4] = { 0 };
    float sample[4] = { 0 };
    struct pel_bytes bytes;
    assert_int_equal(jpeg(pixel, 0, 1, 90, &bytes), PEL_ERR_INVALID);
    assert_int_equal(jpeg(pixel, 1, 16385, 90, &bytes), PEL_ERR_INVALID);
    assert_int_equal(jpeg(pixel, 1, 1, 0, &bytes), PEL_ERR_INVALID);
    assert_int_equal(jpeg(pixel, 1, 1, 101, &bytes), PEL_ERR_INVALID);
    assert_int_equal(jpeg(NULL, 1, 1, 90, &bytes), PEL_ERR_INVALID);
    assert_int_equal(png(pixel, 1, 0, &bytes), PEL_ERR_INVALID);
    const atomic_bool over = true;
    const struct pel_encode_input given_up = {
        .rgba = pixel, .width = 1, .height = 1, .cancel = &over
    };
    assert_int_equal(pel_png_encode(&given_up, &bytes), PEL_ERR_CONFLICT);
    assert_null(bytes.data);
    assert_int_equal(png(pixel, 16385, 1, &bytes), PEL_ERR_INVALID);
    assert_null(bytes.data);

    struct pel_exr_layer twice[2] = {
        { .channels = "RGB", .pixels = sample, .stride = 4 },
        { .channels = "GZ", .pixels = sample, .stride = 4 },
    };
    struct pel_encode_input image = { .width = 1,
                                      .height = 1,
                                      .layers = twice };
    assert_int_equal(pel_exr_encode(&image, &bytes), PEL_ERR_INVALID);
    image.layer_count = 2;
    assert_int_equal(pel_exr_encode(&image, &bytes), PEL_ERR_INVALID);
    image.layer_count = 1;
    twice[0].stride = 2;
    assert_int_equal(pel_exr_encode(&image, &bytes), PEL_ERR_INVALID);
    twice[0].stride = 4;
    image.width = 20000;
    assert_int_equal(pel_exr_encode(&image, &bytes), PEL_ERR_INVALID);
    image.width = 1;
    atomic_bool cancel = true;
    image.cancel = &cancel;
    assert_int_equal(pel_exr_encode(&image, &bytes), PEL_ERR_CONFLICT);
    assert_null(bytes.data);
    image.cancel = NULL;
    assert_int_equal(pel_exr_encode(&image, &bytes), PEL_OK);
    pel_bytes_finish(&bytes);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(jpeg_decodes_to_the_picture),
        cmocka_unit_test(jpeg_is_turbojpegs),
        cmocka_unit_test(png_decodes_to_the_same_pixels),
        cmocka_unit_test(exr_halves_are_the_nearest),
        cmocka_unit_test(exr_floats_are_the_same_bits),
        cmocka_unit_test(exr_noise_is_the_same_bits),
        cmocka_unit_test(exr_header_says_what_it_was_told),
        cmocka_unit_test(photos_say_where_they_were_taken),
        cmocka_unit_test(bad_input_is_refused),
    };
    return cmocka_run_group_tests_name("encode", tests, NULL, NULL);
}
