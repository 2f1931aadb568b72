#include "scene/almanac.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "base/vec.h"
#include "scene/ephemeris.h"
#include "scene/sun.h"

#define DAY_S 86400.0
#define LONDON 51.51 * PEL_DEG, -0.13 * PEL_DEG

static void close_to(double value, double wanted, double within)
{
    assert_true(fabs(value - wanted) <= within);
}

static double midnight(const char *text)
{
    double unix_s = 0;
    assert_int_equal(pel_utc_parse(text, &unix_s), PEL_OK);
    return unix_s;
}

/* Published for London on 1 January 2000, to the minute: 08:06, 16:02; the Sun
 * at its highest at 12:04, 15.5 degrees. */
static void the_sun_is_as_published(void **state)
{
    (void)state;
    double start = midnight("2000-01-01T00:00:00Z");
    struct pel_body_day day;
    pel_almanac_sun(start, LONDON, &day);
    close_to(day.rise_s - start, 3600 * 8 + 60 * 6, 60);
    close_to(day.set_s - start, 3600 * 16 + 60 * 2, 60);
    close_to(day.culmination_s - start, 3600 * 12 + 60 * 4, 60);
    close_to(day.highest_rad / PEL_DEG, 15.5, 0.1);
}

static double moon_elevation(double unix_s)
{
    struct pel_moon_place moon;
    pel_ephemeris_moon(unix_s, LONDON, &moon);
    return asin(moon.direction.z) / PEL_DEG;
}

/* Each is where the ephemeris has the limb at the horizon, and in a month one
 * day has no moonrise. */
static void the_moon_keeps_its_month(void **state)
{
    (void)state;
    double start = midnight("2026-03-01T00:00:00Z");
    int rises = 0, sets = 0;
    for (int i = 0; i < 59; i++) {
        struct pel_body_day day;
        pel_almanac_moon(start + DAY_S * i, LONDON, &day);
        if (!isnan(day.rise_s)) {
            rises++;
            close_to(moon_elevation(day.rise_s), -50.0 / 60, 0.01);
            assert_true(moon_elevation(day.rise_s + 60) > -50.0 / 60);
        }
        if (!isnan(day.set_s)) {
            sets++;
            close_to(moon_elevation(day.set_s), -50.0 / 60, 0.01);
            assert_true(moon_elevation(day.set_s + 60) < -50.0 / 60);
        }
        if (!isnan(day.culmination_s)) {
            assert_true(moon_elevation(day.culmination_s) >=
                        moon_elevation(day.culmination_s + 300));
            assert_true(moon_elevation(day.culmination_s) >=
                        moon_elevation(day.culmination_s - 300));
        }
    }
    assert_int_equal(rises, 57);
    assert_int_equal(sets, 57);
}

/* Midnight sun and polar night. */
static void the_arctic_has_no_events(void **state)
{
    (void)state;
    struct pel_body_day day;
    pel_almanac_sun(midnight("2026-06-21T00:00:00Z"), 80 * PEL_DEG, 0, &day);
    assert_true(isnan(day.rise_s) && isnan(day.set_s));
    close_to(day.highest_rad / PEL_DEG, 33.4, 0.1);
    pel_almanac_sun(midnight("2026-12-21T00:00:00Z"), 80 * PEL_DEG, 0, &day);
    assert_true(isnan(day.rise_s) && isnan(day.set_s));
    close_to(day.highest_rad / PEL_DEG, -13.4, 0.1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_sun_is_as_published),
        cmocka_unit_test(the_moon_keeps_its_month),
        cmocka_unit_test(the_arctic_has_no_events),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
