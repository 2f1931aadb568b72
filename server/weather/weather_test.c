/* The field of weather: what is between nodes and times, over the date line and
 * the poles, at coasts, beyond the ends; and what is no field. */
#include "weather/weather.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* after those */
#include <cmocka.h>

#include "base/vec.h"
#include "weather/wire.h"

#define MOST (73 * 37 * 3)

/* A grid with room for its numbers. */
struct made {
    struct pel_weather_grid grid;
    double unix_s[3];
    int16_t values[PEL_WEATHER_NUMBERS][MOST];
};

/* A number at a place (degrees) and time. */
typedef double number_at(double latitude, double longitude, double unix_s);

static struct made *make(int columns, int rows, double west, double south,
                         double step)
{
    struct made *m = calloc(1, sizeof *m);
    assert_non_null(m);
    m->grid = (struct pel_weather_grid){ .columns = columns,
                                         .rows = rows,
                                         .times = 3,
                                         .west_deg = west,
                                         .south_deg = south,
                                         .east_step = step,
                                         .north_step = step,
                                         .unix_s = m->unix_s };
    for (int t = 0; t < 3; t++) {
        m->unix_s[t] = 1e9 + 3600 * t * t;
    }
    return m;
}

static void give(struct made *m, enum pel_weather_number n, number_at *of)
{
    struct pel_weather_grid *g = &m->grid;
    g->values[n] = m->values[n];
    for (int i = 0; i < g->columns * g->rows * g->times; i++) {
        int c = i % g->columns, r = i / g->columns % g->rows;
        m->values[n][i] =
            pel_weather_quantise(n, of(g->south_deg + r * g->north_step,
                                       g->west_deg + c * g->east_step,
                                       m->unix_s[i / g->columns / g->rows]));
    }
}

static const struct pel_weather *field_of(struct made *m)
{
    const struct pel_weather *w;
    struct pel_fault fault;
    assert_int_equal(pel_weather_create(&m->grid, &w, &fault), PEL_OK);
    free(m);
    return w;
}

static struct pel_weather_now ask(const struct pel_weather *w, double latitude,
                                  double longitude, double unix_s)
{
    struct pel_weather_now now;
    pel_weather_at(w, latitude * PEL_DEG, longitude * PEL_DEG, unix_s, &now);
    return now;
}

static double ramp(double latitude, double longitude, double unix_s)
{
    return 0.1 * latitude + 0.05 * longitude + (unix_s - 1e9) / 3600;
}

static double none(double latitude, double longitude, double unix_s)
{
    (void)latitude;
    (void)longitude;
    (void)unix_s;
    return 0;
}

static double two(double latitude, double longitude, double unix_s)
{
    (void)latitude;
    (void)longitude;
    (void)unix_s;
    return 2;
}

/* Within half a quantum of what is linear in place and time. */
static void test_between(void **state)
{
    (void)state;
    struct made *m = make(21, 11, 10, 40, 1);
    give(m, PEL_WEATHER_WIND_EAST, ramp);
    give(m, PEL_WEATHER_WIND_NORTH, none);
    const struct pel_weather *w = field_of(m);
    for (int i = 0; i < 500; i++) {
        double latitude = 40 + fmod(i * 0.618, 10),
               longitude = 10 + fmod(i * 1.37, 20);
        double at = 1e9 + 36 * fmod(i * 7.1, 100);
        struct pel_weather_now now = ask(w, latitude, longitude, at);
        assert_float_equal(now.wind_east_mps, ramp(latitude, longitude, at),
                           0.51 / 256);
        assert_int_equal(now.place, PEL_WEATHER_INSIDE);
        assert_true(now.wind_known);
        assert_true(now.height_m < 0);
    }
    /* Any turn of the longitude; held before, after and beside. */
    assert_float_equal(ask(w, 45, 15.5 - 720, 1e9).wind_east_mps,
                       ask(w, 45, 15.5, 1e9).wind_east_mps, 1e-9);
    assert_int_equal(ask(w, 45, 15, 1e9 - 1).place, PEL_WEATHER_BEFORE);
    assert_float_equal(ask(w, 45, 15, 0).wind_east_mps,
                       ask(w, 45, 15, 1e9).wind_east_mps, 1e-12);
    assert_int_equal(ask(w, 45, 15, 1e9 + 14401).place, PEL_WEATHER_AFTER);
    assert_float_equal(ask(w, 45, 15, 2e9).wind_east_mps,
                       ask(w, 45, 15, 1e9 + 14400).wind_east_mps, 1e-12);
    assert_int_equal(ask(w, 39, 15, 1e9).place, PEL_WEATHER_OUTSIDE);
    assert_int_equal(ask(w, 45, 31, 1e9).place, PEL_WEATHER_OUTSIDE);
    assert_float_equal(ask(w, 45, 31, 1e9).wind_east_mps,
                       ask(w, 45, 30, 1e9).wind_east_mps, 1e-9);
    assert_float_equal(ask(w, 45, 0, 1e9).wind_east_mps,
                       ask(w, 45, 10, 1e9).wind_east_mps, 1e-9);
    pel_weather_unref(w);
}

/* A wind that is the same everywhere in space, in the plane of the equator, and
 * waves that go with it: smooth over poles and date line. */
static double plane_east(double latitude, double longitude, double unix_s)
{
    (void)latitude;
    (void)unix_s;
    return -10 * sin(longitude * PEL_DEG);
}

static double plane_north(double latitude, double longitude, double unix_s)
{
    (void)unix_s;
    return -10 * sin(latitude * PEL_DEG) * cos(longitude * PEL_DEG);
}

static double plane_way(double latitude, double longitude, double unix_s)
{
    return atan2(plane_north(latitude, longitude, unix_s),
                 plane_east(latitude, longitude, unix_s));
}

static double eight(double latitude, double longitude, double unix_s)
{
    return 4 * two(latitude, longitude, unix_s);
}

static const struct pel_weather *around(double west, int columns, bool poles)
{
    struct made *m = poles ? make(columns, 37, west, -90, 5)
                           : make(columns, 36, west, -87.5, 5);
    give(m, PEL_WEATHER_WIND_EAST, plane_east);
    give(m, PEL_WEATHER_WIND_NORTH, plane_north);
    give(m, PEL_WEATHER_HEIGHT, two);
    give(m, PEL_WEATHER_PERIOD, eight);
    give(m, PEL_WEATHER_DIRECTION, plane_way);
    return field_of(m);
}

/* The wind in axes of space: x towards 0° E, y 90° E, z the pole. */
static struct pel_vec3 in_space(const struct pel_weather_now *now,
                                double latitude, double longitude)
{
    double a = longitude * PEL_DEG, b = latitude * PEL_DEG;
    struct pel_vec3 east = { -sin(a), cos(a), 0 };
    struct pel_vec3 north = { -sin(b) * cos(a), -sin(b) * sin(a), cos(b) };
    return pel_vec3_add(pel_vec3_scale(east, now->wind_east_mps),
                        pel_vec3_scale(north, now->wind_north_mps));
}

static void test_around(void **state)
{
    (void)state;
    const struct pel_weather *fields[] = { around(-180, 72, true),
                                           around(0, 72, false),
                                           around(0, 73, true),
                                           around(-177.5, 72, false) };
    for (int k = 0; k < 4; k++) {
        const struct pel_weather *w = fields[k];
        assert_true(w->around);
        assert_int_equal(w->columns, 72);
        assert_float_equal(w->latitude_deg[0], -90, 1e-9);
        assert_float_equal(w->latitude_deg[w->rows - 1], 90, 1e-9);
        /* Over the date line and over both poles, in steps of 0.01°. */
        for (int path = 0; path < 3; path++) {
            struct pel_vec3 last = { 0 };
            for (int i = -600; i <= 600; i++) {
                double latitude = path == 0 ? 30 : 90 - 0.01 * abs(i);
                double longitude = path == 0 ? 180 + 0.01 * i
                                   : i < 0   ? 37
                                             : 217;
                latitude = path == 2 ? -latitude : latitude;
                struct pel_weather_now now =
                    ask(w, latitude, longitude, 1e9 + 500);
                struct pel_vec3 v = in_space(&now, latitude, longitude);
                assert_int_equal(now.place, PEL_WEATHER_INSIDE);
                /* The field turns by 5° a node: 10 (1 − cos 2.5°) = 0.01 m/s
                 * of chords for arcs, twice where latitudes do too; and at a
                 * pole a ring's mean for a point. */
                assert_true(i == -600 ||
                            hypot(hypot(v.x - last.x, v.y - last.y),
                                  v.z - last.z) < 0.012);
                last = v;
                assert_float_equal(now.height_m, 2, 1e-3);
                assert_float_equal(now.period_s, 8, 1e-3);
                if (path == 0) {
                    double way = plane_way(latitude, longitude, 0);
                    assert_float_equal(
                        remainder(now.direction_rad - way, 2 * PEL_PI), 0,
                        5e-3);
                    /* Nodes differ by up to 10°: cos 5°. */
                    assert_true(now.agreement > 0.99);
                }
            }
        }
        pel_weather_unref(w);
    }
}

/* Land: the neighbourhood's, and said. */
static void test_land(void **state)
{
    (void)state;
    struct made *m = make(21, 11, 0, 0, 1);
    give(m, PEL_WEATHER_WIND_EAST, ramp);
    give(m, PEL_WEATHER_WIND_NORTH, none);
    give(m, PEL_WEATHER_HEIGHT, two);
    give(m, PEL_WEATHER_PERIOD, eight);
    give(m, PEL_WEATHER_DIRECTION, none);
    for (int i = 0; i < 21 * 11 * 3; i++) {
        if (i % 21 > 10) {
            m->values[PEL_WEATHER_HEIGHT][i] = PEL_WEATHER_NONE;
        }
    }
    const struct pel_weather *w = field_of(m);
    assert_true(ask(w, 5, 10.4, 1e9).waves_known);
    assert_false(ask(w, 5, 10.6, 1e9).waves_known);
    assert_true(ask(w, 5, 10.6, 1e9).wind_known);
    assert_float_equal(ask(w, 5, 18, 1e9).height_m, 2, 1e-3);
    pel_weather_unref(w);
}

/* Heights linear; where a calm meets waves the direction is the waves'. */
static double half_height(double latitude, double longitude, double unix_s)
{
    (void)latitude;
    (void)unix_s;
    return longitude < 10.5 ? 0 : 4;
}

static double half_way(double latitude, double longitude, double unix_s)
{
    (void)latitude;
    (void)unix_s;
    return longitude < 10.5 ? 3 : 0.25;
}

static void test_weighted(void **state)
{
    (void)state;
    struct made *m = make(21, 11, 0, 0, 1);
    give(m, PEL_WEATHER_WIND_EAST, none);
    give(m, PEL_WEATHER_WIND_NORTH, none);
    give(m, PEL_WEATHER_HEIGHT, half_height);
    give(m, PEL_WEATHER_PERIOD, eight);
    give(m, PEL_WEATHER_DIRECTION, half_way);
    give(m, PEL_WEATHER_WIND_HEIGHT, none);
    give(m, PEL_WEATHER_SWELL_PERIOD, eight);
    give(m, PEL_WEATHER_SWELL_DIRECTION, half_way);
    const struct pel_weather *w = field_of(m);
    struct pel_weather_now now = ask(w, 5, 10.25, 1e9);
    assert_float_equal(now.height_m, 1, 1e-3);
    assert_float_equal(now.direction_rad, 0.25, 1e-3);
    assert_true(now.agreement > 0.999);
    assert_true(now.parts);
    assert_float_equal(now.swell_direction_rad, 0.25, 1e-3);
    pel_weather_unref(w);
}

static void refused(struct made *m, enum pel_err err, const char *words)
{
    const struct pel_weather *w;
    struct pel_fault fault = { 0 };
    assert_int_equal(pel_weather_create(&m->grid, &w, &fault), err);
    if (!strstr(fault.message, words)) {
        fail_msg("%s, not %s", fault.message, words);
    }
    free(m);
}

static struct made *plain(void)
{
    struct made *m = make(21, 11, 0, 0, 1);
    give(m, PEL_WEATHER_WIND_EAST, ramp);
    give(m, PEL_WEATHER_WIND_NORTH, none);
    return m;
}

static void test_refusals(void **state)
{
    (void)state;
    struct made *m = plain();
    m->grid.values[PEL_WEATHER_WIND_NORTH] = NULL;
    refused(m, PEL_ERR_INVALID, "no wind");
    m = plain();
    give(m, PEL_WEATHER_HEIGHT, two);
    refused(m, PEL_ERR_INVALID, "go together");
    m = plain();
    m->grid.times = 0;
    refused(m, PEL_ERR_OUT_OF_RANGE, "0 times");
    m = plain();
    m->grid.columns = PEL_WEATHER_MOST_COLUMNS + 1;
    refused(m, PEL_ERR_OUT_OF_RANGE, "7201");
    m = plain();
    m->grid.columns = m->grid.rows = 3601;
    m->grid.times = 100;
    refused(m, PEL_ERR_OUT_OF_RANGE, "coarser");
    m = plain();
    m->grid.east_step = 11;
    refused(m, PEL_ERR_OUT_OF_RANGE, "apart");
    m = plain();
    m->grid.south_deg = 85;
    refused(m, PEL_ERR_OUT_OF_RANGE, "not degrees");
    m = plain();
    m->unix_s[1] = m->unix_s[0];
    refused(m, PEL_ERR_OUT_OF_RANGE, "rise");
    m = plain();
    m->unix_s[2] = NAN;
    refused(m, PEL_ERR_OUT_OF_RANGE, "rise");
    m = plain();
    for (int i = 21 * 11; i < 2 * 21 * 11; i++) {
        m->values[PEL_WEATHER_WIND_EAST][i] = PEL_WEATHER_NONE;
    }
    refused(m, PEL_ERR_INVALID, "number 2 of 3 has no wind");
}

static double slope(double latitude, double longitude, double unix_s)
{
    (void)unix_s;
    return 2 + 0.05 * latitude + 0.03 * longitude;
}

static double steady(double latitude, double longitude, double unix_s)
{
    (void)latitude;
    (void)longitude;
    (void)unix_s;
    return 0.5;
}

/* Waves on a grid and at times of their own, which lies within the wind's. */
static struct made *waves_apart(void)
{
    struct made *m = make(9, 5, 2, 3, 0.5);
    give(m, PEL_WEATHER_HEIGHT, slope);
    give(m, PEL_WEATHER_PERIOD, slope);
    give(m, PEL_WEATHER_DIRECTION, steady);
    m->unix_s[0] -= 5000;
    return m;
}

static void test_two_grids(void **state)
{
    (void)state;
    struct made *wind = plain(), *waves = waves_apart();
    wind->grid.waves = &waves->grid;
    wind->grid.notes = "as it is";
    const struct pel_weather *alone, *w;
    struct pel_fault fault;
    assert_int_equal(pel_weather_create(&wind->grid, &w, &fault), PEL_OK);
    assert_string_equal(w->notes, "as it is");
    wind->grid.waves = NULL;
    assert_int_equal(pel_weather_create(&wind->grid, &alone, &fault), PEL_OK);
    struct pel_weather_now a = ask(w, 4.3, 3.4, 1e9 + 77);
    struct pel_weather_now b = ask(alone, 4.3, 3.4, 1e9 + 77);
    assert_int_equal(a.place, PEL_WEATHER_INSIDE);
    assert_true(a.wind_known && a.waves_known);
    assert_true(a.wind_east_mps == b.wind_east_mps);
    assert_true(a.wind_north_mps == b.wind_north_mps);
    assert_float_equal(a.height_m, slope(4.3, 3.4, 0), 1e-3);
    assert_true(b.height_m < 0);
    /* Where the waves' grid ends they are held, and not known. */
    a = ask(w, 7, 3.4, 1e9 + 77);
    assert_int_equal(a.place, PEL_WEATHER_OUTSIDE);
    assert_true(a.wind_known && !a.waves_known);
    assert_float_equal(a.height_m, slope(5, 3.4, 0), 1e-3);
    assert_true(a.wind_east_mps == ask(alone, 7, 3.4, 1e9 + 77).wind_east_mps);
    pel_weather_unref(w);
    pel_weather_unref(alone);
    /* The other grid is whole waves, and nothing else. */
    wind->grid.waves = &waves->grid;
    waves->grid.values[PEL_WEATHER_PERIOD] = NULL;
    assert_int_equal(pel_weather_create(&wind->grid, &w, &fault),
                     PEL_ERR_INVALID);
    free(waves);
    free(wind);
}

static void through_bytes(struct made *m, struct made *waves)
{
    char *bytes = NULL;
    size_t size = 0;
    FILE *to = open_memstream(&bytes, &size);
    m->grid.waves = waves ? &waves->grid : NULL;
    m->grid.notes = "u10 has no units";
    assert_non_null(to);
    assert_true(pel_weather_wire_write(&m->grid, to));
    fclose(to);
    const struct pel_weather *w, *same = field_of(m);
    struct pel_fault fault;
    const unsigned char *all = (const unsigned char *)bytes;
    assert_int_equal(pel_weather_wire_read(all, size, &w, &fault), PEL_OK);
    assert_string_equal(w->notes, "u10 has no units");
    struct pel_weather_now a = ask(w, 4.3, 4.4, 1e9 + 77);
    struct pel_weather_now b = ask(same, 4.3, 4.4, 1e9 + 77);
    assert_memory_equal(&a, &b, sizeof a);
    assert_true(w->serial != same->serial);
    pel_weather_unref(w);
    pel_weather_unref(same);
    bytes = realloc(bytes, size + 16);
    assert_non_null(bytes);
    memset(bytes + size, 0, 16);
    for (size_t n = 0; n < size + 16; n += n < 200 ? 1 : 97) {
        if (n != size) {
            assert_int_equal(pel_weather_wire_read((const unsigned char *)bytes,
                                                   n, &w, &fault),
                             PEL_ERR_MALFORMED);
        }
    }
    free(bytes);
    free(waves);
}

/* Through bytes, and no byte too many or too few. */
static void test_wire(void **state)
{
    (void)state;
    through_bytes(plain(), NULL);
    through_bytes(plain(), waves_apart());
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_between),   cmocka_unit_test(test_around),
        cmocka_unit_test(test_land),      cmocka_unit_test(test_weighted),
        cmocka_unit_test(test_refusals),  cmocka_unit_test(test_wire),
        cmocka_unit_test(test_two_grids),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
