#include "ocean/seastate.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "ocean/report.h"

static void close_to(double value, double wanted, double within)
{
    assert_true(fabs(value - wanted) <= within);
}

/* The middle of each class is of its number. */
static void words_go_back_to_numbers(void **state)
{
    (void)state;
    for (unsigned i = 0; i <= 10; i++) {
        assert_int_equal(pel_beaufort_of(pel_beaufort_wind(i)), i);
    }
    assert_int_equal(pel_beaufort_of(0.29), 0);
    assert_int_equal(pel_beaufort_of(0.3), 1);
    assert_int_equal(pel_beaufort_of(29), 11);
    for (unsigned i = 1; i <= 8; i++) {
        assert_int_equal(pel_douglas_of(pel_douglas_height(i)), i);
    }
    assert_int_equal(pel_douglas_of(0), 0);
    assert_int_equal(pel_douglas_of(14), 9);
}

/* A fully developed sea's peak is at c = 1.2 U about, a young one's below. */
static void the_age_of_waves(void **state)
{
    (void)state;
    struct pel_sea_desc d = { .kind = PEL_SPECTRUM_PIERSON_MOSKOWITZ,
                              .wind_mps = 12,
                              .fetch_m = 20e3,
                              .gamma = 3.3,
                              .wave_count = 60 };
    struct pel_sea_parts p;
    assert_int_equal(pel_sea_parts(&d, &p), PEL_OK);
    close_to(p.wave_age, 1.2, 0.05);
    assert_true(p.swell_m0 == 0);
    double whole = p.wind_sea_m0;
    d.swell_count = 2;
    d.swell[0] = (struct pel_swell_desc){ .height_m = 3,
                                          .period_s = 12,
                                          .spread_rad = 0.2 };
    d.swell[1] = d.swell[0];
    d.swell[1].height_m = 4;
    assert_int_equal(pel_sea_parts(&d, &p), PEL_OK);
    close_to(4 * sqrt(p.swell_m0), 5, 1e-12);
    assert_true(p.wind_sea_m0 == whole);
    d.kind = PEL_SPECTRUM_JONSWAP;
    assert_int_equal(pel_sea_parts(&d, &p), PEL_OK);
    assert_true(p.wave_age > 0.3 && p.wave_age < 0.8);
    d.wind_mps = 0;
    assert_int_equal(pel_sea_parts(&d, &p), PEL_OK);
    assert_true(p.wave_age == 0 && p.wind_sea_m0 == 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(words_go_back_to_numbers),
        cmocka_unit_test(the_age_of_waves),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
