/* The plan of drops and flakes near the eye: speeds against Gunn and Kinzer's
 * table, shadows against the extinction, ways past a moving eye, what a
 * picture shows of a kind against directions through its pixels. */
#include "optics/falling.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "optics/rain.h"

/* Gunn and Kinzer 1949: mm, m/s. */
static void drops_fall_as_measured(void **state)
{
    (void)state;
    static const double table[][2] = { { 0.4, 1.62 }, { 1.0, 4.03 },
                                       { 2.0, 6.49 }, { 3.0, 8.06 },
                                       { 4.0, 8.83 }, { 5.0, 9.09 } };
    for (size_t i = 0; i < sizeof table / sizeof *table; i++) {
        double v = pel_drop_speed(table[i][0]);
        print_message("%.1f mm: %.2f m/s, measured %.2f\n", table[i][0], v,
                      table[i][1]);
        /* 0.4 mm is where the fit is worst. */
        assert_true(fabs(v - table[i][1]) < 0.25);
    }
    for (double d = 1; d < 5; d++) { /* aggregates: 1 to 1.7 m/s */
        assert_true(pel_flake_speed(d) > 0.9 && pel_flake_speed(d) < 1.7);
    }
}

static struct pel_fall_plan plan_of(double rain, double snow,
                                    struct pel_vec3 eye_mps)
{
    struct pel_fall_plan plan;
    const struct pel_fall_desc desc = { .rain_mm_h = rain,
                                        .snow_mm_h = snow,
                                        .wind_mps = 7,
                                        .wind_to_rad = 0.4,
                                        .eye_mps = eye_mps,
                                        .shutter_s = 0.01,
                                        .time_s = 1e8,
                                        .seed = 5,
                                        .pixel_rad = 5e-4 };
    pel_fall_plan(&desc, &plan);
    return plan;
}

static void kinds_are_all_that_falls(void **state)
{
    (void)state;
    const struct pel_vec3 eye = { -3, 2, 1 };
    struct pel_fall_plan plan = plan_of(12, 2, eye);
    double shadows = 0;
    assert_int_equal(plan.count, PEL_FALL_KINDS);
    for (int i = 0; i < plan.count; i++) {
        const struct pel_fall_kind *k = &plan.kinds[i];
        const double past[3] = { 7 * cos(0.4) + 3, 7 * sin(0.4) - 2,
                                 -k->speed_mps - 1 };
        double speed =
            sqrt(past[0] * past[0] + past[1] * past[1] + past[2] * past[2]);
        assert_true(fabs(k->streak_m / (0.01 * speed) - 1) < 1e-9);
        assert_true(fabs(k->axis.x * speed - past[0]) < 1e-9 &&
                    fabs(k->axis.z * speed - past[2]) < 1e-9);
        assert_true(fabs(pel_vec3_dot(k->axis, k->side)) < 1e-9);
        assert_true(k->turn >= 0 && k->turn < 65536);
        assert_true(i == 0 || k->flake != k[-1].flake ||
                    k->diameter_m >= k[-1].diameter_m);
        for (int j = 0; j < k->shell_count; j++) {
            assert_true(k->shells[j].cell_m > k->streak_m);
        }
        shadows += k->extinction;
    }
    /* Twice their shadows is what they take. */
    assert_true(
        fabs(2 * shadows / (pel_rain_extinction(12) + pel_snow_extinction(2)) -
             1) < 1e-9);
    assert_int_equal(plan_of(0, 0, eye).count, 0);
}

static double chance(uint64_t *state)
{
    *state = *state * UINT64_C(6364136223846793005) + 1442695040888963407u;
    return (double)(*state >> 11) * 0x1p-53;
}

static void pictures_show_all_of_them(void **state)
{
    (void)state;
    uint64_t random = 3;
    int all = 0;
    for (int n = 0; n < 400; n++) {
        struct pel_fall_plan plan =
            plan_of(10, 0,
                    (struct pel_vec3){ 20 * chance(&random) - 10,
                                       20 * chance(&random) - 10, 0 });
        const struct pel_fall_kind *k = &plan.kinds[n % 4];
        struct pel_vec3 z = pel_vec3_normalize(
            (struct pel_vec3){ chance(&random) - 0.5, chance(&random) - 0.5,
                               chance(&random) - 0.5 });
        struct pel_vec3 x = pel_vec3_normalize(pel_vec3_cross(
            (struct pel_vec3){ chance(&random), chance(&random), 0.1 }, z));
        const struct pel_mat3 m = { x, pel_vec3_cross(z, x), z };
        double wide = 0.05 + 1.5 * chance(&random), high = 0.7 * wide,
               aside = 0.4 * chance(&random);
        struct pel_fall_range r =
            pel_fall_range(k, &m, aside - wide, aside + wide, -high, high);
        for (int i = 0; i < 500; i++) {
            struct pel_vec3 to = pel_mat3_apply(
                &m, (struct pel_vec3){ aside + wide * (2 * chance(&random) - 1),
                                       high * (2 * chance(&random) - 1), -1 });
            double u = pel_vec3_dot(to, k->side),
                   v = pel_vec3_dot(to, pel_vec3_cross(k->axis, k->side));
            double slope = pel_vec3_dot(to, k->axis) / hypot(u, v);
            double turn = atan2(v, u) / (2 * PEL_PI) + 0.5 - r.turn_first;
            turn -= floor(turn);
            if (fabs(slope) < 35) { /* others are not drawn */
                assert_true(turn <= r.turns);
                assert_true(slope >= r.slope_first && slope <= r.slope_last);
                all++;
            }
        }
        assert_true(wide > 0.2 || r.turns < 0.4 || r.slope_last > 3 ||
                    r.slope_first < -3);
    }
    assert_true(all > 100000);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(drops_fall_as_measured),
        cmocka_unit_test(kinds_are_all_that_falls),
        cmocka_unit_test(pictures_show_all_of_them),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
