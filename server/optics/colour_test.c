#include "optics/colour.h"

#include "base/near.h"
#include "base/vec.h"
#include "optics/coloursuns.h"
#include "shaders/lib/blocks.h"

static const struct pel_rgb sun = { 1.474, 1.850, 1.912 };

static void to_rec709(struct pel_rgb l, double out[3])
{
    double m[9];
    pel_colour_matrix(1.0, m);
    for (int i = 0; i < 3; i++) {
        out[i] = m[3 * i] * l.r + m[3 * i + 1] * l.g + m[3 * i + 2] * l.b;
    }
}

/* What lies in the program is what the code makes. */
static void suns_are_made_so(void **state)
{
    (void)state;
    struct pel_colour_suns anew;
    pel_colour_suns_make(&anew);
    assert_memory_equal(&anew, &pel_colour_suns, sizeof anew);
}

/* 1.33e5 lx is the solar illuminance constant. */
static void test_sun(void **state)
{
    (void)state;
    double lx = pel_colour_illuminance(sun, 1.0), c[3];
    to_rec709(sun, c);
    /* Back to XYZ with the Rec. 709 primaries. */
    double x = 0.4124564 * c[0] + 0.3575761 * c[1] + 0.1804375 * c[2];
    double y = 0.2126729 * c[0] + 0.7151522 * c[1] + 0.0721750 * c[2];
    double z = 0.0193339 * c[0] + 0.1191920 * c[1] + 0.9503041 * c[2];
    double sum = x + y + z;
    print_message("Sun: %.0f lx, Rec. 709 %.0f %.0f %.0f, xy %.4f %.4f\n", lx,
                  c[0], c[1], c[2], x / sum, y / sum);
    assert_near(lx, 1.33e5, 0.05 * 1.33e5);
    assert_near(y, lx, 1e-4 * lx); /* luminance is the same weighting */
    /* A black body of 5800 K has xy 0.3260, 0.3354 (CIE 1931). */
    assert_near(x / sum, 0.3260, 0.01);
    assert_near(y / sum, 0.3354, 0.01);
}

/* A spectrum that is the Sun's times a parabola is met exactly: here λ⁰, λ¹
 * and λ², against a sum over the Sun and the observer at 1 nm. */
static void test_spectrum_between_samples(void **state)
{
    (void)state;
    double flat[3], red[3], blue[3];
    to_rec709(sun, flat);
    to_rec709((struct pel_rgb){ sun.r * 0.68, sun.g * 0.55, sun.b * 0.44 },
              red);
    to_rec709((struct pel_rgb){ sun.r / 0.68, sun.g / 0.55, sun.b / 0.44 },
              blue);
    assert_true(red[0] / flat[0] > red[1] / flat[1]);
    assert_true(red[1] / flat[1] > red[2] / flat[2]);
    assert_true(blue[2] / flat[2] > blue[0] / flat[0]);
    /* Photopic mean wavelength of sunlight is 0.558 µm. */
    double y = pel_colour_illuminance(
        (struct pel_rgb){ sun.r * 0.68, sun.g * 0.55, sun.b * 0.44 }, 1.0);
    assert_near(y / pel_colour_illuminance(sun, 1.0), 0.558, 0.004);
}

/* ISO 2720: a meter of K = 12.5 reads EV 12 from 512 cd/m². */
static void test_exposure(void **state)
{
    (void)state;
    assert_near(512 * pel_colour_exposure_scale(12), 0.18, 1e-12);
    assert_near(pel_colour_exposure_scale(3) / pel_colour_exposure_scale(4), 2,
                1e-12);
}

static void test_tone_curve(void **state)
{
    (void)state;
    assert_near(pel_tone_curve(0), 0, 1e-12);
    /* To the digits of its constants. */
    assert_near(pel_tone_curve(PEL_TONE_MIDDLE), PEL_TONE_SHOWN, 1e-5);
    assert_near(pel_tone_curve(PEL_TONE_WHITE), 1, 1e-5);
    double before = 0, slope_before = 0;
    for (double stops = -10; stops <= 10.5; stops += 0.25) {
        double y = pel_tone_curve(0.18 * exp2(stops));
        double slope = y - before; /* a step */
        assert_true(y > before);
        /* One shoulder: far over the middle each brings less. */
        assert_true(stops < 3.5 || slope < slope_before);
        before = y;
        slope_before = slope;
    }
}

/* Of light of any colour and strength: nothing is cut, the order of the
 * channels stays, and (r - g) / (g - b), which mixing with white leaves alone.
 */
static void test_colours_roll_off(void **state)
{
    (void)state;
    static const double colours[][3] = {
        { 1, 0.6, 0.2 }, { 0.3, 0.5, 1 }, { 0.2, 1, 0.4 }, { 1, 0.9, 0.8 }
    };
    for (int i = 0; i < 4; i++) {
        double before = 1;
        for (double stops = -8; stops <= 16; stops += 0.5) {
            double x[3], y[3];
            for (int c = 0; c < 3; c++) {
                x[c] = colours[i][c] * exp2(stops);
            }
            pel_tone_filmic(x, y);
            double most = fmax(fmax(y[0], y[1]), y[2]);
            double least = fmin(fmin(y[0], y[1]), y[2]);
            assert_true(least >= 0 && most <= 1);
            assert_near((y[0] - y[1]) * (x[1] - x[2]),
                        (y[1] - y[2]) * (x[0] - x[1]), 1e-9 * exp2(stops));
            double pure = 1 - least / most;
            assert_true(pure > 0 && pure <= before + 1e-12);
            before = pure;
        }
    }
}

static void test_meter(void **state)
{
    (void)state;
    /* More light, more EV, and a brighter picture. */
    double ev = -100, shown = 0;
    for (double l = 1e-4; l < 3e3; l *= 2) {
        double now = pel_meter_ev(l, l, 1e5);
        double x = l * pel_colour_exposure_scale(now);
        assert_true(now > ev && x >= shown);
        ev = now;
        shown = x;
    }
    /* Highlights draw it up: this bright they are at PEL_METER_HIGH. */
    double up = pel_meter_ev(10, 2000, 1e5);
    assert_near(2000 * pel_colour_exposure_scale(up), PEL_METER_HIGH, 1e-9);
    assert_near(pel_meter_ev(1e6, 1e6, PEL_METER_SUNLIGHT), PEL_METER_MOST,
                1e-12);
    assert_near(pel_meter_ev(1e-9, 1e-9, 0), PEL_METER_LEAST, 1e-12);
    /* A sky that brightens by 5 % as the light on the sea falls by 12 %. */
    assert_true(pel_meter_mean(1050, 44e3) < pel_meter_mean(1000, 5e4));
    assert_near(pel_meter_mean(PEL_METER_MATT * 5e4, 5e4), PEL_METER_MATT * 5e4,
                1e-9);
    assert_near(pel_meter_mean(3, 5), 3, 1e-12); /* dusk */
}

/* All that is scattered arrives somewhere. */
static void test_glare(void **state)
{
    (void)state;
    double sum = 0;
    const int n = 200000;
    for (int i = 0; i < n; i++) {
        double u = (i + 0.5) / n, theta = PEL_PI * u * u * u;
        sum += pel_glare_spread(1 - cos(theta)) * 2 * PEL_PI * sin(theta) * 3 *
               PEL_PI * u * u / n;
    }
    assert_near(sum, 1, 1e-6);
    double far =
        pel_glare_spread(1 - cos(0.1)) / pel_glare_spread(1 - cos(0.2));
    assert_near(far, 4, 0.1); /* 1/θ² */
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(suns_are_made_so),
        cmocka_unit_test(test_sun),
        cmocka_unit_test(test_spectrum_between_samples),
        cmocka_unit_test(test_exposure),
        cmocka_unit_test(test_tone_curve),
        cmocka_unit_test(test_colours_roll_off),
        cmocka_unit_test(test_meter),
        cmocka_unit_test(test_glare),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
