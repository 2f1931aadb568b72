/* Thousands of targets: which of them are drawn, who gives way to whom, and
 * what it costs the control thread. */
#include "bridges/nmea_fleet.h"

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <time.h>

#include "base/log.h"
#include "scene/scene_testkit.h"

#define SECOND 1000000000LL
#define CROWD 2000

struct fixture {
    struct pel_scene *scene;
    struct pel_nmea_targets targets;
    struct pel_nmea_target_counters counters;
    double latitude, longitude; /* of own ship */
};

static int set_up(void **state)
{
    static struct fixture f;
    f = (struct fixture){
        .scene = make_scene((struct pel_scene_options){ .wave_count = 20 }),
    };
    f.targets.scene = f.scene;
    f.targets.own_ship = 1;
    f.targets.counters = &f.counters;
    f.targets.fleet = pel_nmea_fleet_create(CROWD);
    f.latitude = entity_of(f.scene, 1)->latitude;
    f.longitude = entity_of(f.scene, 1)->longitude;
    *state = &f;
    return 0;
}

static int tear_down(void **state)
{
    struct fixture *f = *state;
    pel_nmea_targets_finish(&f->targets);
    pel_nmea_fleet_destroy(f->targets.fleet);
    pel_scene_destroy(f->scene);
    return 0;
}

static uint64_t key_of(uint32_t mmsi)
{
    return (uint64_t)mmsi + 1;
}

/* Waits for the next commit. */
static void tell(struct fixture *f, uint32_t mmsi, double minutes_north,
                 int64_t now_ns)
{
    const struct pel_ais ais = {
        .type = 1,
        .mmsi = mmsi,
        .has_position_report = true,
        .latitude = f->latitude + minutes_north / 60,
        .longitude = f->longitude,
        .altitude = NAN,
        .speed = 5,
        .course = 90,
        .heading = NAN,
        .turn_rate = NAN,
        .status = -1,
    };
    pel_nmea_targets_take_ais(&f->targets, &ais, now_ns);
}

static bool is_drawn(const struct fixture *f, uint32_t mmsi)
{
    bool found = false;
    for (size_t i = 0; i < PEL_NMEA_TARGETS; i++) {
        found = found || f->targets.targets[i].key == key_of(mmsi);
    }
    return found;
}

/* All of them told from the nearest or from the farthest on, in datagrams of
 * eight; returns the time when the table is at rest. */
static int64_t crowd(struct fixture *f, bool farthest_first)
{
    int64_t now_ns = f->targets.chosen_ns + 1000 * SECOND;
    for (uint32_t i = 0; i < CROWD; i++) {
        uint32_t n = farthest_first ? CROWD - i : i + 1;
        tell(f, n, n * 0.01, now_ns);
        if (i % 8 == 7) {
            pel_nmea_targets_commit(&f->targets, now_ns);
        }
    }
    for (int i = 0; i < 120; i++) {
        now_ns += SECOND / 2;
        pel_nmea_targets_commit(&f->targets, now_ns);
    }
    pel_scene_settle(f->scene);
    return now_ns;
}

static void the_nearest_are_drawn(void **state)
{
    struct fixture *f = *state;
    for (int order = 0; order < 2; order++) {
        int64_t now_ns = crowd(f, order);
        assert_int_equal(pel_nmea_targets_known(&f->targets), CROWD);
        assert_int_equal(pel_nmea_targets_count(&f->targets), PEL_NMEA_TARGETS);
        for (uint32_t n = 1; n <= 90; n++) { /* the last ten are about as far */
            assert_true(is_drawn(f, n));
        }
        assert_true(pel_scene_state(f->scene)->n_entities <=
                    PEL_BOUND_ENTITIES);
        pel_nmea_targets_expire(&f->targets, now_ns + 700 * SECOND);
        assert_int_equal(pel_nmea_targets_known(&f->targets), 0);
    }
}

/* Two about as far: whoever is drawn stays. One that is clearly nearer takes
 * the place, and not within ten seconds of the change. */
static void nobody_flickers(void **state)
{
    struct fixture *f = *state;
    int64_t now_ns = crowd(f, false);
    uint32_t last = 0, first = 0;
    for (uint32_t n = 1; n <= CROWD; n++) {
        last = is_drawn(f, n) ? n : last;
        first = !first && !is_drawn(f, n) ? n : first;
    }
    assert_true(last > 0 && first > 0);
    uint64_t evicted = f->counters.evicted;
    double far = last * 0.01;
    for (int i = 0; i < 200; i++) { /* now a little nearer, now farther */
        now_ns += SECOND / 2;
        tell(f, first, far * (i % 2 ? 0.97 : 1.03), now_ns);
        tell(f, last, far, now_ns);
        pel_nmea_targets_commit(&f->targets, now_ns);
    }
    assert_int_equal(f->counters.evicted, evicted);
    assert_false(is_drawn(f, first));
    tell(f, first, far * 0.5, now_ns);
    now_ns += SECOND;
    pel_nmea_targets_commit(&f->targets, now_ns);
    assert_true(is_drawn(f, first));
    assert_int_equal(f->counters.evicted, evicted + 1);
}

static void without_own_ship_the_newest(void **state)
{
    struct fixture *f = *state;
    f->targets.own_ship = 4711;
    int64_t now_ns = crowd(f, false);
    for (uint32_t n = 1500; n < 1540; n++) {
        tell(f, n, n, now_ns);
    }
    for (int i = 0; i < 10; i++) {
        now_ns += SECOND;
        pel_nmea_targets_commit(&f->targets, now_ns);
    }
    for (uint32_t n = 1500; n < 1540; n++) {
        assert_true(is_drawn(f, n));
    }
}

/* The table is full: a nearer newcomer gets a place, a farther one none. */
static void a_full_fleet_keeps_the_nearest(void **state)
{
    struct fixture *f = *state;
    int64_t now_ns = crowd(f, false);
    tell(f, 900001, 0.005, now_ns);
    tell(f, 900002, 500, now_ns);
    assert_non_null(pel_nmea_fleet_find(f->targets.fleet, key_of(900001)));
    assert_null(pel_nmea_fleet_find(f->targets.fleet, key_of(CROWD)));
    assert_null(pel_nmea_fleet_find(f->targets.fleet, key_of(900002)));
    assert_int_equal(pel_nmea_fleet_count(f->targets.fleet), CROWD);
}

/* The state may have little room: what is free is what is drawn. */
static void others_keep_their_room(void **state)
{
    struct fixture *f = *state;
    char text[PEL_BOUND_ENTITIES * 32];
    size_t used =
        (size_t)snprintf(text, sizeof text, "{\"entities\":[{\"id\":1}");
    for (unsigned id = 2; id <= PEL_BOUND_ENTITIES - 10; id++) {
        used += (size_t)snprintf(text + used, sizeof text - used,
                                 ",{\"id\":%u,\"name\":\"e%u\"}", id, id);
    }
    snprintf(text + used, sizeof text - used, "]}");
    must(f->scene, text);
    crowd(f, false);
    assert_int_equal(pel_nmea_targets_count(&f->targets), 10);
    assert_int_equal(f->counters.refused_edits, 0);
    assert_true(is_drawn(f, 1));
}

static void a_name_and_a_place_come_along(void **state)
{
    struct fixture *f = *state;
    int64_t now_ns = crowd(f, false);
    struct pel_ais ais = { .type = 24, .mmsi = 1999 };
    snprintf(ais.name, sizeof ais.name, "LATECOMER");
    pel_nmea_targets_take_ais(&f->targets, &ais, now_ns);
    tell(f, 1999, 0.001, now_ns);
    now_ns += SECOND;
    pel_nmea_targets_commit(&f->targets, now_ns);
    const Pelagos__State *s = pel_scene_state(f->scene);
    const Pelagos__Entity *found = NULL;
    for (size_t i = 0; i < s->n_entities; i++) {
        found = strcmp(s->entities[i]->name, "LATECOMER") == 0 ? s->entities[i]
                                                               : found;
    }
    assert_non_null(found);
    if (!found) {
        return; /* which the analyser does not take from the line above */
    }
    /* A second's way to the east at 5 m/s. */
    double east_m = (found->longitude - f->longitude) * 111320 *
                    cos(f->latitude * 3.14159265358979 / 180);
    assert_true(fabs(east_m - 5) < 0.2);
}

static double processor_s(void)
{
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* Figures: all of them at 10 Hz for two seconds, in datagrams of eight. */
static void what_it_costs(void **state)
{
    struct fixture *f = *state;
    int64_t now_ns = crowd(f, false);
    double longest_s = 0, whole_s = 0;
    for (int turn = 0; turn < 20; turn++) {
        for (uint32_t n = 1; n <= CROWD; n += 8) {
            double begin_s = processor_s();
            for (uint32_t k = n; k < n + 8; k++) {
                tell(f, k, k * 0.01 + turn * 1e-4, now_ns);
            }
            pel_nmea_targets_commit(&f->targets, now_ns);
            double took_s = processor_s() - begin_s;
            longest_s = took_s > longest_s ? took_s : longest_s;
            whole_s += took_s;
            now_ns += SECOND / 10 * 8 / CROWD;
        }
    }
    print_message("%d targets at 10 Hz: a datagram %.3f ms at most, %.1f %% "
                  "of a core\n",
                  CROWD, longest_s * 1e3, whole_s / 2 * 100);
}

int main(void)
{
#define TEST(name) cmocka_unit_test_setup_teardown(name, set_up, tear_down)
    const struct CMUnitTest tests[] = {
        TEST(the_nearest_are_drawn),
        TEST(nobody_flickers),
        TEST(without_own_ship_the_newest),
        TEST(a_full_fleet_keeps_the_nearest),
        TEST(others_keep_their_room),
        TEST(a_name_and_a_place_come_along),
        TEST(what_it_costs),
    };
    pel_log_set_level(PEL_LOG_ERROR);
    return cmocka_run_group_tests_name("fleet", tests, NULL, NULL);
}
