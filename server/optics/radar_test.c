/* The radar against its equation by hand, echoes in their cells, clutter
 * against the model that is cited, the same picture in any order. */
#include "optics/radar.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static void near(double got, double want, double off)
{
    if (!(fabs(got - want) <= off)) {
        fail_msg("%.9g is not %.9g ± %.2g", got, want, off);
    }
}

static const struct pel_radar set = { .range_m = 6 * 1852.0,
                                      .pulse_s = 0.3e-6,
                                      .beam_rad = 1.2 * PEL_DEG,
                                      .turn_s = 2.5,
                                      .height_m = 20,
                                      .wave_m = 1.0,
                                      .wind_to_rad = 0.7,
                                      .seed = 5 };

/* 10 kW, 29.9 dB, 3.2 cm, 5 dB over k T 1.2/τ, 4 dB lost: in decibels. */
static void a_target_is_seen_by_the_equation(void **state)
{
    (void)state;
    double gain = 10 * log10(26000 / (1.2 * 22));
    double noise = -203.975 + 10 * log10(1.2 / 0.3e-6) + 5;
    /* 13 dB over noise, 10 m², 40 m high: no reflection in the sea. */
    double db = 40 + 2 * gain + 20 * log10(0.032) + 10 -
                30 * log10(4 * PEL_PI) - noise - 3.98 - 13;
    double want = pow(10, db / 40);
    double low = 1000, high = 60000;
    for (int i = 0; i < 50; i++) {
        double middle = 0.5 * (low + high);
        bool found = pel_radar_echo(&set, middle, 10, 40) > pow(10, 1.3);
        low = found ? middle : low;
        high = found ? high : middle;
    }
    near(low / want, 1, 0.005);
    near(want / 1852, 6.5, 1.0);
    /* 2.2 nm times the roots of both heights (a mile of 1852 m: 1 %). */
    double reach = 1852 * 2.225 * (sqrt(20) + sqrt(4));
    assert_true(pel_radar_echo(&set, 0.99 * reach, 1e6, 4) > 0);
    assert_true(pel_radar_echo(&set, 1.01 * reach, 1e6, 4) == 0);
    /* Low over the sea the echo falls with the eighth power. */
    near(pel_radar_echo(&set, 1e4, 10, 0.5) /
             pel_radar_echo(&set, 2e4, 10, 0.5),
         256, 1e-6);
}

/* 5 mm/h at 3.2 cm: 0.08 dB/km each way. */
static void rain_takes_and_sends(void **state)
{
    (void)state;
    struct pel_radar wet = set;
    wet.rain_mm_h = 5;
    double db = 10 * log10(pel_radar_echo(&set, 10000, 10, 40) /
                           pel_radar_echo(&wet, 10000, 10, 40));
    near(db, 1.62, 0.1);
    /* Its volume grows with the range's square, the way takes 0.16 dB. */
    near(10 * log10(pel_radar_rain(&wet, 1000) / pel_radar_rain(&wet, 2000)),
         6.02 + 0.16, 0.05);
}

static void echoes_lie_in_their_cells(void **state)
{
    enum { NEAR = 25 }; /* cells; even a calm sea sends something there */
    (void)state;
    struct pel_radar_scan *scan;
    assert_int_equal(pel_radar_scan_create(450, &scan), PEL_OK);
    struct pel_radar calm = set;
    calm.wave_m = 0;
    double step = calm.range_m / scan->cells, time = 123.4;
    for (int k = 0; k < 40; k++) {
        struct pel_radar_point p = { .bearing_rad = 0.15 * k + 0.01,
                                     .range_m = 800 + 230 * k,
                                     .height_m = 20,
                                     .sigma = 1e5,
                                     .id = (uint32_t)k };
        pel_radar_passed(&calm, p.bearing_rad, time, &p.turn);
        pel_radar_fill(&calm, time, NULL, NULL, scan);
        pel_radar_add(&calm, time, &p, scan);
        double most = 0, sum = 0, x = 0, y = 0;
        int first = scan->cells;
        for (int i = 0; i < PEL_RADAR_BEARINGS * scan->cells; i++) {
            double v = (double)scan->power[i];
            most = i % scan->cells >= NEAR ? fmax(most, v) : most;
        }
        for (int i = 0; i < PEL_RADAR_BEARINGS * scan->cells; i++) {
            double v = (double)scan->power[i];
            double b =
                2 * PEL_PI * (i / scan->cells + 0.5) / PEL_RADAR_BEARINGS;
            if (v > 0.05 * most && i % scan->cells >= NEAR) {
                sum += v;
                x += v * sin(b);
                y += v * cos(b);
                int cell = i % scan->cells;
                first = cell < first ? cell : first;
            }
        }
        assert_true(most > 100 && sum > 0);
        near(remainder(atan2(x, y) - p.bearing_rad, 2 * PEL_PI), 0,
             0.5 * calm.beam_rad);
        near(first * step, p.range_m, 0.5 * 3e8 * calm.pulse_s);
    }
    pel_radar_scan_destroy(scan);
}

/* GIT as Horst, Dyer and Tuley 1978 have it, in decibels, for 3.2 cm. */
static double git_db(double grazing, double wave_m, double off)
{
    double a = (14.4 * 0.032 + 5.5) * grazing * wave_m / 0.032;
    double interference = -10 * log10(1 + pow(a, -4));
    double upwind =
        4.343 * 0.2 * cos(off) * (1 - 2.8 * grazing) * pow(0.047, -0.4);
    double v = 8.67 * pow(wave_m, 0.4);
    double q = 1.1 * pow(0.047, -0.4);
    double speed = 10 * q * log10(1.94 * v / (1 + v / 15.4));
    return 10 * log10(3.9e-6 * 0.032) + 4 * log10(grazing) + interference +
           upwind + speed;
}

/* A seeded stand-in for the sea's slopes, unit variance. */
static double slopes(void *user, double bearing, double range, int64_t turn)
{
    (void)user;
    (void)turn;
    return sqrt(2) * sin(range / 37 + 19 * sin(3 * bearing));
}

static void clutter_has_the_models_mean(void **state)
{
    (void)state;
    struct pel_radar_scan *scan;
    assert_int_equal(pel_radar_scan_create(450, &scan), PEL_OK);
    double step = set.range_m / scan->cells;
    for (int textured = 0; textured < 2; textured++) {
        for (int band = 10; band <= 110; band += 20) {
            double sum = 0, want = 0;
            int count = 0;
            for (int scans = 0; scans < 3; scans++) {
                pel_radar_fill(&set, 100 + 2.5 * scans,
                               textured ? slopes : NULL, NULL, scan);
                for (int i = 0; i < PEL_RADAR_BEARINGS; i++) {
                    for (int k = band; k < band + 8; k++) {
                        double range = step * (k + 0.5);
                        double bearing = 2 * PEL_PI * (i + 0.5) / 1024;
                        double grazing = asin(20 / range) - range / 17e6;
                        /* Wind from 0.7 rad + 180°, as a compass has it. */
                        double from = 1.5 * PEL_PI - 0.7;
                        double db = 40 + 2 * 10 * log10(26000 / 26.4) +
                                    20 * log10(0.032) - 30 * log10(4 * PEL_PI) +
                                    203.975 - 10 * log10(4e6) - 5 - 3.98 -
                                    40 * log10(range);
                        db += git_db(grazing, 1, bearing - from) +
                              10 * log10(range * 1.2 * PEL_DEG * 44.97);
                        want += pow(10, 0.1 * db);
                        sum += (double)scan->power[i * scan->cells + k] - 1;
                        count++;
                    }
                }
            }
            near(10 * log10(sum / want), 0, textured ? 2 : 0.7);
        }
    }
    pel_radar_scan_destroy(scan);
    /* Sea state 3 to 4, 1°: published measurements lie at -40 to -34 dB. */
    near(10 * log10(pel_radar_sea(&set, PEL_DEG, PEL_PI / 2)), -37, 4);
}

/* What a bearing shows does not depend on what was shown before, and stays
 * from one pass of the antenna to the next. */
static void bearings_are_of_their_pass(void **state)
{
    (void)state;
    struct pel_radar_scan *a, *b;
    assert_int_equal(pel_radar_scan_create(200, &a), PEL_OK);
    assert_int_equal(pel_radar_scan_create(200, &b), PEL_OK);
    pel_radar_fill(&set, 50.3, NULL, NULL, a);
    pel_radar_fill(&set, 900.1, NULL, NULL, b);
    pel_radar_fill(&set, 50.9, NULL, NULL, b);
    int same = 0;
    for (int i = 0; i < PEL_RADAR_BEARINGS; i++) {
        int64_t before, after;
        double bearing = 2 * PEL_PI * (i + 0.5) / PEL_RADAR_BEARINGS;
        double first = pel_radar_passed(&set, bearing, 50.3, &before);
        double then = pel_radar_passed(&set, bearing, 50.9, &after);
        assert_true(first <= 50.3 && first > 50.3 - 2.5);
        bool alike = memcmp(a->power + (size_t)i * 200,
                            b->power + (size_t)i * 200, 200 * 4) == 0;
        assert_true(alike == (then == first));
        same += alike;
    }
    near(same / (double)PEL_RADAR_BEARINGS, 1 - 0.6 / 2.5, 0.002);
    pel_radar_fill(&set, 50.3, NULL, NULL, b);
    assert_memory_equal(a->power, b->power, 200 * PEL_RADAR_BEARINGS * 4);
    pel_radar_scan_destroy(a);
    pel_radar_scan_destroy(b);
}

static double hill(void *user, double bearing, double range, int64_t turn)
{
    (void)user;
    (void)turn;
    (void)bearing;
    return range > 3000 && range < 3400 ? 60 : range > 5000 ? 10 : -20;
}

static void land_hides_what_is_behind(void **state)
{
    (void)state;
    struct pel_radar_scan *scan;
    assert_int_equal(pel_radar_scan_create(450, &scan), PEL_OK);
    pel_radar_fill(&set, 10, NULL, NULL, scan);
    struct pel_radar_point p = { 1.0, 4500, 10, 1e6, 3, 0 };
    pel_radar_passed(&set, 1.0, 10, &p.turn);
    pel_radar_add(&set, 10, &p, scan);
    pel_radar_add_land(&set, 10, hill, NULL, scan);
    double step = set.range_m / scan->cells, shore = 0, behind = 0;
    for (int i = 0; i < PEL_RADAR_BEARINGS; i++) {
        const float *row = scan->power + (size_t)i * 450;
        shore = fmax(shore, (double)row[(int)(3010 / step)]);
        for (int k = (int)(3500 / step); k < 450; k++) {
            behind = fmax(behind, (double)row[k]);
        }
    }
    assert_true(shore > 1000);
    assert_true(behind < 2);
    pel_radar_scan_destroy(scan);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_target_is_seen_by_the_equation),
        cmocka_unit_test(rain_takes_and_sends),
        cmocka_unit_test(echoes_lie_in_their_cells),
        cmocka_unit_test(clutter_has_the_models_mean),
        cmocka_unit_test(bearings_are_of_their_pass),
        cmocka_unit_test(land_hides_what_is_behind),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
