#include "encode/planes.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#define MOST (128 * 128)

struct canvas {
    uint8_t y[MOST], u[MOST], v[MOST];
};

static struct pel_planes planes_of(struct canvas *c, uint32_t width,
                                   uint32_t height, bool paired)
{
    int half = (int)(width + 1) / 2;
    return (struct pel_planes){ .y = c->y,
                                .u = c->u,
                                .v = paired ? NULL : c->v,
                                .y_stride = (int)width,
                                .u_stride = paired ? 2 * half : half,
                                .v_stride = half,
                                .width = width,
                                .height = height };
}

static void paint(uint8_t *rgba, uint32_t width, uint32_t height,
                  const uint8_t colour[3])
{
    for (size_t i = 0; i < (size_t)width * height; i++) {
        memcpy(rgba + 4 * i, colour, 3);
        rgba[4 * i + 3] = 255;
    }
}

/* ITU-R BT.601: Y' of R'G'B' in 0..1, and the two differences. */
static void bt601(const uint8_t rgb[3], bool full_range, double out[3])
{
    double r = rgb[0] / 255.0, g = rgb[1] / 255.0, b = rgb[2] / 255.0;
    double y = 0.299 * r + 0.587 * g + 0.114 * b;
    double u = (b - y) / 1.772, v = (r - y) / 1.402;
    out[0] = full_range ? 255 * y : 16 + 219 * y;
    out[1] = 128 + (full_range ? 255 : 224) * u;
    out[2] = 128 + (full_range ? 255 : 224) * v;
}

static void colours_are_those_of_bt601(void **state)
{
    (void)state;
    static const uint8_t colours[][3] = { { 255, 0, 0 },    { 0, 255, 0 },
                                          { 0, 0, 255 },    { 255, 255, 255 },
                                          { 17, 130, 201 }, { 0, 0, 0 } };
    static const uint32_t outs[][2] = { { 32, 16 }, { 64, 48 }, { 16, 10 } };
    uint8_t rgba[32 * 16 * 4];
    struct pel_planes_scratch scratch = { 0 };
    for (size_t i = 0; i < sizeof colours / sizeof *colours; i++) {
        paint(rgba, 32, 16, colours[i]);
        for (size_t k = 0; k < 9; k++) {
            struct canvas c = { 0 };
            const uint32_t *size = outs[k / 3];
            bool paired = k % 3 == 0, full = k % 3 == 2;
            struct pel_planes p = planes_of(&c, size[0], size[1], paired);
            double want[3];
            bt601(colours[i], full, want);
            assert_int_equal(
                pel_planes_fill(rgba, 32 * 4, 32, 16, full, &scratch, &p),
                PEL_OK);
            size_t y = (size_t)size[0] * size[1] - 1, uv = y / 4;
            /* libyuv reckons in 7 or 8 bits of coefficients, and rounds down
             * where it makes pictures smaller. */
            double near = k < 6 ? 2 : 4;
            assert_true(fabs(c.y[y] - want[0]) <= near);
            assert_true(fabs((paired ? c.u[2 * uv] : c.u[uv]) - want[1]) <=
                        near);
            assert_true(fabs((paired ? c.u[2 * uv + 1] : c.v[uv]) - want[2]) <=
                        near);
        }
    }
    pel_planes_scratch_finish(&scratch);
}

/* A ramp stays where it is: no shift by half a pixel, no mirror. */
static void scaling_keeps_places(void **state)
{
    (void)state;
    static const uint32_t outs[][2] = { { 64, 64 }, { 128, 96 }, { 24, 30 } };
    uint8_t rgba[64 * 64 * 4];
    struct pel_planes_scratch scratch = { 0 };
    for (int way = 0; way < 2; way++) {
        for (int i = 0; i < 64 * 64; i++) {
            int at = way ? i / 64 : i % 64;
            memset(rgba + 4 * i, 4 * at + 2, 3);
        }
        for (size_t k = 0; k < sizeof outs / sizeof *outs; k++) {
            struct canvas c;
            uint32_t width = outs[k][0], height = outs[k][1];
            struct pel_planes p = planes_of(&c, width, height, false);
            assert_int_equal(
                pel_planes_fill(rgba, 64 * 4, 64, 64, true, &scratch, &p),
                PEL_OK);
            for (uint32_t i = 0; i < width * height; i++) {
                double place = way ? (i / width + 0.5) / height
                                   : (i % width + 0.5) / width;
                double want = fmin(fmax(256.0 * place, 2.0), 254.0);
                /* Half a step of the ramp, which has steps of 4, and one for
                 * rounding; a shift by one pixel of the source is 4. Smaller
                 * pictures are made of means of whole pixels. */
                assert_true(fabs(c.y[i] - want) <= (k < 2 ? 3.0 : 6.0));
            }
        }
    }
    pel_planes_scratch_finish(&scratch);
}

static void sizes_are_checked(void **state)
{
    (void)state;
    struct canvas c;
    uint8_t rgba[4 * 4 * 4] = { 0 };
    struct pel_planes_scratch scratch = { 0 };
    struct pel_planes p = planes_of(&c, 4, 4, true);
    assert_int_equal(pel_planes_fill(NULL, 16, 4, 4, true, &scratch, &p),
                     PEL_ERR_INVALID);
    assert_int_equal(pel_planes_fill(rgba, 16, 0, 4, true, &scratch, &p),
                     PEL_ERR_INVALID);
    assert_int_equal(pel_planes_fill(rgba, 16, 4, 16385, true, &scratch, &p),
                     PEL_ERR_INVALID);
    p.width = 0;
    assert_int_equal(pel_planes_fill(rgba, 16, 4, 4, true, &scratch, &p),
                     PEL_ERR_INVALID);
    assert_null(scratch.data);
}

static struct pel_planes_given given(const struct pel_planes *p)
{
    return (struct pel_planes_given){ p->y,        p->u,        p->v,
                                      p->y_stride, p->u_stride, p->v_stride,
                                      p->width,    p->height };
}

/* Planes of one colour stay it, cut, scaled and laid out anew. */
static void planes_are_taken(void **state)
{
    (void)state;
    static struct canvas from, to;
    for (int form = 0; form < 2; form++) {
        for (int scaled = 0; scaled < 2; scaled++) {
            struct pel_planes_scratch scratch = { 0 };
            const bool paired = form == 1;
            const struct pel_planes in = planes_of(&from, 32, 16, paired);
            const struct pel_planes out = planes_of(&to, 14, 10, false);
            const struct pel_planes_given here = given(&in);
            memset(&to, 0, sizeof to);
            memset(from.y, 100, MOST);
            for (int i = 0; i < MOST; i++) {
                from.u[i] = paired && i % 2 ? 70 : 50;
            }
            memset(from.v, 70, MOST);
            assert_int_equal(pel_planes_take(&here, scaled, &scratch, &out),
                             PEL_OK);
            for (int i = 0; i < 14 * 10; i++) {
                assert_int_equal(to.y[i], 100);
            }
            for (int i = 0; i < 7 * 5; i++) {
                assert_int_equal(to.u[i], 50);
                assert_int_equal(to.v[i], 70);
            }
            pel_planes_scratch_finish(&scratch);
        }
    }
}

static void what_cannot_be_taken_is_refused(void **state)
{
    (void)state;
    static struct canvas from, to;
    struct pel_planes_scratch scratch = { 0 };
    const struct pel_planes in = planes_of(&from, 16, 16, false);
    const struct {
        uint32_t from_width, width, height;
        bool scaled, paired;
    } refused[] = {
        { 16, 16, 16, false, true }, /* planes do not become pairs */
        { 16, 18, 16, false, false }, { 16, 16, 18, false, false },
        { 0, 16, 16, true, false },   { 16385, 16, 16, true, false },
        { 16, 0, 16, true, false },   { 16, 16, 16385, true, false },
    };
    for (size_t i = 0; i < sizeof refused / sizeof *refused; i++) {
        struct pel_planes_given here = given(&in);
        struct pel_planes out = planes_of(&to, 16, 16, refused[i].paired);
        here.width = refused[i].from_width;
        out.width = refused[i].width;
        out.height = refused[i].height;
        assert_int_equal(
            pel_planes_take(&here, refused[i].scaled, &scratch, &out),
            PEL_ERR_INVALID);
    }
    assert_null(scratch.data);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(colours_are_those_of_bt601),
        cmocka_unit_test(scaling_keeps_places),
        cmocka_unit_test(sizes_are_checked),
        cmocka_unit_test(planes_are_taken),
        cmocka_unit_test(what_cannot_be_taken_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
