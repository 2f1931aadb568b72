/* Rain on waves: the ring waves' slopes in the spectrum and in the waves drawn,
 * what is calmed, and no rain, the same bits. */
#include "ocean/ringwaves.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "ocean/directional.h"
#include "ocean/foam.h"
#include "ocean/sea.h"

static struct pel_sea_desc described(double wind, double rain,
                                     enum pel_synthesiser s)
{
    return (struct pel_sea_desc){ .wind_mps = wind,
                                  .fetch_m = 200000,
                                  .gamma = 3.3,
                                  .seed = 5,
                                  .synthesiser = s,
                                  .wave_count = 60,
                                  .whitecaps = 1,
                                  .rain_mm_h = rain };
}

/* Height and slope variance of the published spectrum, summed over frequency;
 * the wave number by halving the interval that holds it. */
static void published(double rain, double *height, double *slope)
{
    *height = *slope = 0;
    for (int i = 0; i < 4000; i++) {
        double log_step = 10.0 / 4000, f = exp(-3.0 + log_step * (i + 0.5));
        double w = 2 * 3.14159265358979 * f, lo = 1e-3, hi = 1e5;
        for (int j = 0; j < 80; j++) {
            double k = sqrt(lo * hi);
            double w2 = 9.81 * k * (1 + k * k / (370.0 * 370.0));
            *(w2 < w * w ? &lo : &hi) = k;
        }
        double peak = 5.772 - 0.0018 * rain, width = 4.42 + 0.0028 * rain;
        double x = log(f / peak) / (width / peak);
        double s = 6e-4 * pow(rain, 0.53) * exp(-3.14159265358979 * x * x);
        *height += 1e-4 * s * f * log_step;
        *slope += 1e-4 * s * f * log_step * lo * lo;
    }
}

static double slopes(const struct pel_sea *sea)
{
    return sea->slope_variance_along + sea->slope_variance_cross;
}

static void rings_have_the_published_slopes(void **state)
{
    (void)state;
    const double rates[] = { 1, 10, 50, 150 };
    for (size_t i = 0; i < sizeof rates / sizeof *rates; i++) {
        double height, slope;
        published(rates[i], &height, &slope);
        for (int s = 0; s < PEL_SYNTHESISERS; s++) {
            struct pel_sea_desc desc = described(0, rates[i], s);
            struct pel_directional *spectrum;
            struct pel_band_moments m;
            assert_int_equal(pel_directional_create(&desc, &spectrum), PEL_OK);
            pel_directional_moments(spectrum, 0, INFINITY, &m);
            pel_directional_destroy(spectrum);
            struct pel_sea sea;
            assert_int_equal(pel_sea_build(&desc, &sea), PEL_OK);
            print_message("%3.0f mm/h: rms %.2f mm, slope variance %.4f; "
                          "spectrum %.4f, drawn %.4f\n",
                          rates[i], 1e3 * sqrt(height), slope,
                          m.along + m.cross, slopes(&sea));
            assert_true(fabs(m.m0 / height - 1) < 2e-3);
            assert_true(fabs((m.along + m.cross) / slope - 1) < 2e-3);
            assert_true(fabs(m.along / m.cross - 1) < 2e-3);
            /* Trochoids lose a little by being pressed (their chop). */
            assert_true(fabs(slopes(&sea) / slope - 1) < 0.03);
            pel_sea_finish(&sea);
        }
    }
}

static void short_waves_are_calmed(void **state)
{
    (void)state;
    double k10 = 2 * 3.14159265358979 / 0.10;
    /* 4 ν k² against β, by hand for 0.1 m at 5 m/s: decay 4e-5 · 3948 = 0.158
     * (all but 3e-6 of the motion is in the layer), u* = 0.1677 m/s, c = 0.401
     * m/s (with surface tension), β = 0.05 · 62.83 · 0.1677²/0.401 = 0.2204. */
    assert_true(fabs(pel_rain_leaves(60, k10, 5) - (1 - 0.158 / 0.2204)) <
                5e-3);
    /* The long sea stays: 1 % of a wave of 5 m, whatever the wind. */
    assert_true(pel_rain_leaves(150, 2 * 3.14159265358979 / 5, 0) > 0.98);
    for (double u = 2; u <= 20; u *= 1.3) {
        for (double k = 0.1; k < 1000; k *= 1.2) {
            double a = pel_rain_leaves(5, k, u), b = pel_rain_leaves(40, k, u);
            assert_true(a <= 1 && b <= a && b >= 0);
            assert_true(pel_rain_leaves(140, k, u) == b);
            assert_true(pel_rain_leaves(40, k, u * 1.1) >= b);
        }
    }
    struct pel_sea_desc desc = described(5, 50, PEL_SYNTHESISER_FFT);
    struct pel_directional *wet, *dry;
    struct pel_band_moments a, b;
    assert_int_equal(pel_directional_create(&desc, &wet), PEL_OK);
    desc.rain_mm_h = 0;
    assert_int_equal(pel_directional_create(&desc, &dry), PEL_OK);
    pel_directional_moments(wet, 0, 2 * 3.14159265358979 / 2, &a);
    pel_directional_moments(dry, 0, 2 * 3.14159265358979 / 2, &b);
    assert_true(fabs(a.m0 / b.m0 - 1) < 0.01);
    /* 0.2 to 0.5 m: longer than the rings, shorter than what rain spares. */
    pel_directional_moments(wet, 12.6, 31.4, &a);
    pel_directional_moments(dry, 12.6, 31.4, &b);
    print_message("0.2 to 0.5 m at 5 m/s in 50 mm/h: %.2f of the energy\n",
                  a.m0 / b.m0);
    assert_true(a.m0 < 0.8 * b.m0);
    pel_directional_destroy(wet);
    pel_directional_destroy(dry);
}

static void fewer_whitecaps(void **state)
{
    (void)state;
    double before = 1;
    for (double rain = 0; rain <= 60; rain += 20) {
        struct pel_sea_desc desc =
            described(15, rain, PEL_SYNTHESISER_TROCHOIDS);
        struct pel_sea sea;
        assert_int_equal(pel_sea_build(&desc, &sea), PEL_OK);
        double w = sea.foam->coverage / pel_foam_of_wind(15);
        assert_true(fabs(w - exp(-rain / 20)) < 1e-9 && w <= before);
        before = w;
        pel_sea_finish(&sea);
    }
}

static void out_of_range(void **state)
{
    (void)state;
    struct pel_sea sea;
    struct pel_sea_desc desc = described(5, 151, PEL_SYNTHESISER_FFT);
    assert_int_equal(pel_sea_build(&desc, &sea), PEL_ERR_OUT_OF_RANGE);
    desc.rain_mm_h = NAN;
    assert_int_equal(pel_sea_build(&desc, &sea), PEL_ERR_OUT_OF_RANGE);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rings_have_the_published_slopes),
        cmocka_unit_test(short_waves_are_calmed),
        cmocka_unit_test(fewer_whitecaps),
        cmocka_unit_test(out_of_range),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
