/* Areas: their shape and motion, what they do to a queried surface, the same
 * surface where there are none. */
#include "ocean/areas.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "ocean/hash.h"

static struct pel_sea_desc described(enum pel_synthesiser s)
{
    return (struct pel_sea_desc){ .kind = PEL_SPECTRUM_ELFOUHAILY,
                                  .wind_mps = 7,
                                  .fetch_m = 200000,
                                  .gamma = 3.3,
                                  .seed = 5,
                                  .synthesiser = s,
                                  .wave_count = 60 };
}

static struct pel_area_desc circle(double factor)
{
    return (struct pel_area_desc){ .radius_m = 100,
                                   .edge_m = 20,
                                   .factor = factor };
}

static void add(struct pel_sea_desc *d, struct pel_area_desc a)
{
    d->area[d->area_count++] = a;
}

static double factor_at(const struct pel_sea_desc *d, double x, double y,
                        double t)
{
    return pel_areas_factor(d, x, y, t, NULL);
}

static void circles_and_polygons(void **state)
{
    (void)state;
    struct pel_sea_desc d = described(PEL_SYNTHESISER_TROCHOIDS);
    add(&d, circle(0.4));
    assert_float_equal(factor_at(&d, 0, 0, 0), 0.4, 1e-12);
    assert_float_equal(factor_at(&d, 89, 0, 0), 0.4, 1e-12);
    assert_float_equal(factor_at(&d, 100, 0, 0), 0.7, 1e-12);
    assert_true(factor_at(&d, 0, 111, 0) == 1);
    d.area_count = 0;
    struct pel_area_desc p = circle(0.5);
    /* An L: its notch is outside. */
    static const struct pel_vec2 corners[] = { { 0, 0 },    { 200, 0 },
                                               { 200, 80 }, { 80, 80 },
                                               { 80, 200 }, { 0, 200 } };
    memcpy(p.corner, corners, sizeof corners);
    p.corner_count = 6;
    p.east_m = 1000;
    p.velocity_north_mps = 2;
    p.time_s = 10;
    add(&d, p);
    assert_true(pel_areas_ok(&d));
    assert_float_equal(factor_at(&d, 1040, 160, 10), 0.5, 1e-12);
    assert_float_equal(factor_at(&d, 1160, 40, 10), 0.5, 1e-12);
    assert_true(factor_at(&d, 1140, 140, 10) == 1);
    assert_float_equal(factor_at(&d, 1200, 40, 10), 0.75, 1e-12);
    /* A minute later it is 120 m farther north. */
    assert_float_equal(factor_at(&d, 1040, 280, 70), 0.5, 1e-12);
    assert_true(factor_at(&d, 1160, 40, 70) == 1);
    /* Gusts over each other have a bound. */
    d.area_count = 0;
    add(&d, circle(1.8));
    add(&d, circle(1.8));
    assert_true(factor_at(&d, 0, 0, 0) == 2);
    d.area[0].factor = 2.1;
    assert_false(pel_areas_ok(&d));
}

static void its_slope_is_its_derivative(void **state)
{
    (void)state;
    struct pel_sea_desc d = described(PEL_SYNTHESISER_TROCHOIDS);
    struct pel_area_desc p = circle(0.5);
    static const struct pel_vec2 corners[] = { { 0, 0 },
                                               { 200, 0 },
                                               { 50, 150 } };
    memcpy(p.corner, corners, sizeof corners);
    p.corner_count = 3;
    add(&d, p);
    add(&d, circle(1.3));
    for (uint32_t i = 0; i < 2000; i++) {
        double x = 400 * pel_hash01(1, 1, i) - 200;
        double y = 400 * pel_hash01(1, 2, i) - 200, h = 1e-5;
        struct pel_vec2 slope;
        (void)pel_areas_factor(&d, x, y, 0, &slope);
        double dx = factor_at(&d, x + h, y, 0) - factor_at(&d, x - h, y, 0);
        double dy = factor_at(&d, x, y + h, 0) - factor_at(&d, x, y - h, 0);
        assert_float_equal(slope.x, dx / (2 * h), 1e-6);
        assert_float_equal(slope.y, dy / (2 * h), 1e-6);
    }
}

static void build(const struct pel_sea_desc *d, struct pel_sea *out)
{
    assert_int_equal(pel_sea_build(d, out), PEL_OK);
}

/* Far from all areas what is queried is what it is without. */
static void beside_them_nothing_changes(void **state)
{
    (void)state;
    for (int s = 0; s < 2; s++) {
        struct pel_sea_desc d = described((enum pel_synthesiser)s);
        struct pel_sea bare, with;
        build(&d, &bare);
        add(&d, circle(0.2));
        build(&d, &with);
        for (uint32_t i = 0; i < 300; i++) {
            struct pel_vec2 p = { 300 + 500 * pel_hash01(1, 1, i),
                                  500 * pel_hash01(1, 2, i) };
            struct pel_surface_sample a, b;
            pel_sea_query_moving(&bare, &p, 1, 33.3, &a);
            pel_sea_query_moving(&with, &p, 1, 33.3, &b);
            /* Where Newton's steps end, 1 µm, times slope and curvature. */
            assert_float_equal(a.height_m, b.height_m, 2e-6);
            /* Without areas tangents are those a last step of 0.1 mm ago. */
            assert_float_equal(a.normal.x, b.normal.x, 5e-3);
            assert_float_equal(a.velocity_mps.z, b.velocity_mps.z, 1e-4);
            assert_float_equal(a.acceleration_mps2.z, b.acceleration_mps2.z,
                               2e-3);
        }
        pel_sea_finish(&bare);
        pel_sea_finish(&with);
    }
}

/* Variance of queried slopes, from differences, over a square of 120 m. */
static double slopes_inside(const struct pel_sea *sea)
{
    const double h = 0.005;
    double sum = 0;
    for (uint32_t i = 0; i < 2500; i++) {
        double x = 120 * pel_hash01(3, 1, i) - 60;
        double y = 120 * pel_hash01(3, 2, i) - 60;
        const struct pel_vec2 p[3] = { { x, y }, { x + h, y }, { x, y + h } };
        struct pel_surface_sample q[3];
        pel_sea_query(sea, p, 3, 12.5, q);
        double sx = (q[1].height_m - q[0].height_m) / h;
        double sy = (q[2].height_m - q[0].height_m) / h;
        sum += sx * sx + sy * sy;
    }
    return sum / 2500;
}

/* In an area with a factor the short waves' part of the slopes is its square
 * times. */
static void slopes_follow_the_factor(void **state)
{
    (void)state;
    for (int s = 0; s < 2; s++) {
        double found[3];
        static const double factors[3] = { 0, 0.5, 1 };
        for (int i = 0; i < 3; i++) {
            struct pel_sea_desc d = described((enum pel_synthesiser)s);
            struct pel_sea sea;
            add(&d, circle(factors[i]));
            build(&d, &sea);
            found[i] = slopes_inside(&sea);
            pel_sea_finish(&sea);
        }
        double share = (found[1] - found[0]) / (found[2] - found[0]);
        print_message("slopes %.4f %.4f %.4f, share %.3f\n", found[0], found[1],
                      found[2], share);
        /* 2,500 places; crests and troughs of long waves press short ones. */
        assert_true(found[0] < 0.6 * found[2]);
        assert_float_equal(share, 0.25, 0.03);
    }
}

/* At an edge of the least width too. */
static void normals_are_the_heights_gradient(void **state)
{
    (void)state;
    for (int s = 0; s < 2; s++) {
        struct pel_sea_desc d = described((enum pel_synthesiser)s);
        struct pel_area_desc a = circle(0.1);
        a.edge_m = 1;
        add(&d, a);
        struct pel_sea sea;
        build(&d, &sea);
        double sum = 0;
        for (uint32_t i = 0; i < 400; i++) {
            double angle = 2 * PEL_PI * pel_hash01(4, 1, i), h = 1e-3;
            double r = 99.5 + pel_hash01(4, 2, i);
            double x = r * cos(angle), y = r * sin(angle);
            const struct pel_vec2 p[5] = {
                { x, y }, { x + h, y }, { x - h, y }, { x, y + h }, { x, y - h }
            };
            struct pel_surface_sample q[5];
            pel_sea_query(&sea, p, 5, 12.5, q);
            double sx = (q[1].height_m - q[2].height_m) / (2 * h);
            double sy = (q[3].height_m - q[4].height_m) / (2 * h);
            double ex = sx + q[0].normal.x / q[0].normal.z;
            double ey = sy + q[0].normal.y / q[0].normal.z;
            sum += (ex * ex + ey * ey) / 400;
        }
        print_message("off by %.4f rms\n", sqrt(sum));
        /* Differences over 2 mm of ripples of 2 cm. */
        assert_true(sqrt(sum) < 0.012);
        pel_sea_finish(&sea);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(circles_and_polygons),
        cmocka_unit_test(its_slope_is_its_derivative),
        cmocka_unit_test(beside_them_nothing_changes),
        cmocka_unit_test(slopes_follow_the_factor),
        cmocka_unit_test(normals_are_the_heights_gradient),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
