#include "optics/colour.h"

#include "base/near.h"
#include "base/vec.h"

static const struct pel_rgb sun = { 1.474, 1.850, 1.912 };

static void to_rec709(struct pel_rgb l, double out[3])
{
    double m[9];
    pel_colour_matrix(m);
    for (int i = 0; i < 3; i++) {
        out[i] = m[3 * i] * l.r + m[3 * i + 1] * l.g + m[3 * i + 2] * l.b;
    }
}

/* 1.33e5 lx is the solar illuminance constant. */
static void test_sun(void **state)
{
    (void)state;
    double lx = pel_colour_illuminance(sun), c[3];
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
        (struct pel_rgb){ sun.r * 0.68, sun.g * 0.55, sun.b * 0.44 });
    assert_near(y / pel_colour_illuminance(sun), 0.558, 0.004);
}

static void test_exposure(void **state)
{
    (void)state;
    assert_near(pel_colour_auto_ev(2.5 * 4096), 12, 1e-12);
    assert_near(pel_colour_auto_ev(0), -3, 1e-12);
    assert_near(pel_colour_auto_ev(1e9), 16, 1e-12);
    assert_near(pel_colour_exposure_scale(0), 1 / 1.2, 1e-15);
    assert_near(pel_colour_exposure_scale(15), 1 / (1.2 * 32768), 1e-15);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_sun),
        cmocka_unit_test(test_spectrum_between_samples),
        cmocka_unit_test(test_exposure),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
