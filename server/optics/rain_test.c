/* Extinction by rain and snow against sums over drops with fall speeds of
 * their own, and against published visual ranges. */
#include "optics/rain.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

static const double pi = 3.14159265358979323846;

/* Of drops of Marshall and Palmer up to 8 mm: what they take, 1/km, and the
 * rain that they are, mm/h, at the speeds of Atlas and Ulbrich 1977. */
static void drops(double rate, double *extinction, double *rain)
{
    const double step = 1e-3; /* mm */
    *extinction = *rain = 0;
    for (int i = 0; i < 8000; i++) {
        double d = step * (i + 0.5);
        double n = 8000.0 * exp(-4.1 * pow(rate, -0.21) * d) * step;
        *extinction += 1e3 * n * 2.0 * pi / 4.0 * d * d * 1e-6;
        *rain += n * pi / 6.0 * d * d * d * 1e-9 * 3.78 * pow(d, 0.67) * 3.6e6;
    }
}

static void rain_takes_twice_its_shadow(void **state)
{
    (void)state;
    const double rates[] = { 0.5, 2, 10, 25, 50, 100, 150 };
    for (size_t i = 0; i < sizeof rates / sizeof *rates; i++) {
        double summed, rain, ours = 1e3 * pel_rain_extinction(rates[i]);
        drops(rates[i], &summed, &rain);
        double atlas = 3.912 / (11.6 * pow(rates[i], -0.63));
        print_message("%5.1f mm/h: %.3f 1/km, by drops %.3f (which are %.1f "
                      "mm/h), Atlas %.3f\n",
                      rates[i], ours, summed, rain, atlas);
        /* Drops over 8 mm, which there are not, take 0.2 % at 150 mm/h. */
        assert_true(fabs(ours / summed - 1) < 5e-3);
        /* What the exponent is rounded to. */
        assert_true(fabs(ours / atlas - 1) < 0.1);
        /* The distribution is a fit: its own rain is off by so much. */
        assert_true(rain > 0.75 * rates[i] && rain < 1.3 * rates[i]);
    }
}

/* The same for flakes of Sekhon and Srivastava by their melted diameter, 20 mm
 * at most; their shadows from the mass of a ball of density 0.17/D. */
static void snow_takes_twice_its_shadow(void **state)
{
    (void)state;
    for (double rate = 0.1; rate <= 10; rate *= 1.5) {
        double summed = 0;
        const double step = 1e-3;
        for (int i = 0; i < 20000; i++) {
            double melted = step * (i + 0.5);
            double n = 2500.0 * pow(rate, -0.94) *
                       exp(-2.29 * pow(rate, -0.45) * melted) * step;
            double mass = pi / 6.0 * pow(0.1 * melted, 3); /* g */
            /* mass = π/6 D³ 0.017/D, D in cm */
            double wide = sqrt(mass / (pi / 6.0 * 0.017)) * 10.0; /* mm */
            summed += n * 2.0 * pi / 4.0 * wide * wide * 1e-6;
        }
        double ours = pel_snow_extinction(rate);
        print_message("%5.2f mm/h: visibility %.0f m\n", rate, 3.912 / ours);
        assert_true(fabs(ours / summed - 1) < 5e-3);
    }
    /* Light, moderate and heavy snow are told apart at visibilities of 1 and
     * 0.5 km (WMO-No. 306), about 1 and 2.5 mm/h: within a factor of 1.6
     * (Rasmussen et al. 1999 find a factor of 3 between kinds of flakes). */
    assert_true(fabs(log(3.912 / pel_snow_extinction(1) / 1000)) < log(1.6));
    assert_true(fabs(log(3.912 / pel_snow_extinction(2.5) / 500)) < log(1.6));
}

static void visibility_is_of_both(void **state)
{
    (void)state;
    /* The same bits where nothing falls. */
    assert_true(pel_visibility_in_rain(12345.678, 0, 0) == 12345.678);
    double v = pel_visibility_in_rain(20000, 25, 0);
    double sigma = 3.912 / 20e3 + pel_rain_extinction(25);
    assert_true(fabs(v * sigma / 3.912 - 1) < 1e-12);
    assert_true(pel_visibility_in_rain(20000, 25, 1) < v);
    assert_true(pel_visibility_in_rain(20000, 0, 10) == 200);
}

static void reports_count_all(void **state)
{
    (void)state;
    const double rows[][3] = { /* seen, rain, snow */
                               { 4000, 1, 0 },   { 800, 25, 0 },
                               { 20000, 5, 0 },  { 600, 0, 2 },
                               { 5000, 0.3, 6 }, { 10000, 0, 0 }
    };
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        double rain = rows[i][1], snow = rows[i][2];
        double air = pel_visibility_besides(rows[i][0], &rain, &snow);
        print_message("%.0f m: %.0f m in %.2f, %.2f mm/h\n", rows[i][0], air,
                      rain, snow);
        assert_true(air >= rows[i][0] && air < 10.001 * rows[i][0]);
        assert_true(rain <= rows[i][1] && snow <= rows[i][2]);
        assert_true(fabs(pel_visibility_in_rain(air, rain, snow) / rows[i][0] -
                         1) < 1e-9);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rain_takes_twice_its_shadow),
        cmocka_unit_test(snow_takes_twice_its_shadow),
        cmocka_unit_test(visibility_is_of_both),
        cmocka_unit_test(reports_count_all),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
