#include "ocean/spectrum.h"

#include "base/near.h"

static const struct pel_sea_desc pm = {
    .kind = PEL_SPECTRUM_PIERSON_MOSKOWITZ,
    .wind_mps = 10,
};

static const struct pel_sea_desc jonswap = {
    .kind = PEL_SPECTRUM_JONSWAP,
    .wind_mps = 10,
    .fetch_m = 1e5,
    .gamma = 3.3,
};

/* Midpoint rule over ln ω, so fine that its own error is below 1e-8. */
static double brute_m0(const struct pel_sea_desc *d, double lo, double hi)
{
    const int n = 400000;
    double step = log(hi / lo) / n, sum = 0;
    for (int i = 0; i < n; i++) {
        double omega = lo * exp(step * (i + 0.5));
        sum += omega * pel_spectrum_wind(d, omega);
    }
    return sum * step;
}

static void test_eq1_values(void **state)
{
    (void)state;
    /* eq. 1 written out, with V20 = 1.0625 · 10 m/s. */
    double v20 = 10.625, omega = 1.1;
    double expected = 8.1e-3 * 9.81 * 9.81 / pow(omega, 5) *
                      exp(-0.74 * pow(9.81 / v20 / omega, 4));
    assert_near(pel_spectrum_wind(&pm, omega), expected, 1e-12 * expected);
    struct pel_sea_desc calm = pm;
    calm.wind_mps = 0;
    assert_true(pel_spectrum_wind(&calm, omega) == 0);
    assert_true(pel_spectrum_peak(&calm) == 0);
    assert_true(pel_spectrum_m0(&calm, 0, INFINITY) == 0);
}

static void test_significant_height(void **state)
{
    (void)state;
    for (double u = 5; u <= 30; u += 5) {
        struct pel_sea_desc d = pm;
        d.wind_mps = u;
        double v20 = PEL_WIND_20_OVER_10 * u;
        double hs = 4 * sqrt(pel_spectrum_m0(&d, 0, INFINITY));
        /* 0.2092 is given to four digits. */
        assert_near(hs * 9.81 / (v20 * v20), 0.2092, 5e-5);
    }
}

static void test_m0_against_quadrature(void **state)
{
    (void)state;
    const struct pel_sea_desc *all[] = { &pm, &jonswap };
    for (int i = 0; i < 2; i++) {
        double peak = pel_spectrum_peak(all[i]);
        double bounds[][2] = { { 0.3 * peak, 50 * peak },
                               { 0.9 * peak, 1.7 * peak },
                               { 1.2 * peak, 9 * peak },
                               { 3 * peak, 9 * peak } };
        for (int j = 0; j < 4; j++) {
            double lo = bounds[j][0], hi = bounds[j][1];
            double expected = brute_m0(all[i], lo, hi);
            assert_near(pel_spectrum_m0(all[i], lo, hi), expected,
                        1e-6 * expected);
        }
    }
}

static void test_peak_is_the_maximum(void **state)
{
    (void)state;
    const struct pel_sea_desc *all[] = { &pm, &jonswap };
    for (int i = 0; i < 2; i++) {
        double peak = pel_spectrum_peak(all[i]);
        double top = pel_spectrum_wind(all[i], peak);
        for (double r = 0.5; r < 3; r += 0.01) {
            assert_true(pel_spectrum_wind(all[i], r * peak) <=
                        top * (1 + 1e-12));
        }
    }
}

static void test_jonswap_values(void **state)
{
    (void)state;
    double peak = 22 * cbrt(9.81 * 9.81 / (10 * 1e5));
    assert_near(pel_spectrum_peak(&jonswap), peak, 1e-12);
    double alpha = 0.076 * pow(100 / (1e5 * 9.81), 0.22);
    double at_peak = alpha * 9.81 * 9.81 / pow(peak, 5) * exp(-1.25) * 3.3;
    assert_near(pel_spectrum_wind(&jonswap, peak), at_peak, 1e-12 * at_peak);
    double omega = 0.9 * peak; /* one part in ten below: r = exp(−1/(2·0.49)) */
    double shape = alpha * 9.81 * 9.81 / pow(omega, 5) *
                   exp(-1.25 * pow(peak / omega, 4)) *
                   pow(3.3, exp(-0.01 / (2 * 0.0049)));
    assert_near(pel_spectrum_wind(&jonswap, omega), shape, 1e-9 * shape);
}

/* Fetch beyond full development changes nothing: its peak is that of
 * Pierson–Moskowitz at the longest. */
static void test_jonswap_fully_developed(void **state)
{
    (void)state;
    struct pel_sea_desc d = jonswap;
    d.fetch_m = 2e6;
    assert_near(pel_spectrum_peak(&d), pel_spectrum_peak(&pm), 1e-9);
    double hs = 4 * sqrt(pel_spectrum_m0(&d, 0, INFINITY));
    assert_true(hs > 2.4 && hs < 3.3);
}

static void test_spreading_exponent(void **state)
{
    (void)state;
    double peak = pel_spectrum_peak(&pm);
    assert_near(pel_spectrum_spreading(&pm, 0.8 * peak), 6.97 * pow(0.8, 4.06),
                1e-12);
    double age = 10 * peak / 9.81;
    assert_near(pel_spectrum_spreading(&pm, 2 * peak),
                9.77 * pow(2, -2.33 - 1.45 * (age - 1.17)), 1e-12);
}

static void test_direction_is_a_density(void **state)
{
    (void)state;
    const double exponents[] = { 0, 0.5, 2, 9.77, 80 };
    for (int i = 0; i < 5; i++) {
        const int n = 20000;
        double sum = 0;
        for (int j = 0; j < n; j++) {
            double theta = PEL_PI * (2 * (j + 0.5) / n - 1);
            sum += pel_spectrum_direction(exponents[i], theta);
        }
        /* The midpoint rule is spectrally exact on a period, except for
         * s = 0.5, whose kink at ±π costs n⁻². */
        assert_near(sum * 2 * PEL_PI / n, 1.0, 1e-8);
    }
    assert_near(pel_spectrum_direction(2, 0.7), pel_spectrum_direction(2, -0.7),
                1e-15);
}

static void test_dispersion(void **state)
{
    (void)state;
    assert_near(pel_dispersion_omega(0.05), sqrt(9.81 * 0.05), 1e-7);
    assert_near(pel_dispersion_omega(370), sqrt(2 * 9.81 * 370), 1e-9);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_eq1_values),
        cmocka_unit_test(test_significant_height),
        cmocka_unit_test(test_m0_against_quadrature),
        cmocka_unit_test(test_peak_is_the_maximum),
        cmocka_unit_test(test_jonswap_values),
        cmocka_unit_test(test_jonswap_fully_developed),
        cmocka_unit_test(test_spreading_exponent),
        cmocka_unit_test(test_direction_is_a_density),
        cmocka_unit_test(test_dispersion),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
