/* Drops on a pane before the camera: seams, wrappers, order, what they depend
 * on, that they show the sky turned over. */
#include "render/render_testkit.h"

enum { WIDE = 256, HIGH = 192 };
static struct pel_sea sea;

static struct pel_camera window(double amount)
{
    struct pel_camera c =
        test_camera((struct test_look){ 11, 3, 0, 4, 50, WIDE, HIGH });
    c.auto_exposure = false;
    c.exposure_ev = 13;
    c.wet_lens = amount;
    c.pane = 77;
    return c;
}

static float *radiance_of(struct pel_renderer *r, double time_s,
                          const struct pel_camera *c)
{
    const size_t bytes = sizeof(float) * 4 * c->width * c->height;
    struct pel_environment env = test_environment(&sea, time_s);
    struct pel_picture *p =
        test_draw(r, &env, c, PEL_LAYER_COLOR | PEL_LAYER_RADIANCE);
    float *copy = malloc(bytes);
    assert_non_null(copy);
    memcpy(copy, p->radiance, bytes);
    pel_picture_release(p);
    return copy;
}

/* Share of pixels that differ. */
static double differ(const float *a, const float *b)
{
    double n = 0;
    for (int i = 0; i < WIDE * HIGH; i++) {
        n += memcmp(a + 4 * i, b + 4 * i, 3 * sizeof(float)) != 0;
    }
    return n / (WIDE * HIGH);
}

static void by_amount_time_and_pane(void **state)
{
    (void)state;
    test_sea(3.0, 0.0, 3, &sea);
    struct pel_camera none = window(0), some = window(0.3), all = window(1),
                      other = window(1);
    other.pane = 78;
    float *dry = radiance_of(renderer, 20, &none),
          *a = radiance_of(renderer, 20, &some),
          *b = radiance_of(renderer, 20, &all),
          *later = radiance_of(renderer, 21.5, &all),
          *beside = radiance_of(renderer, 20, &other),
          *again = radiance_of(renderer, 20, &all);
    print_message("covered at 0.3 %.3f, at 1 %.3f; %.3f differ in 1.5 s, %.3f "
                  "on another pane\n",
                  differ(dry, a), differ(dry, b), differ(b, later),
                  differ(b, beside));
    assert_true(differ(dry, a) > 0.01 && differ(dry, a) < 0.6 * differ(dry, b));
    assert_true(differ(dry, b) > 0.08 && differ(dry, b) < 0.6);
    assert_true(differ(b, beside) > 0.1);
    assert_memory_equal(b, again, sizeof(float) * 4 * WIDE * HIGH);
    free(dry);
    free(a);
    free(b);
    free(later);
    free(beside);
    free(again);
    pel_sea_finish(&sea);
}

/* Before the sea drops are brighter below their middles, before the sky darker
 * above. */
static void turned_over(void **state)
{
    (void)state;
    test_sea(3.0, 0.0, 3, &sea);
    struct pel_camera none = window(0), all = window(1);
    double up = 0, down = 0;
    float *dry = radiance_of(renderer, 20, &none),
          *wet = radiance_of(renderer, 20, &all);
    for (int y = 1; y < HIGH - 1; y++) {
        for (int x = 0; x < WIDE; x++) {
            const float *at = wet + 4 * (y * WIDE + x);
            bool here = memcmp(at, dry + 4 * (y * WIDE + x), 12) != 0;
            bool above =
                memcmp(at - 4 * WIDE, dry + 4 * ((y - 1) * WIDE + x), 12) != 0;
            double step = (double)at[1] - (double)at[1 - 4 * WIDE];
            if (here && above) {
                *(step > 0 ? &down : &up) += fabs(step);
            }
        }
    }
    print_message("brighter downwards %.1f times as often as upwards\n",
                  down / up);
    assert_true(down > 1.1 * up);
    free(dry);
    free(wet);
    pel_sea_finish(&sea);
}

/* Halves of a picture are the picture, and both wrappers draw it. */
static void no_seam(void **state)
{
    (void)state;
    static const char *const shadings[] = { "fragment", "compute" };
    float *first = NULL;
    test_sea(7.0, 0.0, 3, &sea);
    struct pel_camera whole = window(0.8);
    for (int s = 0; s < 2; s++) {
        struct pel_renderer *r = test_renderer(shadings[s]);
        float *p = radiance_of(r, 31, &whole);
        if (first && pel_renderer_is_software(r)) {
            assert_memory_equal(first, p, sizeof(float) * 4 * WIDE * HIGH);
        }
        for (int half = 0; half < 2; half++) {
            struct pel_camera part = whole;
            double middle = 0.5 * (whole.tan_left + whole.tan_right);
            part.width = WIDE / 2;
            *(half ? &part.tan_left : &part.tan_right) = middle;
            float *q = radiance_of(r, 31, &part);
            for (int y = 0; y < HIGH; y++) {
                assert_memory_equal(q + 4 * (WIDE / 2) * y,
                                    p + 4 * (WIDE / 2 * half + WIDE * y),
                                    sizeof(float) * 4 * (WIDE / 2));
            }
            free(q);
        }
        free(first);
        first = p;
        pel_renderer_destroy(r);
    }
    free(first);
    pel_sea_finish(&sea);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(by_amount_time_and_pane),
        cmocka_unit_test(turned_over),
        cmocka_unit_test(no_seam), /* makes other renderers current */
    };
    return cmocka_run_group_tests(tests, begin_renderer, end_renderer);
}
