/* Planes of luma and chroma that the device makes against those that libyuv
 * makes of the same pictures' pixels, and files against files, of pixels, of
 * planes and of what the device coded: the same bytes. */
#define TEST_ANTIALIASING true
#include "render/render_testkit.h"

#include "encode/encode.h"
#include "frames/pictureplanes.h"

#define MOST 9
#define LARGEST (144 * 96)
#define TURNS 4

static struct pel_sea sea;

/* Sides of whole blocks, odd ones and ones that end within a word; pixels of a
 * few, which are all edge. */
static const struct test_look looks[MOST] = {
    { 7, 20, -4, 0, 60, 96, 64 },    { 7, 80, -9, 11, 40, 71, 33 },
    { 7, 140, 2, -5, 90, 33, 70 },   { 7, 200, -30, 0, 60, 64, 64 },
    { 7, 260, 10, 0, 30, 41, 21 },   { 7, 320, -1, 0, 20, 129, 41 },
    { 7, 350, -80, 30, 70, 17, 18 }, { 7, 20, -4, 0, 60, 144, 95 },
    { 7, 33, -4, 90, 60, 1, 3 },
};

struct canvas {
    uint8_t y[LARGEST], u[LARGEST], v[LARGEST];
};

static struct pel_planes planes_of(struct canvas *c, uint32_t width,
                                   uint32_t height, bool pairs)
{
    int half = (int)(width + 1) / 2;
    return (struct pel_planes){ .y = c->y,
                                .u = c->u,
                                .v = pairs ? NULL : c->v,
                                .y_stride = (int)width,
                                .u_stride = pairs ? 2 * half : half,
                                .v_stride = half,
                                .width = width,
                                .height = height };
}

static struct pel_planes_given given(const struct pel_picture *p)
{
    struct pel_planes_given planes;
    assert_true(pel_picture_planes(p, &planes));
    return planes;
}

/* Every byte up to the end of the blocks, which repeat the last column and row.
 */
static void assert_plane(const uint8_t *got, int got_stride,
                         const uint8_t *want, int want_stride, int width,
                         int height, int block, int samples)
{
    int wide = (width + block - 1) / block * block;
    int high = (height + block - 1) / block * block;
    for (int y = 0; y < high; y++) {
        int row = y < height ? y : height - 1;
        for (int x = 0; x < wide; x++) {
            int column = x < width ? x : width - 1;
            for (int k = 0; k < samples; k++) {
                int a = got[y * got_stride + x * samples + k];
                int b = want[row * want_stride + column * samples + k];
                if (a != b) {
                    fail_msg("%d, %d of %dx%d: %d instead of %d", x, y, width,
                             height, a, b);
                }
            }
        }
    }
}

static void assert_planes(const struct pel_picture *p, const uint8_t *rgba)
{
    struct canvas c;
    bool pairs = p->ycbcr == PEL_YCBCR_VIDEO;
    const struct pel_planes want = planes_of(&c, p->width, p->height, pairs);
    int width = (int)p->width, height = (int)p->height;
    assert_null(p->rgba);
    assert_int_equal(pel_planes_fill(rgba, width * 4, p->width, p->height,
                                     !pairs, NULL, &want),
                     PEL_OK);
    assert_plane(p->planes[0], p->strides[0], c.y, want.y_stride, width, height,
                 16, 1);
    width = (width + 1) / 2;
    height = (height + 1) / 2;
    assert_plane(p->planes[1], p->strides[1], c.u, want.u_stride, width, height,
                 8, pairs ? 2 : 1);
    if (!pairs) {
        assert_plane(p->planes[2], p->strides[2], c.v, want.v_stride, width,
                     height, 8, 1);
    }
}

static struct pel_bytes jpeg_of(const struct pel_picture *p,
                                const uint8_t *rgba,
                                const struct pel_planes_given *planes,
                                uint32_t width, uint32_t height)
{
    const struct pel_encode_input in = {
        .width = p->width,
        .height = p->height,
        .rgba = rgba,
        .planes = planes,
        .out_width = width,
        .out_height = height,
        .quality = 80,
    };
    struct pel_bytes out;
    assert_int_equal(pel_jpeg_encode(&in, &out), PEL_OK);
    return out;
}

/* As a live view's, and as a file that says of its camera. */
static void assert_coded(const struct pel_picture *p, const uint8_t *rgba)
{
    struct pel_planes_given planes;
    const struct pel_photo_blocks photo = { .exif_size = 9, .xmp_size = 99 };
    assert_false(pel_picture_planes(p, &planes));
    for (int k = 0; k < 2; k++) {
        struct pel_encode_input in = { .width = p->width,
                                       .height = p->height,
                                       .rgba = rgba,
                                       .photo = k ? &photo : NULL,
                                       .quality = p->scan.quality };
        struct pel_bytes a, b;
        assert_int_equal(pel_jpeg_encode(&in, &a), PEL_OK);
        in.rgba = NULL;
        in.scan = pel_picture_scan(p);
        assert_int_equal(pel_jpeg_encode(&in, &b), PEL_OK);
        assert_int_equal(a.size, b.size);
        assert_memory_equal(a.data, b.data, a.size);
        pel_bytes_finish(&a);
        pel_bytes_finish(&b);
    }
}

static void assert_jpegs(const struct pel_picture *p, const uint8_t *rgba)
{
    const struct pel_planes_given planes = given(p);
    for (uint32_t k = 1; k <= 3; k++) { /* twice as large, as it is, smaller */
        uint32_t width = 2 * p->width / k, height = 2 * p->height / k;
        width = k == 2 ? p->width : width ? width : 1;
        height = k == 2 ? p->height : height;
        struct pel_bytes a = jpeg_of(p, rgba, NULL, width, height);
        struct pel_bytes b = jpeg_of(p, NULL, &planes, width, height);
        assert_int_equal(a.size, b.size);
        assert_memory_equal(a.data, b.data, a.size);
        pel_bytes_finish(&a);
        pel_bytes_finish(&b);
    }
}

/* As encoders of video have it: even sizes, pairs or planes, scaled or not. */
static void assert_taken(const struct pel_picture *p, const uint8_t *rgba)
{
    struct pel_planes_scratch scratch = { 0 };
    const struct pel_planes_given planes = given(p);
    for (int k = 0; k < 4; k++) {
        bool pairs = k % 2 == 0, scaled = k >= 2;
        uint32_t width = p->width & ~1u, height = p->height & ~1u;
        if (scaled) {
            width = (width / 2 + 1) & ~1u;
            height = (height / 2 + 1) & ~1u;
        }
        if (width < 2 || height < 2) {
            continue;
        }
        struct canvas a = { 0 }, b = { 0 };
        const struct pel_planes to_a = planes_of(&a, width, height, pairs);
        const struct pel_planes to_b = planes_of(&b, width, height, pairs);
        assert_int_equal(pel_planes_fill(rgba, (int)p->width * 4,
                                         scaled ? p->width : width,
                                         scaled ? p->height : height, false,
                                         &scratch, &to_a),
                         PEL_OK);
        assert_int_equal(pel_planes_take(&planes, scaled, &scratch, &to_b),
                         PEL_OK);
        assert_memory_equal(&a, &b, sizeof a);
    }
    pel_planes_scratch_finish(&scratch);
}

static struct pel_picture *collect(void)
{
    struct pel_picture *p = pel_renderer_collect(renderer, 60000000000);
    assert_non_null(p);
    return p;
}

static enum pel_ycbcr form_of(int i, int turn)
{
    static const enum pel_ycbcr forms[TURNS] = {
        PEL_YCBCR_JPEG, PEL_YCBCR_VIDEO, PEL_YCBCR_NONE, PEL_YCBCR_CODED
    };
    return forms[(i + turn) % TURNS];
}

static void compare(const struct pel_environment *env)
{
    uint8_t *rgba[MOST];
    double ev[MOST];
    struct pel_draw draws[MOST];
    for (int i = 0; i < MOST; i++) {
        draws[i] = (struct pel_draw){ .camera = test_camera(looks[i]),
                                      .layers = PEL_LAYER_COLOR };
        assert_int_equal(pel_renderer_submit(renderer, env, &draws[i], 1),
                         PEL_OK);
        struct pel_picture *p = collect();
        size_t size = (size_t)p->width * p->height * 4;
        rgba[i] = malloc(size);
        assert_non_null(rgba[i]);
        memcpy(rgba[i], p->rgba, size);
        ev[i] = p->exposure_ev;
        pel_picture_release(p);
    }
    for (int turn = 0; turn < TURNS; turn++) {
        for (int i = 0; i < MOST; i++) {
            static const int qualities[] = { 80, 95, 1, 50, 90, 20 };
            draws[i].ycbcr = form_of(i, turn);
            draws[i].quality = qualities[i % 6];
        }
        assert_int_equal(pel_renderer_submit(renderer, env, draws, MOST),
                         PEL_OK);
        for (int i = 0; i < MOST; i++) {
            struct pel_picture *p = collect();
            assert_int_equal(p->ycbcr, draws[i].ycbcr);
            assert_true(p->exposure_ev == ev[i]);
            if (p->ycbcr == PEL_YCBCR_NONE) {
                assert_memory_equal(p->rgba, rgba[i],
                                    (size_t)p->width * p->height * 4);
            } else if (p->ycbcr == PEL_YCBCR_CODED) {
                assert_int_equal(p->scan.quality, draws[i].quality);
                assert_coded(p, rgba[i]);
            } else {
                assert_planes(p, rgba[i]);
                (p->ycbcr == PEL_YCBCR_JPEG ? assert_jpegs
                                            : assert_taken)(p, rgba[i]);
            }
            pel_picture_release(p);
        }
    }
    for (int i = 0; i < MOST; i++) {
        free(rgba[i]);
    }
}

static void together(void **state)
{
    (void)state;
    const struct pel_environment env = test_environment(&sea, 2.5);
    compare(&env);
}

/* Clouds have a program of their own. */
static void one_by_one(void **state)
{
    (void)state;
    struct pel_environment env = test_environment(&sea, 2.5);
    env.clouds = (struct pel_clouds){
        .cover = 0.5, .base_m = 900, .thickness_m = 700, .seed = 3
    };
    compare(&env);
}

/* What others want beside it, and bands, are pixels. */
static void pixels_where_they_are_needed(void **state)
{
    (void)state;
    const struct pel_environment env = test_environment(&sea, 2.5);
    struct pel_draw draw = { .camera = test_camera(looks[7]),
                             .layers = PEL_LAYER_COLOR | PEL_LAYER_DEPTH,
                             .ycbcr = PEL_YCBCR_JPEG };
    for (int i = 0; i < 2; i++) {
        assert_int_equal(pel_renderer_submit(renderer, &env, &draw, 1), PEL_OK);
        if (i == 1) {
            draw.first_row = 64;
            draw.rows = 95 - 64;
            assert_true(pel_renderer_band_done(renderer, 60000000000));
            assert_int_equal(pel_renderer_submit(renderer, &env, &draw, 1),
                             PEL_OK);
        }
        struct pel_picture *p = collect();
        assert_non_null(p->rgba);
        assert_int_equal(p->ycbcr, PEL_YCBCR_NONE);
        pel_picture_release(p);
        draw.layers = PEL_LAYER_COLOR;
        draw.rows = 64;
    }
}

static int set_up(void **state)
{
    (void)state;
    renderer = test_renderer("compute");
    test_sea(8.0, 0.0, 3, &sea);
    return 0;
}

static int tear_down(void **state)
{
    pel_sea_finish(&sea);
    return end_renderer(state);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(together),
        cmocka_unit_test(one_by_one),
        cmocka_unit_test(pixels_where_they_are_needed),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
