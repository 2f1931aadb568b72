/* What the device codes of planes that are given to it against what
 * libjpeg-turbo codes of the same: the same bytes. */
#include "render/render_testkit.h"

#include "encode/encode.h"
#include "render/jpegcoder.h"
#include "render/rendererstate.h"
#include "render/ycbcr.h"

#define LARGEST (512 * 64)

static uint8_t samples[LARGEST * 3 / 2];

static uint64_t seed;

static uint32_t next(void)
{
    return (uint32_t)(test_random_bits(&seed) >> 32);
}

/* Samples of each kind: the hardest that blocks can be, and the easiest. */
enum kind {
    NOISE,
    EXTREMES, /* of noise */
    CHECKERS,
    STRIPES,
    STEPS,    /* of blocks */
    QUARTERS, /* turned over: 16 bits do not hold them before they are scaled */
    SLOPE,
    FEW, /* dots */
    GREY,
    KINDS,
};

static uint8_t sample(enum kind kind, size_t at, size_t stride)
{
    size_t x = at % stride, y = at / stride;
    switch (kind) {
    case NOISE:
        return (uint8_t)next();
    case EXTREMES:
        return next() & 1 ? 255 : 0;
    case CHECKERS:
        return (x + y) & 1 ? 255 : 0;
    case STRIPES:
        return x & 1 ? 0 : 255;
    case STEPS:
        return (x / 8 + y / 8) & 1 ? 255 : 0;
    case QUARTERS:
        return (x % 8 < 4) ^ ((y + 2) % 8 < 4) ? 255 : 0;
    case SLOPE:
        return (uint8_t)(3 * x + y);
    case FEW:
        return next() % 61 == 0 ? 255 : 100;
    default:
        return 128;
    }
}

static struct pel_planes_given fill(enum kind kind, uint32_t width,
                                    uint32_t height)
{
    const struct pel_ycbcr_layout l =
        pel_ycbcr_layout(PEL_YCBCR_JPEG, width, height);
    assert_true(l.size <= sizeof samples);
    for (size_t i = 0; i < l.size; i++) {
        samples[i] = sample(kind, i, l.stride[i >= l.offset[1]]);
    }
    return (struct pel_planes_given){ .y = samples,
                                      .u = samples + l.offset[1],
                                      .v = samples + l.offset[2],
                                      .y_stride = (int)l.stride[0],
                                      .u_stride = (int)l.stride[1],
                                      .v_stride = (int)l.stride[2],
                                      .width = width,
                                      .height = height };
}

static struct pel_picture *code(uint32_t width, uint32_t height, int quality,
                                size_t bytes)
{
    struct pel_jpeg_coder *c = &renderer->ycbcr.coder;
    struct pel_fault fault = { 0 };
    const struct pel_readback_source source = { .width = width,
                                                .height = height,
                                                .rows = height,
                                                .ycbcr = PEL_YCBCR_CODED,
                                                .quality = quality,
                                                .layers = PEL_LAYER_COLOR };
    if (pel_jpeg_coder_need(c, renderer->shader_dir, &fault) != PEL_OK) {
        fail_msg("%s", fault.message);
    }
    struct pel_readback_slot *slot =
        pel_readback_reserve(&renderer->readback, &source);
    assert_non_null(slot);
    /* Not at the beginning, as one of several. */
    GLuint planes = 0;
    pel_jpeg_coder_fit(c, 256 + sizeof samples);
    glCreateBuffers(1, &planes);
    glNamedBufferStorage(planes, (GLsizeiptr)bytes, samples, 0);
    glCopyNamedBufferSubData(planes, c->planes, 0, 256, (GLsizeiptr)bytes);
    glDeleteBuffers(1, &planes);
    const struct pel_jpeg_work work = { .width = width,
                                        .height = height,
                                        .quality = quality,
                                        .at = 256,
                                        .slot = slot };
    pel_jpeg_coder_run(c, &work, 1);
    glMemoryBarrier(GL_CLIENT_MAPPED_BUFFER_BARRIER_BIT);
    pel_readback_send(&renderer->readback, &slot, 1);
    struct pel_picture *p = pel_readback_pop(&renderer->readback, 60000000000);
    assert_non_null(p);
    return p;
}

static void assert_same(enum kind kind, uint32_t width, uint32_t height,
                        int quality, size_t *most)
{
    const struct pel_planes_given planes = fill(kind, width, height);
    const size_t bytes = pel_ycbcr_layout(PEL_YCBCR_JPEG, width, height).size;
    struct pel_picture *p = code(width, height, quality, bytes);
    struct pel_encode_input in = {
        .width = width, .height = height, .planes = &planes, .quality = quality
    };
    struct pel_bytes want, got;
    assert_int_equal(pel_jpeg_encode(&in, &want), PEL_OK);
    in.planes = NULL;
    in.scan = &p->scan;
    assert_int_equal(pel_jpeg_encode(&in, &got), PEL_OK);
    size_t same = 0;
    while (same < got.size && same < want.size &&
           got.data[same] == want.data[same]) {
        same++;
    }
    if (same != got.size || same != want.size) {
        fail_msg("kind %d, %ux%u, quality %d: %zu of %zu bytes, %zu wanted",
                 kind, width, height, quality, same, got.size, want.size);
    }
    for (size_t i = 0; i < pel_jpeg_groups(width, height); i++) {
        size_t bits = p->scan.words[i * PEL_JPEG_GROUP_WORDS];
        *most = bits > *most ? bits : *most;
    }
    pel_bytes_finish(&want);
    pel_bytes_finish(&got);
    pel_picture_release(p);
}

/* Every kind in every quality, and sizes that end within units, blocks and
 * groups: of one unit, of ten and eleven, and rows of them. */
static void same_bytes(void **state)
{
    (void)state;
    static const uint32_t sizes[][2] = { { 1, 1 },    { 16, 16 },  { 8, 8 },
                                         { 9, 8 },    { 7, 17 },   { 17, 7 },
                                         { 160, 16 }, { 176, 16 }, { 161, 1 },
                                         { 72, 24 },  { 136, 40 }, { 512, 64 },
                                         { 33, 300 }, { 500, 57 } };
    size_t most = 0;
    seed = 7;
    for (enum kind kind = 0; kind < KINDS; kind++) {
        for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
            static const int qualities[] = { 1, 10, 50, 75, 80, 90, 95 };
            for (size_t k = 0; k < sizeof qualities / sizeof *qualities; k++) {
                assert_same(kind, sizes[i][0], sizes[i][1], qualities[k],
                            &most);
            }
        }
        for (int quality = 1; quality <= PEL_JPEG_BEST; quality++) {
            assert_same(kind, 40, 24, quality, &most);
        }
    }
    printf("%.0f bits a block at most, of %d\n",
           (double)most / (PEL_JPEG_UNITS * PEL_JPEG_BLOCKS),
           32 * PEL_JPEG_MOST_WORDS / (PEL_JPEG_UNITS * PEL_JPEG_BLOCKS));
}

/* A device that fails leaves anything: it is told, not followed. */
static void nonsense_is_refused(void **state)
{
    (void)state;
    static uint32_t words[PEL_JPEG_GROUP_WORDS];
    const struct pel_jpeg_scan scan = { .words = words, .quality = 80 };
    struct pel_encode_input in = {
        .width = 16, .height = 16, .scan = &scan, .quality = 80
    };
    struct pel_bytes out;
    words[0] = 32 * PEL_JPEG_MOST_WORDS + 1;
    assert_int_equal(pel_jpeg_encode(&in, &out), PEL_ERR_INTERNAL);
    words[0] = UINT32_MAX;
    assert_int_equal(pel_jpeg_encode(&in, &out), PEL_ERR_INTERNAL);
    words[0] = 32;
    in.quality = 81;
    assert_int_equal(pel_jpeg_encode(&in, &out), PEL_ERR_INVALID);
    in.quality = 80;
    in.out_width = in.out_height = 8;
    assert_int_equal(pel_jpeg_encode(&in, &out), PEL_ERR_INVALID);
}

static int set_up(void **state)
{
    (void)state;
    renderer = test_renderer("compute");
    return 0;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(same_bytes),
        cmocka_unit_test(nonsense_is_refused),
    };
    return cmocka_run_group_tests(tests, set_up, end_renderer);
}
