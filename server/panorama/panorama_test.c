#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
/* The framework wants these four first. */
#include <cmocka.h>
#include <math.h>
#include <stdlib.h>

#include "base/vec.h"
#include "panorama/panorama.h"

enum { COLUMNS = 256, ROWS = 128 };

/* A half's value by its definition (IEEE 754). */
static double half_value(unsigned half)
{
    int exponent = (int)(half >> 10);
    double fraction = half & 1023u;
    return exponent == 0 ? ldexp(fraction, -24)
                         : ldexp(1024.0 + fraction, exponent - 25);
}

/* Each half of numbers, and what lies by a quarter step beside it. */
static void halves_are_the_nearest(void **state)
{
    (void)state;
    for (unsigned h = 0; h < 0x7BFF; h++) {
        double here = half_value(h), next = half_value(h + 1);
        assert_int_equal(pel_half_of((float)here), h);
        assert_int_equal(pel_half_of((float)(0.75 * here + 0.25 * next)), h);
        assert_int_equal(pel_half_of((float)(0.25 * here + 0.75 * next)),
                         h + 1);
    }
    assert_int_equal(pel_half_of(-1.0f), 0);
    assert_int_equal(pel_half_of(1e30f), 0x7BFF);
    assert_int_equal(pel_half_of(NAN), 0);
}

static double angle_from(double azimuth, double elevation, double sun_azimuth,
                         double sun_elevation)
{
    return acos(pel_clamp(sin(elevation) * sin(sun_elevation) +
                              cos(elevation) * cos(sun_elevation) *
                                  cos(azimuth - sun_azimuth),
                          -1.0, 1.0));
}

/* A sky of 2 with a cone of `peak` about a Sun of radius 1.8°; its irradiance
 * more than the sky's. */
static double with_sun(float *values, double azimuth, double elevation,
                       double peak)
{
    double more = 0.0;
    for (int row = 0; row < ROWS; row++) {
        double e = (0.5 - (row + 0.5) / ROWS) * PEL_PI;
        for (int column = 0; column < COLUMNS; column++) {
            double a = ((column + 0.5) / COLUMNS - 0.5) * 2 * PEL_PI;
            double off = angle_from(a, e, azimuth, elevation) / PEL_DEG;
            double light = off < 1.8 ? peak * (1.0 - off / 1.8) : 0.0;
            more += light * cos(e) * (2 * PEL_PI / COLUMNS) *
                    (2 * sin(PEL_PI / ROWS / 2));
            for (int i = 0; i < 3; i++) {
                values[3 * (row * COLUMNS + column) + i] = (float)(2.0 + light);
            }
        }
    }
    return more;
}

/* Found within a third of a texel (1.4°), its light within 2 %: of the cone's
 * foot nothing is lost, sky around it is level. */
static void sun_is_taken_out(void **state)
{
    (void)state;
    static const double places[][2] = { { 30, 20 }, { -179.5, 5 }, { 77, 71 } };
    float *values = malloc(3 * sizeof *values * COLUMNS * ROWS);
    assert_non_null(values);
    for (size_t k = 0; k < sizeof places / sizeof *places; k++) {
        double azimuth = places[k][0] * PEL_DEG;
        double elevation = places[k][1] * PEL_DEG;
        const struct pel_panorama *p;
        double more = with_sun(values, azimuth, elevation, 5e4);
        assert_int_equal(
            pel_panorama_create(COLUMNS, ROWS, values, true, &p, NULL), PEL_OK);
        assert_true(p->has_sun);
        assert_true(angle_from(p->sun_azimuth_rad, p->sun_elevation_rad,
                               azimuth, elevation) < 0.5 * PEL_DEG);
        for (int i = 0; i < 3; i++) {
            assert_true(fabs(p->sun[i] / more - 1.0) < 0.02);
        }
        for (int i = 0; i < 3 * COLUMNS * ROWS; i++) {
            assert_true(fabs(half_value(p->halves[i]) * p->unit - 2.0) < 2e-3);
        }
        pel_panorama_unref(p);
    }
    free(values);
}

/* What does not outshine its surroundings is a bright cloud; what was not
 * asked for stays. */
static void clouds_and_others_stay(void **state)
{
    (void)state;
    float *values = malloc(3 * sizeof *values * COLUMNS * ROWS);
    const struct pel_panorama *p;
    assert_non_null(values);
    for (int k = 0; k < 2; k++) {
        (void)with_sun(values, 0.7, 0.4, k ? 5e4 : 20.0);
        assert_int_equal(
            pel_panorama_create(COLUMNS, ROWS, values, k == 0, &p, NULL),
            PEL_OK);
        assert_false(p->has_sun);
        double most = 0.0;
        for (int i = 0; i < 3 * COLUMNS * ROWS; i++) {
            most = fmax(most, half_value(p->halves[i]) * p->unit);
        }
        assert_true(most > (k ? 1e4 : 10.0));
        pel_panorama_unref(p);
    }
    free(values);
}

static void bad_ones_are_refused(void **state)
{
    (void)state;
    float *values = calloc(3 * sizeof *values, (size_t)COLUMNS * ROWS);
    const struct pel_panorama *p;
    assert_non_null(values);
    assert_int_equal(pel_panorama_create(COLUMNS, ROWS, values, true, &p, NULL),
                     PEL_OK);
    assert_false(p->has_sun);
    assert_ptr_equal(pel_panorama_ref(p), p);
    pel_panorama_unref(p);
    pel_panorama_unref(p);
    static const int sides[][2] = { { 8, 4 }, { 256, 256 }, { 8192, 4096 } };
    for (int i = 0; i < 3; i++) {
        assert_int_equal(pel_panorama_create(sides[i][0], sides[i][1], values,
                                             true, &p, NULL),
                         PEL_ERR_MALFORMED);
    }
    static const float bad[] = { -1.0f, NAN, INFINITY };
    for (int i = 0; i < 3; i++) {
        values[1000] = bad[i];
        assert_int_equal(
            pel_panorama_create(COLUMNS, ROWS, values, false, &p, NULL),
            PEL_ERR_MALFORMED);
    }
    free(values);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(halves_are_the_nearest),
        cmocka_unit_test(sun_is_taken_out),
        cmocka_unit_test(clouds_and_others_stay),
        cmocka_unit_test(bad_ones_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
