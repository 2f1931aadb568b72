/* Places between the nodes against the series themselves. */
#include "scene/orbit.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include <cmocka.h>

/* 1900 to 2100. A cubic is off by 0.023 h^4 of the fourth derivative: 5e-11 of
 * the distance for the month's own term of the Moon's, more for its terms of
 * days; seen are 4e-10. 1e-9 is 0.4 m of the Moon, a hundred thousandth of a
 * pixel's angle. */
static void between_nodes_it_is_the_series(void **state)
{
    (void)state;
    for (int body = 0; body < PEL_ORBITS; body++) {
        double worst = 0;
        for (int i = 0; i < 200; i++) {
            double t = -1.0 + 2.0 * fmod(i * 0.6180339887498949, 1.0);
            struct pel_vec3 a = pel_orbit_at((enum pel_orbit)body, t);
            struct pel_vec3 b = pel_orbit_series((enum pel_orbit)body, t);
            struct pel_vec3 d = pel_vec3_add(a, pel_vec3_scale(b, -1.0));
            worst = fmax(worst, sqrt(pel_vec3_dot(d, d) / pel_vec3_dot(b, b)));
        }
        printf("body %d: %.1e of its distance\n", body, worst);
        assert_true(worst < 1e-9);
    }
}

/* The same bits whatever was asked before. */
static void it_has_no_history(void **state)
{
    (void)state;
    const double t = 0.2648;
    struct pel_vec3 first = pel_orbit_at(PEL_ORBIT_MOON, t);
    for (int i = 0; i < 50; i++) {
        (void)pel_orbit_at(PEL_ORBIT_MOON, t + 1e-5 * i);
        (void)pel_orbit_at(PEL_ORBIT_MOON, t - 1e-5 * i);
    }
    struct pel_vec3 again = pel_orbit_at(PEL_ORBIT_MOON, t);
    assert_true(first.x == again.x && first.y == again.y && first.z == again.z);
}

/* Across a node, before J2000 too. */
static void it_is_continuous(void **state)
{
    (void)state;
    const double hour = 3600.0 / PEL_ORBIT_CENTURY_S;
    for (int i = -3; i <= 3; i++) {
        struct pel_vec3 a = pel_orbit_at(PEL_ORBIT_MOON, (i - 1e-9) * hour);
        struct pel_vec3 b = pel_orbit_at(PEL_ORBIT_MOON, (i + 1e-9) * hour);
        struct pel_vec3 d = pel_vec3_add(a, pel_vec3_scale(b, -1.0));
        assert_true(sqrt(pel_vec3_dot(d, d)) < 1e-4); /* km; 1 km/s, rounding */
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(between_nodes_it_is_the_series),
        cmocka_unit_test(it_has_no_history),
        cmocka_unit_test(it_is_continuous),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
