#include "optics/vision.h"

#include "base/near.h"
#include "base/vec.h"
#include "optics/colour.h"
#include "shaders/lib/blocks.h"

/* CIE 1931's V(λ) at 10 nm from 380 nm, from its table: not the program's fit.
 */
static const double photopic[] = {
    0.0000, 0.0001, 0.0004, 0.0012, 0.0040, 0.0116, 0.0230, 0.0380,
    0.0600, 0.0910, 0.1390, 0.2080, 0.3230, 0.5030, 0.7100, 0.8620,
    0.9540, 0.9950, 0.9950, 0.9520, 0.8700, 0.7570, 0.6310, 0.5030,
    0.3810, 0.2650, 0.1750, 0.1070, 0.0610, 0.0320, 0.0170, 0.0082,
    0.0041, 0.0021, 0.0010, 0.0005, 0.0003, 0.0001, 0.0001
};

/* Scotopic over photopic of a black body, times 1. */
static double ratio(double kelvin)
{
    double s = 0, p = 0;
    for (int i = 0; i < 39; i++) {
        double nm = 380.0 + 10.0 * i;
        double light = pow(nm, -5) / (exp(1.43878e7 / (nm * kelvin)) - 1.0);
        s += 1700.0 * pel_vision_rods(nm) * light;
        p += 683.0 * photopic[i] * light;
    }
    return s / p;
}

/* Illuminant A has 1.41; 683/1699 is V' where both are the same, at 555 nm. */
static void test_rods(void **state)
{
    (void)state;
    assert_near(ratio(2856), 1.41, 0.015);
    assert_near(pel_vision_rods(555), 683.0 / 1699, 1e-3);
    assert_near(pel_vision_rods(507), 1, 4e-3); /* between two of 5 nm */
    assert_near(pel_vision_rods(700) + pel_vision_rods(300), 0, 1e-12);
    /* Sunlight, at noon and as far as three samples know it: of a black body of
     * 5800 K, within 5 %. */
    double w[3];
    const struct pel_rgb sun = { 1.474, 1.850, 1.912 };
    pel_colour_rods(1.0, w);
    double s = w[0] * sun.r + w[1] * sun.g + w[2] * sun.b;
    double p = pel_colour_illuminance(sun, 1.0);
    print_message("S/P: A %.3f, Sun %.3f, 5800 K %.3f; rods' weights %.1f "
                  "%.1f %.1f\n",
                  ratio(2856), s / p, ratio(5800), w[0], w[1], w[2]);
    assert_near(s / p, ratio(5800), 0.05 * ratio(5800));
}

/* CIE 191:2010, Table 11: m is 0 at 0.005 and 1 at 5 cd/m² of mesopic
 * luminance, whose iteration by itself is the reference. */
static void test_mesopic(void **state)
{
    (void)state;
    for (double sp = 0.25; sp < 4.1; sp *= 2) {
        double before = -1, shown = 0;
        for (double y = 1e-5; y < 20; y *= 1.3) {
            double m = 0.5;
            for (int i = 0; i < 200; i++) {
                double k = 683.0 / 1699;
                double l = (m * y + (1 - m) * sp * y * k) / (m + (1 - m) * k);
                m = fmin(fmax(0.767 + 0.3334 * log10(l), 0), 1);
            }
            double got = pel_vision_cones(y, sp * y);
            assert_near(got, m, 0.01);
            double now = pel_vision_luminance(y, sp * y);
            assert_true(got >= before - 1e-9 && now > shown);
            before = got;
            shown = now;
        }
    }
    assert_near(pel_vision_luminance(6, 12), 6, 1e-9);
    assert_near(pel_vision_luminance(1e-3, 2e-3), 2e-3, 1e-9);
}

/* Purkinje: a red and a blue of one luminance by day; by night the blue is the
 * brighter one, and neither has a colour. */
static void test_purkinje(void **state)
{
    (void)state;
    double m[9], w[3], seen[2][3];
    pel_colour_matrix(0.5, m);
    pel_colour_rods(0.5, w);
    for (int night = 0; night < 2; night++) {
        double luminance[2];
        for (int blue = 0; blue < 2; blue++) {
            const double l[3] = { blue ? 0.2 : 2, 1, blue ? 2 : 0.2 };
            double c[3], s = 0;
            for (int i = 0; i < 3; i++) {
                c[i] =
                    m[3 * i] * l[0] + m[3 * i + 1] * l[1] + m[3 * i + 2] * l[2];
                s += w[i] * l[i];
            }
            double y = 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2];
            double scale = (night ? 1e-3 : 50) / y;
            for (int i = 0; i < 3; i++) {
                c[i] *= scale;
            }
            pel_vision_seen(c, s * scale, seen[blue]);
            const double *v = seen[blue];
            luminance[blue] = 0.2126 * v[0] + 0.7152 * v[1] + 0.0722 * v[2];
            if (night) {
                assert_near(v[0] / v[1], PEL_EYE_RED / PEL_EYE_GREEN, 1e-9);
                assert_near(luminance[blue], s * scale, 1e-3 * s * scale);
            } else {
                assert_near(v[0], c[0], 1e-9);
            }
        }
        print_message("blue over red: %.2f\n", luminance[1] / luminance[0]);
        assert_true(night ? luminance[1] > 1.5 * luminance[0]
                          : fabs(luminance[1] / luminance[0] - 1) < 1e-6);
    }
}

/* Less light, less EV, and a darker picture, down to starlight. */
static void test_ev(void **state)
{
    (void)state;
    double ev = -100, shown = 0;
    for (double l = 1e-5; l < 3e3; l *= 1.5) {
        double now = pel_vision_ev(l, l, 1e5);
        double x = l * pel_colour_exposure_scale(now);
        assert_true(now > ev && x >= shown);
        ev = now;
        shown = x;
    }
    assert_near(pel_vision_sight(0.04), 1, 1e-12);
    /* Where rods still see by Weber's law, Krawczyk's key against that of day,
     * 1.03 - 2 / (2 + lg(L + 1)): 0.06 of it. */
    double dusk = 0.04 * pel_colour_exposure_scale(pel_vision_ev(0.04, 0, 0));
    double day = 500 * pel_colour_exposure_scale(pel_vision_ev(500, 0, 1e5));
    assert_near(dusk / day, 0.038444 / 0.604453, 1e-4);
    double stars = 1e-5 * pel_colour_exposure_scale(pel_vision_ev(1e-5, 0, 0));
    assert_near(stars / dusk, 0.716 * 0.03 / 0.038444, 0.002);
    /* Both of the paper's branches meet. */
    assert_near(log10(pel_vision_sight(pow(10, -3.9401))),
                log10(pel_vision_sight(pow(10, -3.9399))), 1e-2);
    assert_near(log10(pel_vision_sight(pow(10, -1.4401))), 0, 0.015);
    assert_near(log10(pel_vision_sight(1e-5)), -5 + 2.86 - 0.395, 1e-9);
    assert_near(pel_vision_ev(1e-9, 1e-9, 0), PEL_EYE_LEAST, 1e-12);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_rods),
        cmocka_unit_test(test_mesopic),
        cmocka_unit_test(test_purkinje),
        cmocka_unit_test(test_ev),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
