/* How high a wind sea is by its fetch, against the spectra themselves, and a
 * steady sea: what follows of a small change of its spectrum. */
#include "ocean/growth.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>

/* after those */
#include <cmocka.h>

#include "ocean/directional.h"

static double height_of(const struct pel_sea_desc *desc)
{
    struct pel_directional *spectrum;
    struct pel_band_moments all;
    assert_int_equal(pel_directional_create(desc, &spectrum), PEL_OK);
    pel_directional_moments(spectrum, 0, INFINITY, &all);
    pel_directional_destroy(spectrum);
    return 4 * sqrt(all.m0);
}

static const enum pel_spectrum_kind kinds[] = { PEL_SPECTRUM_JONSWAP,
                                                PEL_SPECTRUM_ELFOUHAILY };

/* JONSWAP's law is exact but for waves below 2 cm; Elfouhaily's table is linear
 * between logarithms of fetch and wind. By wind: of 2 m/s, and from 5 on. */
static void test_heights(void **state)
{
    (void)state;
    const double winds[] = { 2, 5, 10, 20, 30 };
    const double fetches[] = { 2e3, 1.7e4, 1e5, 6e5, 2e6 };
    double worst[2] = { 0 };
    for (int k = 0; k < 2; k++) {
        struct pel_growth_law law;
        pel_growth_of(kinds[k], 2.2, &law);
        for (int i = 0; i < 25; i++) {
            const struct pel_sea_desc desc = { .synthesiser =
                                                   PEL_SYNTHESISER_FFT,
                                               .kind = kinds[k],
                                               .wind_mps = winds[i / 5],
                                               .fetch_m = fetches[i % 5],
                                               .gamma = 2.2,
                                               .wave_count = 60 };
            double law_m = pel_growth_height(&law, desc.wind_mps, desc.fetch_m);
            worst[i >= 5] =
                fmax(worst[i >= 5], fabs(law_m / height_of(&desc) - 1));
        }
    }
    printf("heights by the law: within %.2f %% at 2 m/s, %.2f %% from 5\n",
           100 * worst[0], 100 * worst[1]);
    assert_true(worst[0] < 1.5e-2 && worst[1] < 3e-3);
}

static void test_fetches(void **state)
{
    (void)state;
    for (int k = 0; k < 2; k++) {
        struct pel_growth_law law;
        pel_growth_of(kinds[k], 3.3, &law);
        for (double wind = 1; wind < 30; wind *= 1.37) {
            double least =
                pel_growth_height(&law, wind, PEL_GROWTH_LEAST_FETCH_M);
            double most =
                pel_growth_height(&law, wind, PEL_GROWTH_MOST_FETCH_M);
            for (double f = 0.01; f < 1; f += 0.07) {
                double h = least + f * (most - least);
                double fetch = pel_growth_fetch(&law, wind, h);
                assert_float_equal(pel_growth_height(&law, wind, fetch), h,
                                   1e-6 * h);
            }
            assert_float_equal(pel_growth_fetch(&law, wind, 0.5 * least),
                               PEL_GROWTH_LEAST_FETCH_M, 0);
            /* Higher than the wind can raise: developed. */
            double fetch = pel_growth_fetch(&law, wind, 2 * most);
            assert_float_equal(pel_growth_height(&law, wind, fetch), most,
                               1e-3 * most);
            assert_true(pel_growth_peak(&law, wind, 1e5) >=
                        pel_growth_peak(&law, wind, 1e4));
        }
        assert_float_equal(pel_growth_height(&law, 0, 1e5), 0, 0);
        assert_float_equal(pel_growth_peak(&law, 0, 1e5), 0, 0);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_heights),
        cmocka_unit_test(test_fetches),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
