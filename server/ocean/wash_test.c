#include "ocean/wash.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "ocean/areas.h"
#include "ocean/foam.h"
#include "ocean/hash.h"
#include "ocean/restquery.h"

#define LENGTH 100.0
#define BEAM 15.0
#define DRAUGHT 5.0
#define SPEED 6.17
#define NOW 900.0

/* At time NOW amidships at the origin, heading north. */
static struct pel_wash_ship straight(double speed, double push)
{
    struct pel_wash_ship s = { LENGTH, BEAM, DRAUGHT, .count = 2 };
    pel_wash_waterline(&s);
    s.point[0] = (struct pel_wash_point){ 0, 0, -speed * NOW, 0, push };
    s.point[1] = (struct pel_wash_point){ NOW, 0, 0, 0, push };
    return s;
}

static struct pel_wash *wash_of(const struct pel_wash_ship *s, double time_s)
{
    struct pel_wash *w;
    assert_int_equal(pel_wash_create(&w), PEL_OK);
    assert_int_equal(pel_wash_add(w, s, time_s), PEL_OK);
    assert_int_equal(pel_wash_index(w), PEL_OK);
    return w;
}

/* Where the wake has lost half of what it has amid, over both sides, of ships
 * side by side, since edges bend by the place. */
static double width_at(double sailed)
{
    double sum = 0, y = -0.5 * LENGTH - sailed;
    const int ships = 60;
    for (int i = 0; i < ships; i++) {
        struct pel_wash_ship s = straight(SPEED, NAN);
        double x = 23.7 * i;
        s.point[0].x_m = s.point[1].x_m = x;
        struct pel_wash *w = wash_of(&s, NOW);
        for (int side = -1; side <= 1; side += 2) {
            double amid = 1 - pel_wash_at(w, x, y, 0).up, lo = 0, hi = 200;
            for (int k = 0; k < 40; k++) {
                double mid = 0.5 * (lo + hi);
                if (1 - pel_wash_at(w, x + side * mid, y, 0).up > 0.5 * amid) {
                    lo = mid;
                } else {
                    hi = mid;
                }
            }
            sum += lo / ships;
        }
        pel_wash_destroy(w);
    }
    return sum / 0.825; /* where the smooth edge is half */
}

static void widens_with_the_fifth_root(void **state)
{
    (void)state;
    double near = width_at(700), far = width_at(3500);
    double power = log(far / near) / log(3500.0 / 700.0);
    double four = width_at(4 * LENGTH);
    print_message("%.1f m at 700 m, %.1f m at 3500 m: power %.3f; %.1f m at "
                  "four lengths\n",
                  near, far, power, four);
    /* Sixty ships leave 1 % of the bends. */
    assert_float_equal(power, 0.2, 0.012);
    assert_float_equal(four, 4 * BEAM, 0.03 * 4 * BEAM);
}

/* The most of foam across the line, at a place along it. */
static double most_foam(const struct pel_wash *w, double y, double from)
{
    double most = 0;
    for (double x = from; x < 60; x += 0.1) {
        most = fmax(most, pel_wash_at(w, x, y, 0).foam);
    }
    return most;
}

static void foam_ages(void **state)
{
    (void)state;
    struct pel_wash_ship s = straight(SPEED, NAN);
    struct pel_wash *w = wash_of(&s, NOW);
    /* Beside the hull that of the bow, 6 and 9 s after the stem passed. */
    double young = most_foam(w, 0.5 * LENGTH - 6 * SPEED, 0);
    double old = most_foam(w, 0.5 * LENGTH - 9 * SPEED, 0);
    double life = 3 / log(young / old);
    print_message("bow: %.3f %.3f, e-fold %.2f s\n", young, old, life);
    assert_true(young > 0.1);
    /* Linear between nodes a seventh of their age apart; its front breaks on
     * for some 2 s, and still adds a little. */
    assert_float_equal(life, PEL_FOAM_LIFE_S, 0.06 * PEL_FOAM_LIFE_S);
    /* Astern, once the first has gone, what rises: draught over 0.25 m/s. */
    young = pel_wash_at(w, 0, -0.5 * LENGTH - 40 * SPEED, 0).foam;
    old = pel_wash_at(w, 0, -0.5 * LENGTH - 80 * SPEED, 0).foam;
    life = 40 / log(young / old);
    print_message("astern: %.3f %.3f, e-fold %.2f s\n", young, old, life);
    assert_float_equal(life, DRAUGHT / 0.25, 0.03 * DRAUGHT / 0.25);
    pel_wash_destroy(w);
}

/* Nothing breaks at a walking pace: no foam at the bow, little astern. */
static void slow_ships_are_quiet(void **state)
{
    (void)state;
    struct pel_wash_ship s = straight(1.2, NAN);
    struct pel_wash *w = wash_of(&s, NOW);
    assert_true(most_foam(w, 0.5 * LENGTH - 5, 0) < 1e-9);
    assert_true(most_foam(w, -0.5 * LENGTH - 5, 0) < 0.15);
    pel_wash_destroy(w);
    s = straight(0, NAN);
    w = wash_of(&s, NOW);
    for (double y = -200; y < 100; y += 5) {
        struct pel_washed at = pel_wash_at(w, 1, y, 0);
        assert_true(at.up == 1 && at.foam == 0 && at.bubbles == 0);
    }
    pel_wash_destroy(w);
}

/* A ship that lies still and turns its screw. */
static void the_screw_washes(void **state)
{
    (void)state;
    struct pel_wash_ship s = straight(0, 6);
    struct pel_wash *w = wash_of(&s, NOW);
    assert_true(pel_wash_at(w, 0, -0.5 * LENGTH - 15, 0).foam > 0.3);
    assert_true(most_foam(w, 0, 0) == 0); /* none beside the hull */
    pel_wash_destroy(w);
    s = straight(0, -6);
    w = wash_of(&s, NOW);
    assert_true(pel_wash_at(w, 0, -0.5 * LENGTH - 15, 0).foam == 0);
    for (int side = -1; side <= 1; side += 2) {
        double x = side * (0.5 * BEAM + 2);
        assert_true(pel_wash_at(w, x, -20, 0).foam > 0.1);
    }
    pel_wash_destroy(w);
    /* It began two seconds ago: the race has not come far. */
    s.point[0].time_s = NOW - 2;
    w = wash_of(&s, NOW);
    assert_true(most_foam(w, 0, 0) == 0);
    pel_wash_destroy(w);
}

/* The same water later: what a track has is the past's alone. */
static void only_the_past_counts(void **state)
{
    (void)state;
    struct pel_wash_ship a = straight(SPEED, NAN), b = a;
    /* As it is known at NOW, and at NOW before a turn. */
    b.point[2] = (struct pel_wash_point){ NOW + 60, 300, 100, 1.2, NAN };
    b.count = 2;
    struct pel_wash *one = wash_of(&a, NOW), *two = wash_of(&b, NOW);
    uint32_t *words[2];
    size_t count = pel_wash_words(one, 10, 20, NULL);
    assert_int_equal(count, pel_wash_words(two, 10, 20, NULL));
    words[0] = calloc(count, 4);
    words[1] = calloc(count, 4);
    pel_wash_words(one, 10, 20, words[0]);
    pel_wash_words(two, 10, 20, words[1]);
    assert_memory_equal(words[0], words[1], 4 * count);
    free(words[0]);
    free(words[1]);
    /* A point on the straight way changes nothing but nodes' places. */
    b.point[1] = (struct pel_wash_point){ 500, 0, -SPEED * 400, 0, NAN };
    b.point[2] = a.point[1];
    b.count = 3;
    pel_wash_destroy(two);
    two = wash_of(&b, NOW);
    for (uint32_t i = 0; i < 5000; i++) {
        double x = 60 * (pel_hash01(5, 1, i) - 0.5);
        double y = 60 - 5000 * pel_hash01(5, 2, i);
        struct pel_washed p = pel_wash_at(one, x, y, 0);
        struct pel_washed q = pel_wash_at(two, x, y, 0);
        assert_float_equal(p.up, q.up, 0.01);
        assert_float_equal(p.foam, q.foam, 0.01);
    }
    pel_wash_destroy(one);
    pel_wash_destroy(two);
}

/* The index finds what every piece together has. */
static void the_index_hides_nothing(void **state)
{
    (void)state;
    struct pel_wash_ship s = straight(SPEED, NAN);
    s.count = 0;
    for (int i = 0; i <= 90; i++) { /* two circles */
        double t = 10.0 * i, h = 4 * PEL_PI * i / 90;
        s.point[s.count++] = (struct pel_wash_point){ t, 442 * (1 - cos(h)),
                                                      442 * sin(h), h, NAN };
    }
    struct pel_wash *w = wash_of(&s, NOW);
    struct pel_wash whole = *w;
    uint32_t *all = calloc(w->count, sizeof *all), cell;
    size_t pieces = 0;
    for (size_t i = 0; i + 1 < w->count; i++) {
        if (!w->node[i + 1].begins) {
            all[pieces++] = (uint32_t)i;
        }
    }
    assert_true(pieces > 50 && pieces < 1024);
    cell = (uint32_t)pieces;
    whole.list = all;
    whole.cell = &cell;
    whole.columns = whole.rows = 1;
    whole.west_m = whole.south_m = -1e4;
    whole.cells_per_m = 1 / 2e4;
    for (uint32_t i = 0; i < 20000; i++) {
        double x = -200 + 1300 * pel_hash01(6, 1, i);
        double y = -650 + 1300 * pel_hash01(6, 2, i);
        double footprint = i % 3 * 4.0;
        struct pel_washed p = pel_wash_at(w, x, y, footprint);
        struct pel_washed q = pel_wash_at(&whole, x, y, footprint);
        assert_true(p.up == q.up && p.foam == q.foam);
        if (p.up != 1) {
            assert_true(pel_wash_near(w, x, y));
        }
    }
    free(all);
    pel_wash_destroy(w);
}

/* Means over footprints are those of points. */
static void footprints_keep_the_mean(void **state)
{
    (void)state;
    struct pel_wash_ship s = straight(SPEED, NAN);
    struct pel_wash *w = wash_of(&s, NOW);
    double sum[2] = { 0 }, foam[2] = { 0 };
    for (int i = 0; i < 40000; i++) {
        double x = 0.5 * (i % 400 - 200), y = -300.0 - 2 * (i / 400);
        for (int k = 0; k < 2; k++) {
            struct pel_washed at = pel_wash_at(w, x, y, 60.0 * k);
            sum[k] += 1 - at.up;
            foam[k] += at.foam;
        }
    }
    print_message("calm %.3f, foam %.3f of the points'\n", sum[1] / sum[0],
                  foam[1] / foam[0]);
    /* Bands do not overlap the same way once they are wider. */
    assert_float_equal(sum[1] / sum[0], 1, 0.05);
    assert_float_equal(foam[1] / foam[0], 1, 0.05);
    pel_wash_destroy(w);
}

/* Queried slopes in the wake and without one, at the same places. */
static void short_waves_are_lower(void **state)
{
    (void)state;
    for (int fft = 0; fft < 2; fft++) {
        struct pel_sea_desc d = { .wind_mps = 6,
                                  .kind = PEL_SPECTRUM_ELFOUHAILY,
                                  .fetch_m = 200000,
                                  .seed = 3,
                                  .wave_count = 60 };
        d.synthesiser = fft ? PEL_SYNTHESISER_FFT : PEL_SYNTHESISER_TROCHOIDS;
        struct pel_sea sea;
        assert_int_equal(pel_sea_build(&d, &sea), PEL_OK);
        struct pel_wash_ship s = straight(SPEED, NAN);
        struct pel_wash *w = wash_of(&s, NOW);
        double with = 0, without = 0;
        for (uint32_t i = 0; i < 2500; i++) {
            const struct pel_vec2 at = { 20 * (pel_hash01(7, 1, i) - 0.5),
                                         -900 - 20 * pel_hash01(7, 2, i) };
            struct pel_surface_sample a, b;
            pel_rest_query(&sea, &at, 1, NOW, false, w, &a);
            pel_sea_query(&sea, &at, 1, NOW, &b);
            with += (1 - a.normal.z * a.normal.z) / (a.normal.z * a.normal.z);
            without +=
                (1 - b.normal.z * b.normal.z) / (b.normal.z * b.normal.z);
        }
        double up = pel_wash_at(w, 0, -910, 0).up;
        print_message("slopes %.3f of the sea's, factor %.3f\n", with / without,
                      up);
        /* Waves that are shorter have up² of it, the others all. */
        assert_true(with < 0.9 * without);
        assert_true(with > up * up * without);
        pel_wash_destroy(w);
        pel_sea_finish(&sea);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(widens_with_the_fifth_root),
        cmocka_unit_test(foam_ages),
        cmocka_unit_test(slow_ships_are_quiet),
        cmocka_unit_test(the_screw_washes),
        cmocka_unit_test(only_the_past_counts),
        cmocka_unit_test(the_index_hides_nothing),
        cmocka_unit_test(footprints_keep_the_mean),
        cmocka_unit_test(short_waves_are_lower),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
