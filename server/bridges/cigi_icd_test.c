/* What hosts of other makes rely on, by the interface's own document. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>

#include <cmocka.h>

#include "bridges/cigi_testkit.h"

static void begin_in_mode(double mode, double database)
{
    frame++;
    used = 0;
    with(PEL_CIGI_KIND_IG_CONTROL, PEL_CIGI_IG_CONTROL_MAJOR, 3.0,
         PEL_CIGI_IG_CONTROL_MINOR, 3.0, PEL_CIGI_IG_CONTROL_MAGIC, 32768.0,
         PEL_CIGI_IG_CONTROL_MODE, mode, PEL_CIGI_IG_CONTROL_DATABASE, database,
         PEL_CIGI_IG_CONTROL_FRAME, (double)frame, 0);
}

static void the_atmosphere_holds_without_its_model(void **state)
{
    (void)state;
    begin();
    with(PEL_CIGI_KIND_ATMOSPHERE, PEL_CIGI_ATMOSPHERE_VISIBILITY, 4000.0,
         PEL_CIGI_ATMOSPHERE_WIND, 13.0, PEL_CIGI_ATMOSPHERE_WIND_DIRECTION,
         40.0, 0);
    send();
    const Pelagos__State *s = pel_scene_state(scene);
    assert_near(s->sky->visibility, 4000, 0);
    assert_near(s->sea->wind_speed, 13, 0);
}

static void calm(void)
{
    begin();
    with(PEL_CIGI_KIND_ATMOSPHERE, PEL_CIGI_ATMOSPHERE_VISIBILITY, 20000.0, 0);
    send();
}

/* From 10 m above the origin to a place north_m away. */
static void segment(double north_m, double altitude_m)
{
    with(PEL_CIGI_KIND_LOS_SEGMENT, PEL_CIGI_LOS_SEGMENT_ID, 3.0,
         PEL_CIGI_LOS_SEGMENT_LATITUDE, 52.6, PEL_CIGI_LOS_SEGMENT_LONGITUDE,
         5.2, PEL_CIGI_LOS_SEGMENT_ALTITUDE, 10.0,
         PEL_CIGI_LOS_SEGMENT_TO_LATITUDE, 52.6 + north_m / 111278,
         PEL_CIGI_LOS_SEGMENT_TO_LONGITUDE, 5.2,
         PEL_CIGI_LOS_SEGMENT_TO_ALTITUDE, altitude_m, 0);
}

static void expect_sight(double valid, double visible)
{
    struct pel_cigi_packet a = next_answer(PEL_CIGI_KIND_LOS_RESPONSE);
    assert_near(pel_cigi_get(&a, PEL_CIGI_LOS_RESPONSE_VALID), valid, 0);
    assert_near(pel_cigi_get(&a, PEL_CIGI_LOS_RESPONSE_VISIBLE), visible, 0);
}

static void a_clear_sight_has_no_range(void **state)
{
    (void)state;
    calm();
    begin();
    segment(500, 10);
    segment(500, -10);
    send();
    take_frame();
    expect_sight(0, 1);
    expect_sight(1, 0);
}

/* Horizons of a sphere of 6360 km: 11.3 km from 10 m, 35.7 km from 100 m. */
static void the_horizon_hides(void **state)
{
    (void)state;
    calm();
    begin();
    segment(22000, 10);
    segment(24000, 10);
    segment(40000, 10);
    segment(46000, 100);
    segment(48000, 100);
    send();
    take_frame();
    expect_sight(0, 1);
    expect_sight(1, 0);
    expect_sight(1, 0);
    expect_sight(0, 1);
    expect_sight(1, 0);
}

static void what_is_switched_off_ends(void **state)
{
    (void)state;
    const Pelagos__State *s = pel_scene_state(scene);
    double green = s->water->chlorophyll, level = s->sea->level;
    double mps = s->sea->wind_speed, metres = s->sky->visibility;
    double whitecaps = s->sea->whitecaps;
    assert_true(whitecaps > 0);
    begin();
    with(PEL_CIGI_KIND_MARITIME, PEL_CIGI_MARITIME_ENABLE, 1.0,
         PEL_CIGI_MARITIME_HEIGHT, 2.0, PEL_CIGI_MARITIME_CLARITY, 20.0,
         PEL_CIGI_MARITIME_WHITECAPS, 1.0, 0);
    send();
    assert_near(pel_scene_state(scene)->sea->whitecaps, whitecaps, 0);
    begin();
    with(PEL_CIGI_KIND_MARITIME, PEL_CIGI_MARITIME_ENABLE, 1.0,
         PEL_CIGI_MARITIME_HEIGHT, 2.0, PEL_CIGI_MARITIME_CLARITY, 20.0, 0);
    with(PEL_CIGI_KIND_WEATHER, PEL_CIGI_WEATHER_ENABLE, 1.0,
         PEL_CIGI_WEATHER_VISIBILITY, 700.0, PEL_CIGI_WEATHER_WIND, 15.0, 0);
    send();
    s = pel_scene_state(scene);
    assert_near(s->sea->level, 2, 0);
    assert_near(s->sea->whitecaps, 0, 0);
    assert_near(s->sky->visibility, 700, 0);
    assert_near(s->sea->wind_speed, 15, 0);
    assert_true(s->water->chlorophyll != green);
    begin();
    with(PEL_CIGI_KIND_WEATHER, PEL_CIGI_WEATHER_VISIBILITY, 700.0,
         PEL_CIGI_WEATHER_WIND, 15.0, 0);
    send();
    s = pel_scene_state(scene);
    assert_near(s->sky->visibility, metres, 0);
    assert_near(s->sea->wind_speed, mps, 0);
    /* The whole sea's conditions have no switch: Reset ends them. */
    begin();
    with(PEL_CIGI_KIND_MARITIME, PEL_CIGI_MARITIME_HEIGHT, 3.0,
         PEL_CIGI_MARITIME_CLARITY, 20.0, PEL_CIGI_MARITIME_WHITECAPS, 1.0, 0);
    send();
    s = pel_scene_state(scene);
    assert_near(s->sea->level, 3, 0);
    assert_near(s->sea->whitecaps, whitecaps, 0);
    assert_true(s->water->chlorophyll != green);
    begin_in_mode(0, 0);
    send();
    s = pel_scene_state(scene);
    assert_near(s->sea->level, level, 0);
    assert_near(s->sea->whitecaps, whitecaps, 0);
    assert_near(s->water->chlorophyll, green, 0);
    begin(); /* operate again */
    send();
}

static void reset_takes_back(void **state)
{
    (void)state;
    const Pelagos__State *s = pel_scene_state(scene);
    double mps = s->sea->wind_speed, level = s->sea->level;
    size_t waves = s->sea->n_wave;
    begin_in_mode(1, 5);
    wind(14, 90, 5000);
    with(PEL_CIGI_KIND_WAVE, PEL_CIGI_WAVE_ID, 1.0, PEL_CIGI_WAVE_ENABLE, 1.0,
         PEL_CIGI_WAVE_HEIGHT, 1.0, PEL_CIGI_WAVE_PERIOD, 8.0, 0);
    with(PEL_CIGI_KIND_MARITIME, PEL_CIGI_MARITIME_ENABLE, 1.0,
         PEL_CIGI_MARITIME_HEIGHT, 2.0, 0);
    send();
    assert_int_equal(pel_scene_state(scene)->sea->n_wave, waves + 1);
    begin_in_mode(1, 0);
    send();
    take_frame();
    assert_near(pel_cigi_get(&sof, PEL_CIGI_START_OF_FRAME_DATABASE), 5, 0);
    begin_in_mode(0, 0);
    send();
    s = pel_scene_state(scene);
    assert_near(s->sea->wind_speed, mps, 0);
    assert_near(s->sea->level, level, 0);
    assert_int_equal(s->sea->n_wave, waves);
    take_frame();
    assert_near(pel_cigi_get(&sof, PEL_CIGI_START_OF_FRAME_DATABASE), 0, 0);
    /* and is loaded again in Standby */
    begin_in_mode(0, 5);
    send();
    take_frame();
    assert_near(pel_cigi_get(&sof, PEL_CIGI_START_OF_FRAME_DATABASE), -5, 0);
}

static void the_bridge_goes_with_entity_0(void **state)
{
    (void)state;
    begin();
    place_ship(0, 53, 45);
    place_ship(1, 54, 0); /* another ship: not ours */
    send();
    const Pelagos__View *view = pel_scene_state(scene)->views[0];
    assert_true(view->has_entity);
    assert_int_equal(view->entity, 0);
    assert_near(entity(1)->latitude, 54, 0);
}

static void child_of(uint32_t id, uint32_t parent)
{
    with(PEL_CIGI_KIND_ENTITY_CONTROL, PEL_CIGI_ENTITY_CONTROL_ID, (double)id,
         PEL_CIGI_ENTITY_CONTROL_STATE, 1.0, PEL_CIGI_ENTITY_CONTROL_ATTACH,
         1.0, PEL_CIGI_ENTITY_CONTROL_PARENT, (double)parent,
         PEL_CIGI_ENTITY_CONTROL_LATITUDE, 10.0, 0);
}

static void children_go_with_their_parent(void **state)
{
    (void)state;
    begin();
    place_ship(20, 52.6, 0);
    place_ship(24, 52.6, 0);
    child_of(21, 20);
    child_of(22, 21);
    send();
    begin();
    send();
    assert_non_null(entity(22));
    begin();
    with(PEL_CIGI_KIND_ENTITY_CONTROL, PEL_CIGI_ENTITY_CONTROL_ID, 20.0,
         PEL_CIGI_ENTITY_CONTROL_STATE, 2.0, 0);
    send();
    begin();
    send();
    assert_null(entity(20));
    assert_null(entity(21));
    assert_null(entity(22));
    assert_non_null(entity(24));
}

/* 2 m/s ahead on a parent that heads north, turning 6 deg/s, for 1 s of 60
 * frames; then again along its own axes, which are turned by 90 deg then. */
static void children_move_on_their_parent(void **state)
{
    (void)state;
    double degree_m = 111278;
    begin();
    place_ship(20, 52.6, 0);
    child_of(21, 20);
    with(PEL_CIGI_KIND_RATE, PEL_CIGI_RATE_ID, 21.0, PEL_CIGI_RATE_X, 2.0,
         PEL_CIGI_RATE_YAW, 90.0, 0);
    send();
    begin();
    send(); /* from here on frames lead */
    double north = entity(21)->latitude, time_s = pel_scene_time(scene);
    double turned = entity(21)->heading;
    begin_at(frame + 60);
    send();
    double seconds = pel_scene_time(scene) - time_s;
    assert_near(seconds, 1, 1e-9);
    assert_near((entity(21)->latitude - north) * degree_m, 2, 1e-3);
    /* the parent's roll of 3 deg tips its plane */
    assert_near(entity(21)->heading - turned, 90, 0.3);
}

static void the_sun_stands_without_a_date(void **state)
{
    (void)state;
    begin();
    with(PEL_CIGI_KIND_CELESTIAL, PEL_CIGI_CELESTIAL_HOUR, 15.0, 0);
    send();
    const Pelagos__State *s = pel_scene_state(scene);
    assert_true(s->sky->has_sun_azimuth);
    const struct pel_snapshot *now = pel_scene_snapshot(scene);
    double azimuth = s->sky->sun_azimuth;
    pel_snapshot_unref(now);
    begin_at(frame + 100);
    with(PEL_CIGI_KIND_CELESTIAL, PEL_CIGI_CELESTIAL_HOUR, 17.0, 0);
    send();
    assert_near(pel_scene_state(scene)->sky->sun_azimuth, azimuth, 0);
    begin();
    with(PEL_CIGI_KIND_CELESTIAL, PEL_CIGI_CELESTIAL_EPHEMERIS, 1.0, 0);
    send();
    assert_false(pel_scene_state(scene)->sky->has_sun_azimuth);
}

static void sight_down(double answer_local)
{
    with(PEL_CIGI_KIND_LOS_VECTOR, PEL_CIGI_LOS_VECTOR_ID, 3.0,
         PEL_CIGI_LOS_VECTOR_TYPE, 1.0, PEL_CIGI_LOS_VECTOR_RESPONSE,
         answer_local, PEL_CIGI_LOS_VECTOR_ENTITY, 30.0,
         PEL_CIGI_LOS_VECTOR_LATITUDE, 52.6, PEL_CIGI_LOS_VECTOR_LONGITUDE, 5.2,
         PEL_CIGI_LOS_VECTOR_ALTITUDE, 25.0, PEL_CIGI_LOS_VECTOR_ELEVATION,
         -90.0, PEL_CIGI_LOS_VECTOR_MAX_RANGE, 100.0, 0);
}

static void normals_are_in_the_axes_of_the_answer(void **state)
{
    (void)state;
    begin();
    with(PEL_CIGI_KIND_ENTITY_CONTROL, PEL_CIGI_ENTITY_CONTROL_ID, 30.0,
         PEL_CIGI_ENTITY_CONTROL_STATE, 1.0, PEL_CIGI_ENTITY_CONTROL_LATITUDE,
         52.6, PEL_CIGI_ENTITY_CONTROL_LONGITUDE, 5.2,
         PEL_CIGI_ENTITY_CONTROL_YAW, 70.0, 0);
    wind(12, 250, 9000);
    send();
    begin();
    sight_down(0);
    sight_down(1);
    send();
    take_frame();
    struct pel_cigi_packet a = next_answer(PEL_CIGI_KIND_LOS_EXTENDED);
    struct pel_cigi_packet b = next_answer(PEL_CIGI_KIND_LOS_EXTENDED);
    double turned = pel_cigi_get(&a, PEL_CIGI_LOS_EXTENDED_AZIMUTH) -
                    pel_cigi_get(&b, PEL_CIGI_LOS_EXTENDED_AZIMUTH);
    assert_near(remainder(turned - 70, 360), 0, 1e-3);
    assert_near(pel_cigi_get(&a, PEL_CIGI_LOS_EXTENDED_ELEVATION),
                pel_cigi_get(&b, PEL_CIGI_LOS_EXTENDED_ELEVATION), 1e-4);
}

/* Datagrams that wait together: one edit, the newest pose, none of the orders
 * lost; one of them that is refused takes none along. */
static void what_waits_becomes_one_edit(void **state)
{
    (void)state;
    static uint8_t kept[4][2048];
    begin();
    place_ship(1, 52.6, 0);
    send();
    uint64_t edits = pel_cigi_counters(cigi)->edits;
    uint64_t revision = pel_scene_state(scene)->revision;
    for (int i = 0; i < 3; i++) {
        begin();
        place_ship(1, 53 + i, 10 * i);
        if (i == 0) {
            place_ship(7, 50, 0);
        }
        memcpy(kept[i], bytes, used);
        pel_cigi_add(cigi, kept[i], used);
    }
    assert_int_equal(pel_scene_state(scene)->revision, revision);
    begin();
    send();
    assert_int_equal(pel_cigi_counters(cigi)->edits, edits + 1);
    assert_near(entity(1)->latitude, 55, 0);
    assert_near(entity(7)->latitude, 50, 0);
    take_frame(); /* tells the newest frame */
    begin();
    place_ship(1, 91, 0); /* beyond the pole: refused */
    memcpy(kept[0], bytes, used);
    pel_cigi_add(cigi, kept[0], used);
    begin();
    place_ship(7, 51, 0);
    send();
    assert_int_equal(pel_cigi_counters(cigi)->refused_edits, 1);
    assert_near(entity(1)->latitude, 55, 0);
    assert_near(entity(7)->latitude, 51, 0);
}

static void other_versions_are_known(void **state)
{
    (void)state;
    const struct {
        uint8_t head[8];
        size_t size;
        unsigned major, minor;
        bool is;
    } cases[] = {
        { { 24, 0, 0, 0, 4, 0, 0, 0 }, 24, 4, 0, true },
        { { 0, 24, 0, 0, 4, 0, 0, 0 }, 24, 4, 0, true },
        { { 1, 16, 3, 0, 0, 0, 0x80, 0 }, 16, 3, 0, true },
        { { 1, 24, 3, 0, 0x10, 0, 0x80, 0 }, 24, 3, 1, true },
        { { 1, 16, 2, 0, 0, 0, 0, 0 }, 16, 2, 0, true },
        { { 1, 16, 1, 0, 0, 0, 0, 0 }, 16, 1, 0, true },
        { { 1, 24, 3, 0, 0x30, 0, 0x80, 0 }, 24, 3, 3, false },
        { { 7, 24, 3, 0, 0x10, 0, 0x80, 0 }, 24, 0, 0, false },
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        uint8_t datagram[24] = { 0 };
        unsigned major, minor;
        memcpy(datagram, cases[i].head, sizeof cases[i].head);
        assert_int_equal(
            pel_cigi_foreign(datagram, cases[i].size, &major, &minor),
            cases[i].is);
        assert_int_equal(major, cases[i].major);
        assert_int_equal(minor, cases[i].minor);
        assert_false(pel_cigi_foreign(datagram, 8, &major, &minor));
    }
}

/* However many lines of sight come at once, each has its answer. */
static void every_sight_is_answered(void **state)
{
    (void)state;
    unsigned got = 0;
    begin();
    for (unsigned i = 0; i < 300; i++) {
        with(PEL_CIGI_KIND_LOS_VECTOR, PEL_CIGI_LOS_VECTOR_ID, (double)i,
             PEL_CIGI_LOS_VECTOR_LATITUDE, 52.6, PEL_CIGI_LOS_VECTOR_LONGITUDE,
             5.2, PEL_CIGI_LOS_VECTOR_ALTITUDE, 25.0,
             PEL_CIGI_LOS_VECTOR_ELEVATION, -30.0,
             PEL_CIGI_LOS_VECTOR_MAX_RANGE, 1000.0, 0);
    }
    send();
    take_frame();
    for (struct pel_cigi_packet p; pel_cigi_next(&answers, &p);) {
        assert_near(pel_cigi_get(&p, PEL_CIGI_LOS_RESPONSE_ID), got, 0);
        assert_near(pel_cigi_get(&p, PEL_CIGI_LOS_RESPONSE_RANGE), 50, 6);
        got++;
    }
    assert_int_equal(got, 300);
    assert_int_equal(pel_cigi_counters(cigi)->dropped_answers, 0);
}

int main(void)
{
#define TEST(name)                                                             \
    cmocka_unit_test_setup_teardown(name, open_bridge, close_bridge)
    const struct CMUnitTest tests[] = {
        TEST(the_atmosphere_holds_without_its_model),
        TEST(a_clear_sight_has_no_range),
        TEST(the_horizon_hides),
        TEST(what_is_switched_off_ends),
        TEST(reset_takes_back),
        TEST(the_bridge_goes_with_entity_0),
        TEST(children_go_with_their_parent),
        TEST(children_move_on_their_parent),
        TEST(the_sun_stands_without_a_date),
        TEST(normals_are_in_the_axes_of_the_answer),
        TEST(what_waits_becomes_one_edit),
        TEST(other_versions_are_known),
        TEST(every_sight_is_answered),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
