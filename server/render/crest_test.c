/* Waves that rise above the eye: the water on both sides of the eye's
 * horizontal is the same. */
#include "render/render_testkit.h"

/* Glitter is a few bright pixels of each picture, by which the sides' light is
 * a quarter off, of 12 pictures half. */
#define PICTURES 72
#define A_MOMENT 12 /* pictures, whose transforms are made once */

static struct pel_sea sea;

/* Of pixels of near water in one side's rows. */
struct side {
    double sum, steps; /* of light; of its steps from pixel to pixel */
    long count;
};

static void look_at_rows(const struct pel_picture *p, uint32_t from,
                         uint32_t to, struct side *out)
{
    const double near_m = 120;
    for (uint32_t y = from; y < to; y++) {
        for (uint32_t x = 1; x < p->width; x++) {
            size_t i = (size_t)y * p->width + x;
            if (!(p->depth[i] < near_m) || !(p->depth[i - 1] < near_m)) {
                continue;
            }
            double now = p->radiance[4 * i + 1];
            double before = p->radiance[4 * (i - 1) + 1];
            out->sum += now;
            out->steps += fabs(now - before);
            out->count++;
        }
    }
}

static void water_above_the_eye_is_as_below_it(void **state)
{
    (void)state;
    const uint32_t rows = 8; /* of 0.19 degrees each, on either side */
    struct side above = { 0 }, below = { 0 };
    test_fft_sea(20.0, 3, &sea);
    for (int i = 0; i < PICTURES; i++) {
        struct pel_environment env =
            test_environment(&sea, 40.0 + 37.3 * (i / A_MOMENT));
        struct pel_camera c = test_camera(
            (struct test_look){ 0.4, 37.0 * i, 0.0, 0.0, 60.0, 320, 180 });
        struct pel_surface_sample at_eye;
        c.east_m = 311.0 * i;
        pel_sea_sample(&sea, c.east_m, 0, env.time_s, &at_eye);
        c.altitude_m = fmax(at_eye.height_m + 0.6, 0.4);
        struct pel_picture *p =
            test_draw(renderer, &env, &c, PEL_LAYER_RADIANCE | PEL_LAYER_DEPTH);
        look_at_rows(p, 90 - rows, 90, &above);
        look_at_rows(p, 90, 90 + rows, &below);
        pel_picture_release(p);
    }
    pel_sea_finish(&sea);
    double detail = above.steps / above.sum / (below.steps / below.sum);
    double light =
        above.sum / (double)above.count / (below.sum / (double)below.count);
    print_message("%ld pixels above, %ld below: detail %.2f, light %.2f\n",
                  above.count, below.count, detail, light);
    assert_true(above.count > 1000);
    /* Shaded flat, as by the mean plane, it has 0.26 of the detail. */
    assert_true(detail > 0.6 && detail < 1.6);
    assert_true(light > 0.6 && light < 1.6);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(water_above_the_eye_is_as_below_it),
    };
    return cmocka_run_group_tests(tests, begin_renderer, end_renderer);
}
