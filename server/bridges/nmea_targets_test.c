/* The table of targets: who is in it when there are more than it holds, names,
 * radar targets, and what silence removes. */
#include "bridges/nmea_targets.h"

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include "base/log.h"
#include "scene/fleet.h"
#include "scene/geodesy.h"
#include "scene/scene_testkit.h"

#define SECOND 1000000000LL
#define NEAR(a, b, tolerance) assert_true(fabs((a) - (b)) <= (tolerance))

struct fixture {
    struct pel_scene *scene;
    struct pel_nmea_targets targets;
    struct pel_nmea_target_counters counters;
    double latitude, longitude; /* of own ship */
    size_t early;               /* of count_early */
};

static const Pelagos__Entity *named(struct fixture *f, const char *name)
{
    const Pelagos__State *s = pel_scene_state(f->scene);
    for (size_t i = 0; i < s->n_entities; i++) {
        if (strcmp(s->entities[i]->name, name) == 0) {
            return s->entities[i];
        }
    }
    return NULL;
}

static int set_up(void **state)
{
    static struct fixture f;
    f = (struct fixture){
        .scene = make_scene((struct pel_scene_options){ .wave_count = 20 }),
    };
    f.targets.scene = f.scene;
    f.targets.own_ship = 1;
    f.targets.counters = &f.counters;
    f.latitude = entity_of(f.scene, 1)->latitude;
    f.longitude = entity_of(f.scene, 1)->longitude;
    *state = &f;
    return 0;
}

static int tear_down(void **state)
{
    struct fixture *f = *state;
    pel_scene_destroy(f->scene);
    return 0;
}

/* A position report from `minutes` of latitude north of own ship; of type 27
 * it is coarse. */
static void report_as(struct fixture *f, int type, uint32_t mmsi,
                      double minutes, int64_t now_ns)
{
    const struct pel_ais ais = {
        .type = type,
        .coarse = type == 27,
        .mmsi = mmsi,
        .has_position_report = true,
        .latitude = f->latitude + minutes / 60,
        .longitude = f->longitude,
        .altitude = NAN,
        .speed = 5,
        .course = 45,
        .heading = NAN,
        .turn_rate = NAN,
    };
    pel_nmea_targets_take_ais(&f->targets, &ais, now_ns);
    pel_nmea_targets_commit(&f->targets, now_ns);
}

static void report(struct fixture *f, uint32_t mmsi, double minutes,
                   int64_t now_ns)
{
    report_as(f, 1, mmsi, minutes, now_ns);
}

static void name(struct fixture *f, uint32_t mmsi, const char *text,
                 int64_t now_ns)
{
    struct pel_ais ais = { .type = 24, .mmsi = mmsi };
    snprintf(ais.name, sizeof ais.name, "%s", text);
    pel_nmea_targets_take_ais(&f->targets, &ais, now_ns);
    pel_nmea_targets_commit(&f->targets, now_ns);
}

/* Reports without a position take nobody's place, however many come. */
static void names_never_displace_positions(void **state)
{
    struct fixture *f = *state;
    for (uint32_t i = 0; i < 1000; i++) {
        char text[21];
        snprintf(text, sizeof text, "NOBODY %u", i);
        name(f, 100000000 + i, text, SECOND);
    }
    assert_int_equal(pel_nmea_targets_count(&f->targets), 0);
    for (uint32_t i = 0; i < PEL_NMEA_TARGETS; i++) {
        report(f, 200000000 + i, 1 + i * 0.01, SECOND);
    }
    name(f, 300000000, "LATE", SECOND);
    assert_int_equal(pel_nmea_targets_count(&f->targets), PEL_NMEA_TARGETS);
    assert_int_equal(f->counters.evicted, 0);
}

static void names_come_before_or_after(void **state)
{
    struct fixture *f = *state;
    name(f, 244000001, "BEFORE", SECOND);
    report(f, 244000001, 1, SECOND);
    report(f, 244000002, 1, SECOND);
    assert_non_null(named(f, "BEFORE"));
    assert_non_null(named(f, "mmsi-244000002"));
    name(f, 244000002, "AFTER", SECOND);
    assert_non_null(named(f, "AFTER"));
    NEAR(named(f, "AFTER")->latitude, f->latitude + 1 / 60.0, 1e-9);
    uint64_t revision = pel_scene_state(f->scene)->revision;
    name(f, 244000002, "AFTER", SECOND); /* said again: no news */
    assert_int_equal(pel_scene_state(f->scene)->revision, revision);
}

static void the_nearest_stay(void **state)
{
    struct fixture *f = *state;
    for (uint32_t i = 0; i < 300; i++) { /* the farthest first */
        report(f, 200000000 + i, 300 - i, SECOND);
    }
    assert_int_equal(pel_nmea_targets_count(&f->targets), PEL_NMEA_TARGETS);
    assert_int_equal(f->counters.evicted, 200);
    for (uint32_t i = 200; i < 300; i++) {
        char text[40];
        snprintf(text, sizeof text, "mmsi-%u", 200000000 + i);
        assert_non_null(named(f, text));
    }
    report(f, 244000000, 200, SECOND); /* farther than all */
    assert_null(named(f, "mmsi-244000000"));
    assert_int_equal(f->counters.refused, 1);
    report(f, 244000000, 200, 362 * SECOND); /* all are stale by now */
    assert_non_null(named(f, "mmsi-244000000"));
    assert_int_equal(f->counters.refused_edits, 0);
}

/* Without own ship the one unheard longest gives way. */
static void the_newest_stay_without_own_ship(void **state)
{
    struct fixture *f = *state;
    f->targets.own_ship = 77;
    for (uint32_t i = 0; i < 150; i++) {
        report(f, 200000000 + i, i, (1 + i) * SECOND);
    }
    assert_null(named(f, "mmsi-200000049"));
    assert_non_null(named(f, "mmsi-200000050"));
    assert_non_null(named(f, "mmsi-200000149"));
}

/* What takes a place has nothing of what was there. */
static void a_place_is_taken_whole(void **state)
{
    struct fixture *f = *state;
    for (uint32_t i = 0; i < PEL_NMEA_TARGETS; i++) {
        struct pel_ais aircraft = {
            .type = 9,
            .mmsi = 111000000 + i,
            .has_position_report = true,
            .latitude = f->latitude + 1 + i * 0.01,
            .longitude = f->longitude,
            .altitude = 300,
            .speed = 50,
            .course = 90,
            .heading = 90,
            .turn_rate = 1,
        };
        pel_nmea_targets_take_ais(&f->targets, &aircraft, SECOND);
    }
    pel_nmea_targets_commit(&f->targets, SECOND);
    struct pel_ais buoy = {
        .type = 21,
        .mmsi = 992440000,
        .has_position_report = true,
        .latitude = f->latitude,
        .longitude = f->longitude,
        .altitude = NAN,
        .speed = NAN,
        .course = NAN,
        .heading = NAN,
        .turn_rate = NAN,
        .name = "IJM 3",
    };
    pel_nmea_targets_take_ais(&f->targets, &buoy, SECOND);
    pel_nmea_targets_commit(&f->targets, SECOND);
    const Pelagos__Entity *e = named(f, "IJM 3");
    assert_non_null(e);
    assert_int_equal(e->id, PEL_NMEA_TARGET_ID + PEL_NMEA_TARGETS - 1);
    assert_true(e->altitude == 0 && e->speed == 0 && e->turn_rate == 0 &&
                e->heading == 0);
}

/* 0.1 minute is 185 m: no jump of a ship whose place is known. */
static void coarse_positions_are_for_the_unknown(void **state)
{
    struct fixture *f = *state;
    report_as(f, 27, 244000001, 6, SECOND);
    NEAR(entity_of(f->scene, 20000)->latitude, f->latitude + 0.1, 1e-9);
    report(f, 244000001, 1, 2 * SECOND);
    report_as(f, 27, 244000001, 6, 3 * SECOND);
    NEAR(entity_of(f->scene, 20000)->latitude, f->latitude + 1 / 60.0, 1e-4);
    report_as(f, 27, 244000001, 6, 363 * SECOND);
    NEAR(entity_of(f->scene, 20000)->latitude, f->latitude + 0.1, 1e-9);
}

static void radar(struct fixture *f, const char *body, int64_t now_ns)
{
    char line[120];
    unsigned sum = 0;
    struct pel_nmea_sentence s;
    for (const char *p = body + 1; *p; p++) {
        sum ^= (unsigned char)*p;
    }
    int size = snprintf(line, sizeof line, "%s*%02X", body, sum);
    assert_int_equal(pel_nmea_parse(line, (size_t)size, &s), PEL_NMEA_OK);
    pel_nmea_targets_take_radar(&f->targets, &s, now_ns);
    pel_nmea_targets_commit(&f->targets, now_ns);
}

static void radar_targets(void **state)
{
    struct fixture *f = *state;
    double east, north;
    radar(f, "$RATTM,7,1.50,45.0,T,9.0,270.0,T,0.2,5.0,N,,T,,120000,A", SECOND);
    const Pelagos__Entity *e = named(f, "radar-07");
    assert_non_null(e);
    pel_geo_to_local(f->latitude, f->longitude, e->latitude, e->longitude,
                     &east, &north);
    /* The geodesic is exact to 1 mm. */
    NEAR(east, 1.5 * 1852 * sqrt(0.5), 0.01);
    NEAR(north, 1.5 * 1852 * sqrt(0.5), 0.01);
    NEAR(e->speed, 9 * 1852 / 3600.0, 1e-9);
    NEAR(e->course, 270, 1e-9);
    /* From the bow; own ship heads north. Kilometres. A name. */
    radar(f, "$RATTM,7,2.0,90.0,R,9.0,27.0,R,0.2,5.0,K,FERRY,T,,120000,A",
          SECOND);
    e = named(f, "FERRY");
    assert_non_null(e);
    pel_geo_to_local(f->latitude, f->longitude, e->latitude, e->longitude,
                     &east, &north);
    NEAR(east, 2000, 0.01);
    assert_true(e->speed == 0); /* a relative course is no course */
    /* TLL's position is better than TTM's, whose motion still counts. */
    radar(f, "$RATLL,7,5237.00,N,00513.00,E,FERRY,120000,T,", 2 * SECOND);
    radar(f, "$RATTM,7,3.0,90.0,R,9.0,0.0,T,0.2,5.0,N,FERRY,T,,120000,A",
          2 * SECOND);
    e = named(f, "FERRY");
    /* Reckoned for the milliseconds between the two sentences: 1e-4 deg. */
    NEAR(e->latitude, 52 + 37 / 60.0, 1e-4);
    NEAR(e->speed, 9 * 1852 / 3600.0, 1e-9);
    radar(f, "$RATTM,7,3.0,90.0,R,9.0,0.0,T,0.2,5.0,N,FERRY,L,,120000,A",
          3 * SECOND);
    assert_null(named(f, "FERRY"));
    assert_int_equal(pel_nmea_targets_count(&f->targets), 0);
    /* An AIS number below 1000 is another target. */
    radar(f, "$RATTM,7,3.0,90.0,R,9.0,0.0,T,0.2,5.0,N,,T,,120000,A", SECOND);
    report(f, 7, 1, SECOND);
    assert_int_equal(pel_nmea_targets_count(&f->targets), 2);
}

static void silent_targets_go(void **state)
{
    struct fixture *f = *state;
    report(f, 244000001, 1, SECOND);
    radar(f, "$RATTM,7,1.50,45.0,T,9.0,270.0,T,0.2,5.0,N,,T,,120000,A", SECOND);
    pel_nmea_targets_expire(&f->targets, 60 * SECOND);
    assert_int_equal(pel_nmea_targets_count(&f->targets), 2);
    pel_nmea_targets_expire(&f->targets, 62 * SECOND);
    assert_null(named(f, "radar-07"));
    pel_nmea_targets_expire(&f->targets, 600 * SECOND);
    assert_non_null(named(f, "mmsi-244000001"));
    pel_nmea_targets_expire(&f->targets, 602 * SECOND);
    assert_null(named(f, "mmsi-244000001"));
    assert_int_equal(pel_nmea_targets_count(&f->targets), 0);
}

/* The scene's model of entity 20000, when it has been made. */
static const Pelagos__Model *shape(struct fixture *f)
{
    pel_scene_settle(f->scene);
    return entity_of(f->scene, 20000)->model;
}

static void ship(struct fixture *f, uint32_t mmsi, struct pel_ais_ship what)
{
    struct pel_ais ais = { .type = 5, .mmsi = mmsi, .has_ship = true };
    ais.ship = what;
    pel_nmea_targets_take_ais(&f->targets, &ais, SECOND);
    pel_nmea_targets_commit(&f->targets, SECOND);
}

static void ships_are_drawn(void **state)
{
    struct fixture *f = *state;
    report(f, 244000001, 1, SECOND);
    assert_string_equal(shape(f)->name, "bulk-carrier");
    NEAR(shape(f)->length, 90, 0);
    assert_true(entity_of(f->scene, 20000)->afloat);
    ship(f, 244000001, (struct pel_ais_ship){ 80, false, 200, 50, 30, 12, 15 });
    assert_string_equal(shape(f)->name, "tanker");
    NEAR(shape(f)->length, 250, 0);
    NEAR(shape(f)->beam, 42, 0);
    NEAR(shape(f)->draught, 15, 0);
    /* The course is 45°, the middle 75 m ahead of the antenna and 9 m to port.
     */
    double east, north;
    report(f, 244000001, 1, 2 * SECOND);
    const Pelagos__Entity *e = entity_of(f->scene, 20000);
    pel_geo_to_local(f->latitude + 1 / 60.0, f->longitude, e->latitude,
                     e->longitude, &east, &north);
    NEAR(east, (75 - 9) * sqrt(0.5), 1e-3);
    NEAR(north, (75 + 9) * sqrt(0.5), 1e-3);
    /* Another ship has nothing of the old one's sizes. */
    ship(f, 244000001, (struct pel_ais_ship){ .type = 36 });
    assert_string_equal(shape(f)->name, "sailing-yacht");
    assert_false(shape(f)->has_length || shape(f)->has_beam);
    assert_int_equal(f->counters.refused_edits, 0);
}

/* Every type with every size: no model is refused, whatever is sent. */
static void no_size_is_refused(void **state)
{
    (void)state;
    static const double sizes[] = { 0, 1, 3, 7, 29, 30, 250, 511 };
    for (unsigned k = 0; k < 256 * 8 * 8; k++) {
        double bow = sizes[k / 256 % 8], stern = sizes[k / 2048];
        const struct pel_ais_ship ship = {
            (uint8_t)k,      false,         bow,           stern,
            fmin(stern, 63), fmin(bow, 63), k % 3 * 12.75,
        };
        Pelagos__Model m = PELAGOS__MODEL__INIT;
        struct pel_fault fault;
        assert_true(pel_nmea_shape_of(PEL_NMEA_CLASS_A, 244000001, &ship, &m));
        assert_int_equal(pel_fleet_try(&m, &fault), PEL_OK);
        assert_true(!m.has_length || m.length <= 1000);
    }
}

static void aids_are_drawn(void **state)
{
    struct fixture *f = *state;
    struct pel_ais_ship port = { .type = 24 };
    Pelagos__Model m = PELAGOS__MODEL__INIT;
    (void)f;
    assert_true(pel_nmea_shape_of(PEL_NMEA_AID, 992440001, &port, &m));
    assert_string_equal(m.name, "lateral-port-a");
    assert_true(pel_nmea_shape_of(PEL_NMEA_AID, 993660001, &port, &m));
    assert_string_equal(m.name, "lateral-port-b");
    port.is_virtual = true;
    assert_false(pel_nmea_shape_of(PEL_NMEA_AID, 992440001, &port, &m));
    assert_false(pel_nmea_shape_of(PEL_NMEA_UNSHAPED, 2440001, &port, &m));
}

/* Of a scene whose targets all wait: how many had a size before all had a
 * shape. */
static void count_early(void *user)
{
    struct fixture *f = user;
    const Pelagos__State *now = pel_scene_state(f->scene);
    size_t bare = 0, sized = 0;
    for (size_t i = 0; i < now->n_entities; i++) {
        const Pelagos__Entity *e = now->entities[i];
        bare += e->id >= 20000 && !e->model;
        sized += e->id >= 20000 && e->model && e->model->has_length;
    }
    f->early += bare > 0 ? sized : 0;
}

static void a_crowd_has_shapes_first(void **state)
{
    struct fixture *f = *state;
    for (uint32_t i = 0; i < 20; i++) {
        struct pel_ais ais = { .type = 5,
                               .mmsi = 244000001 + i,
                               .has_ship = true,
                               .ship = { 50, false, 6 + i % 3, 6, 2, 2, 0 } };
        pel_nmea_targets_take_ais(&f->targets, &ais, SECOND);
        report(f, 244000001 + i, 1 + i, SECOND);
    }
    pel_scene_on_commit(f->scene, count_early, f);
    pel_scene_settle(f->scene);
    const Pelagos__State *now = pel_scene_state(f->scene);
    for (size_t i = 1; i < now->n_entities; i++) {
        assert_non_null(now->entities[i]->model);
        assert_true(now->entities[i]->model->has_length);
    }
    assert_int_equal(now->n_entities, 21);
    /* the first was alone when it came */
    assert_true(f->early <= 3);
    assert_int_equal(f->counters.refused_edits, 0);
}

/* A target that goes while its model is made does not come back with it. */
static void gone_is_gone(void **state)
{
    struct fixture *f = *state;
    report(f, 244000001, 1, SECOND);
    pel_nmea_targets_expire(&f->targets, 602 * SECOND);
    pel_scene_settle(f->scene);
    assert_null(named(f, "mmsi-244000001"));
    for (size_t i = 0; i < pel_scene_state(f->scene)->n_entities; i++) {
        assert_true(pel_scene_state(f->scene)->entities[i]->id < 20000);
    }
}

int main(void)
{
    pel_log_set_level(PEL_LOG_ERROR);
#define TEST(name) cmocka_unit_test_setup_teardown(name, set_up, tear_down)
    const struct CMUnitTest tests[] = {
        TEST(names_never_displace_positions),
        TEST(names_come_before_or_after),
        TEST(the_nearest_stay),
        TEST(the_newest_stay_without_own_ship),
        TEST(a_place_is_taken_whole),
        TEST(coarse_positions_are_for_the_unknown),
        TEST(radar_targets),
        TEST(silent_targets_go),
        TEST(ships_are_drawn),
        TEST(no_size_is_refused),
        TEST(aids_are_drawn),
        TEST(gone_is_gone),
        TEST(a_crowd_has_shapes_first),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
