/* The bow wave against measurements and against its own physics, and the foam
 * that the wash makes of it. */
#include "ocean/bowwave.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "ocean/foam.h"
#include "ocean/wash.h"

#define G 9.81
#define DEGREE 0.017453292519943295
#define NOW 900.0

/* Towed flat plates, D = 0.2 m, U = 1.75 m/s (Delhommeau, Guilbaud, David, Yang
 * and Noblesse 2009): at yaw of 10 to 20° a steady sheet that overturns, at 30
 * to 90° unsteady; the boundary between. */
static void regimes_as_measured(void **state)
{
    (void)state;
    static const double steady[] = { 10, 15, 20 };
    static const double unsteady[] = { 30, 45, 60, 75 };
    for (size_t i = 0; i < 3; i++) {
        assert_true(pel_bow_wave_of(1.75, 0.2, steady[i] * DEGREE).excess < 1);
    }
    for (size_t i = 0; i < 4; i++) {
        assert_true(pel_bow_wave_of(1.75, 0.2, unsteady[i] * DEGREE).excess >
                    1);
    }
    double lo = 20, hi = 30;
    for (int i = 0; i < 40; i++) {
        double mid = 0.5 * (lo + hi);
        bool wild = pel_bow_wave_of(1.75, 0.2, mid * DEGREE).excess > 1;
        *(wild ? &hi : &lo) = mid;
    }
    /* Their F_D = 4.4 tan α/cos α − 1, at α solved for 1.2494. */
    print_message("boundary at %.2f degrees of yaw\n", lo);
    double s = 2.2494 / 4.4, sine = (sqrt(1 + 4 * s * s) - 1) / (2 * s);
    assert_float_equal(lo, asin(sine) / DEGREE, 0.01);
    /* Whatever the speed a bow finer than about 25° in all is steady. */
    for (double u = 0.5; u < 20; u += 0.5) {
        assert_true(pel_bow_wave_of(u, 8, 12.3 * DEGREE).excess < 1);
    }
    assert_true(pel_bow_wave_of(0.05, 8, 12.9 * DEGREE).excess > 1);
}

/* Limits that need no fit: of deep hulls Z over U²/g tan α and X over U²/g are
 * numbers; of shallow ones Z goes as U √D; none is above Bernoulli's height. */
static void height_and_place(void **state)
{
    (void)state;
    const double u = 6, d = 1e6, a = 10 * DEGREE;
    struct pel_bow_wave deep = pel_bow_wave_of(u, d, a);
    double head = u * u / G, f = u / sqrt(G * d);
    assert_float_equal(deep.height_m * (1 + f) / head,
                       2.2 * sin(a) / (cos(a) * cos(a)), 1e-9);
    assert_float_equal(deep.crest_m * (1 + f) / head, 1.1, 1e-9);
    double shallow[2];
    for (int i = 0; i < 2; i++) {
        shallow[i] = pel_bow_wave_of(2000.0 * (i + 1), 0.01, a).height_m;
    }
    assert_float_equal(shallow[1] / shallow[0], 2, 0.01);
    for (int i = 1; i < 200; i++) {
        double v = 0.1 * i, alpha = 7.5 * (i % 10) * DEGREE;
        struct pel_bow_wave w = pel_bow_wave_of(v, 3, alpha);
        assert_true(w.height_m <= 0.5 * v * v / G + 1e-12);
        assert_true(w.breaks >= 0 && w.breaks <= 1);
        assert_true((w.excess >= 1) == (w.height_m >= 0.5 * v * v / G - 1e-12));
    }
    struct pel_bow_wave none = pel_bow_wave_of(0, 3, 0.5);
    assert_true(none.height_m == 0 && none.breaks == 0 && none.crest_m == 0);
    none = pel_bow_wave_of(-4, 3, 0.5);
    assert_true(none.height_m == 0 && none.breaks == 0);
}

/* Stokes's wave of greatest height has kA = 0.443: as a crest whose half length
 * is from the stem to as far behind the crest, fine bows never get there. */
static void fine_bows_do_not_break(void **state)
{
    (void)state;
    for (double u = 0.5; u < 25; u += 0.5) {
        assert_true(pel_bow_wave_of(u, 4, 7.9 * DEGREE).breaks == 0);
        assert_true(u < 4 || pel_bow_wave_of(u, 4, 14 * DEGREE).breaks > 0);
        assert_true(u > 1.5 || pel_bow_wave_of(u, 4, 1.0).breaks == 0);
    }
}

/* A wedge of half angle alpha, sailing north. */
static struct pel_wash *wash_of(double speed, double alpha, double stopped_s)
{
    struct pel_wash_ship s = { 120,           0, 6, .count = 2, .stem_m = 60,
                               .stern_m = -60 };
    for (int i = 0; i < PEL_WASH_STATIONS; i++) {
        s.half_m[i] = fmin((i + 0.5) * 5 * tan(alpha), 9);
        s.beam_m = fmax(s.beam_m, 2 * s.half_m[i]);
    }
    double way = speed * (NOW - stopped_s);
    s.point[0] = (struct pel_wash_point){ 0, 0, -way, 0, NAN };
    s.point[1] = (struct pel_wash_point){ NOW - stopped_s, 0, 0, 0, 0 };
    if (stopped_s > 0) {
        s.point[2] = (struct pel_wash_point){ NOW, 0, 0, 0, 0 };
        s.count = 3;
    }
    struct pel_wash *w;
    assert_int_equal(pel_wash_create(&w), PEL_OK);
    assert_int_equal(pel_wash_add(w, &s, NOW), PEL_OK);
    assert_int_equal(pel_wash_index(w), PEL_OK);
    return w;
}

/* The most foam of a place aft of the stem, and how far out it is, of both
 * sides. */
static double most_at(const struct pel_wash *w, double aft, double *out_m)
{
    double most = 0;
    for (int i = -300; i <= 300; i++) {
        double foam = pel_wash_at(w, 0.2 * i, 60 - aft, 0).foam;
        if (foam > most) {
            most = foam;
            *out_m = fabs(0.2 * i);
        }
    }
    return most;
}

static void foam_of_a_bow(void **state)
{
    (void)state;
    double out[4], foam[4];
    static const double aft[] = { 1, 15, 40, 80 };
    struct pel_wash *w = wash_of(10, 16 * DEGREE, 0);
    for (int i = 0; i < 4; i++) {
        foam[i] = most_at(w, aft[i], &out[i]);
        print_message("%g m aft of the stem: foam %.2f, %.1f m out\n", aft[i],
                      foam[i], out[i]);
    }
    /* A steady sheet climbs the stem clean, falls behind the crest, goes out
     * beside the hull (9 m) and leaves older foam. */
    assert_true(foam[0] < 0.1 && foam[1] > 0.6);
    double t = 2 * 3.14159265 * sqrt(2.9 / G); /* its wave is 2.9 m high */
    double gone = 10 * 0.265 * t * (1 - exp(-4 / t));
    assert_true(out[2] > 9 + gone && out[3] > out[2]);
    assert_true(foam[2] > foam[3] && foam[3] > 0.05);
    assert_true(most_at(w, -1.5, out) == 0);
    pel_wash_destroy(w);
    /* A blunt one breaks before the stem, and round it. */
    w = wash_of(7, 60 * DEGREE, 0);
    assert_true(most_at(w, -1.5, out) > 0.5);
    assert_true(most_at(w, -5, out) == 0);
    assert_true(most_at(w, 1, out) > 0.5);
    pel_wash_destroy(w);
    w = wash_of(10, 7 * DEGREE, 0);
    for (double y = 0; y < 100; y += 5) {
        assert_true(most_at(w, y, out) == 0);
    }
    pel_wash_destroy(w);
}

/* The engine stopped: what was foam at the bow ages, and no more comes. */
static void a_stopped_ship_has_none(void **state)
{
    (void)state;
    double at, foam[3];
    static const double ago[] = { 0, 10, 40 };
    for (int i = 0; i < 3; i++) {
        struct pel_wash *w = wash_of(10, 16 * DEGREE, ago[i]);
        foam[i] = 0;
        for (double aft = -5; aft < 30; aft += 2) {
            foam[i] = fmax(foam[i], most_at(w, aft, &at));
        }
        print_message("%g s after: %.3f\n", ago[i], foam[i]);
        pel_wash_destroy(w);
    }
    assert_true(foam[0] > 0.6 && foam[1] < 0.5 * foam[0] && foam[2] < 0.1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(regimes_as_measured),
        cmocka_unit_test(height_and_place),
        cmocka_unit_test(fine_bows_do_not_break),
        cmocka_unit_test(foam_of_a_bow),
        cmocka_unit_test(a_stopped_ship_has_none),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
