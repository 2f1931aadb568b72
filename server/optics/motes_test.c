/* Particles in the water: as many as their law says, one and the same wherever
 * the eye stands, sinking and drifting. */
#include "optics/motes.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

static struct pel_mote motes[PEL_MOTE_MOST];

static struct pel_mote_view level_view(void)
{
    return (struct pel_mote_view){
        .eye = { 3.0, 5.0, -8.0 },
        .world_from_camera = { { 1, 0, 0 }, { 0, 0, 1 }, { 0, -1, 0 } },
        .tan_left = -0.6,
        .tan_right = 0.6,
        .tan_bottom = -0.4,
        .tan_top = 0.4,
        .pixel_rad = 2e-3,
        .extinction = 0.1,
        .seed = 3,
    };
}

/* Those nearer than so far ahead that are larger than d, against the law's
 * number in that pyramid. */
static void as_many_as_the_law_says(void **state)
{
    (void)state;
    const struct pel_mote_water water = { 1500, 4, 8e-3 };
    static const double least_m[] = { 0.5e-3, 1e-3, 2e-3 };
    static const double ahead_m[] = { 0.7, 1.4, 2.8 };
    for (int k = 0; k < 3; k++) {
        double found = 0, wanted = 0;
        for (uint32_t seed = 1; seed <= 20; seed++) {
            struct pel_mote_view v = level_view();
            v.seed = seed;
            assert_true(pel_mote_reach(&water, &v) * least_m[k] >
                        ahead_m[k] * sqrt(1 + 0.36 + 0.16));
            size_t n = pel_motes_seen(&water, &v, motes, PEL_MOTE_MOST);
            for (size_t i = 0; i < n; i++) {
                const float *p = motes[i].from;
                found += motes[i].diameter_m > (float)least_m[k] &&
                         p[1] < (float)ahead_m[k] &&
                         fabsf(p[0]) < 0.6F * p[1] && fabsf(p[2]) < 0.4F * p[1];
            }
            wanted +=
                1500 * pow(least_m[k] / 0.5e-3, -3) * 0.32 * pow(ahead_m[k], 3);
        }
        print_message("larger than %.1f mm, %.1f m: %.0f, by the law %.0f\n",
                      1e3 * least_m[k], ahead_m[k], found, wanted);
        /* The law is cut at the largest, (1/16)³; three deviations. */
        assert_true(fabs(found - wanted) < 3 * sqrt(wanted) + 0.02 * wanted);
    }
}

/* Of a picture taken beside, what both see is the same, and a later one shows
 * each lower, and downwind. */
static void one_sea_of_them(void **state)
{
    (void)state;
    const struct pel_mote_water water = { 1000, 4, 8e-3 };
    struct pel_mote_view v = level_view(), beside = v, later = v;
    beside.eye.x += 0.25;
    later.time_s = 2.0;
    static struct pel_mote other[PEL_MOTE_MOST];
    size_t n = pel_motes_seen(&water, &v, motes, PEL_MOTE_MOST),
           same[2] = { 0 };
    for (int k = 0; k < 2; k++) {
        size_t m =
            pel_motes_seen(&water, k ? &later : &beside, other, PEL_MOTE_MOST);
        for (size_t i = 0; i < n; i++) {
            double octave = ldexp(PEL_MOTE_LEAST_M,
                                  (int)floor(log2((double)motes[i].diameter_m /
                                                  PEL_MOTE_LEAST_M)));
            double last = fmin(2 * octave, 8e-3);
            double shift[3] = { k ? 0.04 : -0.25, 0,
                                k ? -2 * pel_mote_sinks(sqrt(octave * last))
                                  : 0 };
            for (size_t j = 0; j < m; j++) {
                double off = 0;
                for (int a = 0; a < 3; a++) {
                    off += fabs((double)(other[j].from[a] - motes[i].from[a]) -
                                shift[a]);
                }
                same[k] +=
                    motes[i].diameter_m == other[j].diameter_m && off < 1e-5;
            }
        }
    }
    print_message("of %zu seen, %zu from beside, %zu later\n", n, same[0],
                  same[1]);
    assert_true(same[0] > n / 2 && same[1] > 9 * n / 10);
}

/* Waves that may bring particles from outside make the list longer, and large
 * numbers are met by drawing them less far. */
static void never_too_many(void **state)
{
    (void)state;
    const struct pel_mote_water water = { 50000, 2.5, 30e-3 };
    struct pel_mote_view v = level_view();
    v.sways_m = 0.7;
    size_t n = pel_motes_seen(&water, &v, motes, PEL_MOTE_MOST);
    print_message("%zu, up to %.0f diameters away\n", n,
                  pel_mote_reach(&water, &v));
    assert_true(n > 0 && n < PEL_MOTE_MOST);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(as_many_as_the_law_says),
        cmocka_unit_test(one_sea_of_them),
        cmocka_unit_test(never_too_many),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
