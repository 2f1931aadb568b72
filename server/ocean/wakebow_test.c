/* The raised crest of the bow wave: height and place as Noblesse et al. 2008
 * have them, only beside a bow that moves, and one with its own rate. */
#include "ocean/wakebow.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#define NOW 900.0
#define LONG_M 84.0
#define DRAUGHT 6.0

/* A wedge of this half angle to 14 m of beam that runs north, its stem at
 * (0, 42) at NOW; it stopped so long ago. */
static struct pel_wake *wake_of(double speed, double tan_alpha, bool raised,
                                double stopped_s, double later_s)
{
    static struct pel_wake_track t;
    memset(&t, 0, sizeof t);
    t.hull = (struct pel_hull){ LONG_M, 14, DRAUGHT, 0.5 };
    t.bow.stem_m = 0.5 * LONG_M;
    t.bow.long_m = raised ? LONG_M : 0;
    for (int i = 0; i < PEL_BOW_STATIONS; i++) {
        double aft = (i + 0.5) * LONG_M / PEL_BOW_STATIONS;
        t.bow.half_m[i] = fmin(aft * tan_alpha, 7);
    }
    double end = NOW - stopped_s;
    t.point[0] = (struct pel_wake_point){ 0, 0, -speed * end };
    t.point[1] = (struct pel_wake_point){ end, 0, 0 };
    t.count = 2;
    if (stopped_s > 0) {
        t.point[2] = (struct pel_wake_point){ end + 1e9, 0, 0 };
        t.count = 3;
    }
    struct pel_wake *w;
    assert_int_equal(pel_wake_create(&t, NOW + later_s, 0, &w), PEL_OK);
    return w;
}

static struct pel_wake_shift at(const struct pel_wake *w, double x, double y)
{
    struct pel_wake_shift s = { 0 };
    pel_wake_add(w, x, y, &s);
    return s;
}

/* Highest beside the hull, behind the stem by *aft. */
static double highest(const struct pel_wake *w, double tan_alpha, double *aft)
{
    double most = -9;
    for (double a = 0; a < 30; a += 0.1) {
        double h = at(w, a * tan_alpha, 0.5 * LONG_M - a).d.z;
        *aft = h > most ? a : *aft;
        most = fmax(most, h);
    }
    return most;
}

static void as_high_as_measured_bows(void **state)
{
    (void)state;
    for (int i = 0; i < 4; i++) {
        double u = 7 + i, tan_alpha = 0.25 + 0.02 * i, aft = 0, was = 0;
        double alpha = atan(tan_alpha), fd = u / sqrt(9.81 * DRAUGHT);
        double want = 2.2 * u * u / 9.81 * tan_alpha / cos(alpha) / (1 + fd);
        double place = 1.1 * u * u / 9.81 / (1 + fd);
        struct pel_wake *w = wake_of(u, tan_alpha, true, 0, 0);
        struct pel_wake *thin = wake_of(u, tan_alpha, false, 0, 0);
        double high = highest(w, tan_alpha, &aft);
        print_message("%.0f m/s: %.2f m high, of %.2f (thin ship %.2f), %.1f m "
                      "behind the stem, of %.1f\n",
                      u, high, want, highest(thin, tan_alpha, &was), aft,
                      place);
        /* The formula fits its measurements within some 10 %; the tile's texel
         * is 1 m, and the thin ship's own crest lies behind. */
        assert_float_equal(high, want, 0.12 * want);
        assert_float_equal(aft, place, 1.5);
        pel_wake_destroy(w);
        pel_wake_destroy(thin);
    }
}

static void only_beside_the_bow(void **state)
{
    (void)state;
    struct pel_wake *w = wake_of(9, 0.3, true, 0, 0);
    struct pel_wake *thin = wake_of(9, 0.3, false, 0, 0);
    for (int i = 0; i < 4000; i++) {
        double x = -100 + 5 * (i % 40), y = -300 + 4 * (i / 40);
        if (fabs(x) > 25 || fabs(y - 40) > 35) {
            assert_true(at(w, x, y).d.z == at(thin, x, y).d.z);
        }
    }
    pel_wake_destroy(w);
    pel_wake_destroy(thin);
    /* A ship that has stopped, three seconds ago: none. */
    w = wake_of(9, 0.3, true, 3, 0);
    thin = wake_of(9, 0.3, false, 3, 0);
    for (double y = 20; y < 60; y += 0.5) {
        assert_true(at(w, 2, y).d.z == at(thin, 2, y).d.z);
    }
    pel_wake_destroy(w);
    pel_wake_destroy(thin);
}

/* What is raised moves as its rate says: height at moments before and after. */
static void moves_with_its_rate(void **state)
{
    (void)state;
    const double step = 0.02;
    struct pel_wake *w[2][3];
    for (int raised = 0; raised < 2; raised++) {
        for (int k = 0; k < 3; k++) {
            w[raised][k] = wake_of(8, 0.3, raised, 0, (k - 1) * step);
        }
    }
    double square = 0, off = 0;
    for (double y = 25; y < 50; y += 0.37) {
        double high[2];
        for (int k = 0; k < 2; k++) {
            high[k] = at(w[1][2 * k], 3, y).d.z - at(w[0][2 * k], 3, y).d.z;
        }
        double want = (high[1] - high[0]) / (2 * step);
        double rate = at(w[1][1], 3, y).rise_mps - at(w[0][1], 3, y).rise_mps;
        square += want * want;
        off += (rate - want) * (rate - want);
    }
    print_message("rate off by %.3f rms of its own\n", sqrt(off / square));
    /* A ridge of some texels, which move under it. */
    assert_true(off < 0.08 * 0.08 * square);
    for (int i = 0; i < 6; i++) {
        pel_wake_destroy(w[i / 3][i % 3]);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(as_high_as_measured_bows),
        cmocka_unit_test(only_beside_the_bow),
        cmocka_unit_test(moves_with_its_rate),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
