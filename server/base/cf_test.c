/* Units as UDUNITS reads them, worked out by hand; times by calendars, from
 * tables of days. */
#include "base/cf.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>

#include <cmocka.h>

static const struct {
    const char *unit;
    int metres, seconds, radians;
    double factor;
} products[] = {
    { "m", 1, 0, 0, 1 },
    { "0.01 m", 1, 0, 0, 0.01 },
    { "US survey foot", 1, 0, 0, 1200.0 / 3937 },
    { "us-ft", 1, 0, 0, 1200.0 / 3937 },
    { "nautical miles per hour", 1, -1, 0, 1852.0 / 3600 },
    { "m s**-1", 1, -1, 0, 1 },
    { "m.s-1", 1, -1, 0, 1 },
    { "km/h", 1, -1, 0, 1 / 3.6 },
    { "m2/Hz", 2, 1, 0, 1 },
    { "(meter * meter)/Hz", 2, 1, 0, 1 },
    { "meter^2 second", 2, 1, 0, 1 },
    { "m2/Hz/degr", 2, 1, -1, 180 / M_PI },
    { "m2 s rad-1", 2, 1, -1, 1 },
    { "m**2 s radian**-1", 2, 1, -1, 1 },
    { "m^{2}.s.degree^{-1}", 2, 1, -1, 180 / M_PI },
    { "m2/(rad/s)/rad", 2, 1, -2, 1 },
    { "cm2/Hz", 2, 1, 0, 1e-4 },
    { "rad s-1", 0, -1, 1, 1 },
    { "s-1", 0, -1, 0, 1 },
    { "mHz", 0, -1, 0, 1e-3 },
};

static const char *const wrong[] = { "",     "furlong",      "m/",
                                     "m//s", "(m",           "m)",
                                     "2",    "m^9",          "-1 m",
                                     "m s+", "((((((m))))))" };

static void units_are_products(void **state)
{
    (void)state;
    struct pel_cf_power p;
    for (size_t i = 0; i < sizeof products / sizeof *products; i++) {
        print_message("%s\n", products[i].unit);
        assert_true(pel_cf_product(products[i].unit, &p));
        assert_int_equal(p.metres, products[i].metres);
        assert_int_equal(p.seconds, products[i].seconds);
        assert_int_equal(p.radians, products[i].radians);
        assert_true(fabs(p.factor / products[i].factor - 1) < 1e-12);
    }
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        print_message("not %s\n", wrong[i]);
        assert_false(pel_cf_product(wrong[i], &p));
    }
}

static void of_a_quantity(void **state)
{
    (void)state;
    double f;
    assert_true(pel_cf_unit("degrees_true", PEL_CF_DEG, &f) && f == 1);
    assert_true(pel_cf_unit("radians", PEL_CF_DEG, &f));
    assert_true(fabs(f - 180 / M_PI) < 1e-12);
    assert_true(pel_cf_unit("fathoms", PEL_CF_M, &f) && f == 1.8288);
    assert_false(pel_cf_unit("fathoms", PEL_CF_S, &f));
    assert_false(pel_cf_unit("rad/s", PEL_CF_HZ, &f));
    assert_false(pel_cf_unit("m/s", PEL_CF_M, &f));
}

/* cftime 1.6 has the same. */
static const struct {
    const char *units, *calendar;
    double value, unix_s;
} moments[] = {
    { "days since 1990-01-01T00:00:00Z", NULL, 11116, 1591574400 },
    { "hours since 1900-01-01 00:00:00.0", "standard", 1055811, 1591930800 },
    { "days since 0001-01-01", NULL, 737584, 1591488000 },
    { "days since 0001-01-01", "proleptic_gregorian", 737584, 1591660800 },
    { "days since 2001-01-01", "noleap", 365 * 3 + 59, 1078099200 },
    { "seconds since 1970-01-01 00:00:00 +01:00", NULL, 3600, 0 },
};

static void times_by_calendars(void **state)
{
    (void)state;
    struct pel_fault fault = { 0 };
    double t;
    for (size_t i = 0; i < sizeof moments / sizeof *moments; i++) {
        assert_int_equal(pel_cf_time(moments[i].units, moments[i].calendar,
                                     moments[i].value, &t, &fault),
                         PEL_OK);
        print_message("%s: %.3f\n", moments[i].units, t);
        assert_true(t == moments[i].unix_s);
    }
    assert_int_not_equal(
        pel_cf_time("months since 1990-01-01", NULL, 1, &t, &fault), PEL_OK);
    assert_int_not_equal(
        pel_cf_time("days since 1990-01-01", "lunar", 1, &t, &fault), PEL_OK);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(units_are_products),
        cmocka_unit_test(of_a_quantity),
        cmocka_unit_test(times_by_calendars),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
