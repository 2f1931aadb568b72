/* Sixty frames of a moving camera: how much a far patch flickers, as a number.
 * Aliasing shows as variance over time that the same patch, sampled finely and
 * averaged, does not have. */
#include "render/render_testkit.h"

#define FRAMES 60
#define ACROSS 40
#define DOWN 10
#define FINE 6 /* the reference has 36 samples a pixel */
#define PIXELS (ACROSS * DOWN)
#define RATE_HZ 30.0
#define SPEED_MPS 10.0
#define HEIGHT_M 12.0
#define MOST 1.25

/* A piece of a picture 1280 px wide and 60° across, towards the Sun; `below` is
 * the tangent of its upper edge under the level. */
static struct pel_camera far_patch(double height_m, double below, double time_s,
                                   int fine)
{
    const double pixel = 2.0 * tan(30.0 * PEL_DEG) / 1280.0;
    struct pel_camera c = test_camera((struct test_look){
        height_m, 0.0, 0.0, 0.0, 60.0, (uint32_t)(ACROSS * fine),
        (uint32_t)(DOWN * fine) });
    c.tan_left = -0.5 * ACROSS * pixel;
    c.tan_right = 0.5 * ACROSS * pixel;
    c.tan_top = -below;
    c.tan_bottom = -below - DOWN * pixel;
    c.north_m = SPEED_MPS * time_s;
    return c;
}

struct film {
    float light[FRAMES][PIXELS];
};

static void shoot(const struct pel_sea *sea, double below, int fine,
                  struct film *out)
{
    for (int n = 0; n < FRAMES; n++) {
        double time_s = 30.0 + n / RATE_HZ;
        struct pel_environment env = test_environment(sea, time_s);
        env.lights[PEL_LIGHT_SUN].direction = test_sun(12.0, 3.0);
        struct pel_camera c = far_patch(HEIGHT_M, below, n / RATE_HZ, fine);
        struct pel_picture *p =
            test_draw(renderer, &env, &c, PEL_LAYER_RADIANCE);
        memset(out->light[n], 0, sizeof out->light[n]);
        for (int i = 0; i < PIXELS * fine * fine; i++) {
            int x = i % (ACROSS * fine) / fine, y = i / (ACROSS * fine) / fine;
            out->light[n][y * ACROSS + x] +=
                p->radiance[4 * i + 1] / (float)(fine * fine);
        }
        pel_picture_release(p);
    }
}

struct flicker {
    double mean;
    double variance; /* over time, mean of the pixels, over the mean squared */
    double flicker;  /* the same of differences from frame to frame */
};

static struct flicker measure(const struct film *f)
{
    struct flicker out = { 0 };
    for (int i = 0; i < PIXELS; i++) {
        double sum = 0, square = 0, jump = 0;
        for (int n = 0; n < FRAMES; n++) {
            double v = (double)f->light[n][i];
            sum += v;
            square += v * v;
            if (n > 0) {
                double d = v - (double)f->light[n - 1][i];
                jump += d * d;
            }
        }
        sum /= FRAMES;
        out.mean += sum / PIXELS;
        out.variance += (square / FRAMES - sum * sum) / PIXELS;
        out.flicker += jump / (FRAMES - 1) / PIXELS;
    }
    out.variance /= out.mean * out.mean;
    out.flicker /= out.mean * out.mean;
    return out;
}

/* At 100 m a pixel is 0.1 m wide and 0.8 m long, at 240 m 0.2 × 4 m, at 650 m
 * 0.6 × 35 m: from where the longer waves are resolved to where none is. A
 * picture of one sample a pixel that filters well flickers no more than the
 * average of 36, and less where it keeps statistics instead of waves; a
 * sample that is not filtered has 1.4 to 2 times the variance and 4 to 10 times
 * the difference from frame to frame. A quarter more is allowed:
 * what 400 pixels over two seconds, which see the same few waves, leave open.
 */
static void far_patch_is_quiet(void **state)
{
    (void)state;
    static const double below[] = { 0.12, 0.05, 0.0185 };
    static struct film plain, fine;
    for (int k = 0; k < 6; k++) {
        static struct pel_sea sea;
        if (k < 3) {
            test_sea(8.0, 0.0, 3, &sea);
        } else {
            test_fft_sea(8.0, 3, &sea);
        }
        shoot(&sea, below[k % 3], 1, &plain);
        shoot(&sea, below[k % 3], FINE, &fine);
        struct flicker a = measure(&plain), b = measure(&fine);
        print_message("%s at %3.0f m: variance over 60 frames %.4f, reference "
                      "%.4f, ratio %.2f; frame to frame %.5f, %.5f, %.2f; "
                      "mean light %+.1f %%\n",
                      k < 3 ? "trochoids" : "FFT", HEIGHT_M / below[k % 3],
                      a.variance, b.variance, a.variance / b.variance,
                      a.flicker, b.flicker, a.flicker / b.flicker,
                      100 * (a.mean / b.mean - 1));
        assert_true(a.variance < MOST * b.variance);
        assert_true(a.flicker < MOST * b.flicker);
        pel_sea_finish(&sea);
    }
}

#define SIDE 256

static struct pel_picture *glitter(const struct pel_sea *sea, bool sparkle,
                                   uint32_t width)
{
    struct pel_environment env = test_environment(sea, 30.0);
    env.lights[PEL_LIGHT_SUN].direction = test_sun(12.0, 3.0);
    env.sparkle = sparkle;
    struct pel_camera c = test_camera(
        (struct test_look){ 12.0, 0.0, -5.0, 0.0, 8.0, SIDE, SIDE });
    c.width = width;
    c.tan_right -= (c.tan_right - c.tan_left) * (SIDE - width) / SIDE;
    return test_draw(renderer, &env, &c, PEL_LAYER_SUN);
}

/* Sparkle moves the Sun's light between pixels and leaves its mean: within four
 * standard errors of the mean of what it changes. A tile has the bits of the
 * whole. */
static void sparkle_keeps_the_mean(void **state)
{
    (void)state;
    static struct pel_sea sea;
    test_fft_sea(8.0, 3, &sea);
    struct pel_picture *without = glitter(&sea, false, SIDE);
    struct pel_picture *with = glitter(&sea, true, SIDE);
    struct pel_picture *tile = glitter(&sea, true, SIDE / 2);
    double sum = 0, change = 0, square = 0;
    for (int i = 0; i < SIDE * SIDE; i++) {
        double d = (double)with->sun[4 * i + 1] - without->sun[4 * i + 1];
        sum += without->sun[4 * i + 1];
        change += d;
        square += d * d;
    }
    for (int y = 0; y < SIDE; y++) {
        assert_memory_equal(with->sun + 4L * y * SIDE,
                            tile->sun + 2L * y * SIDE,
                            2L * SIDE * sizeof *tile->sun);
    }
    print_message("sparkle: mean %+.2f %%, standard error %.2f %%, each pixel "
                  "%.0f %% of the mean\n",
                  100 * change / sum, 100 * sqrt(square) / sum,
                  100 * sqrt(square) * SIDE / sum);
    assert_true(square > 0.01 * sum * sum / (SIDE * SIDE));
    assert_true(fabs(change) < 4 * sqrt(square));
    pel_picture_release(without);
    pel_picture_release(with);
    pel_picture_release(tile);
    pel_sea_finish(&sea);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(far_patch_is_quiet),
        cmocka_unit_test(sparkle_keeps_the_mean),
    };
    return cmocka_run_group_tests(tests, begin_renderer, end_renderer);
}
