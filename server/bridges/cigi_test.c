#include "bridges/cigi_testkit.h"
#include <stdlib.h>

#include "scene/geodesy.h"

/* --- the tests ----------------------------------------------------------- */

static void ships_move_in_both_orders(void **state)
{
    (void)state;
    for (int order = 0; order < 2; order++) {
        little = order;
        begin();
        place_ship(1, 52.61 + 0.01 * order, -90);
        place_ship(700, 52.7, 370);
        send();
        assert_near(entity(1)->latitude, 52.61 + 0.01 * order, 0);
        assert_near(entity(1)->heading, 270, 0);
        assert_near(entity(1)->roll, 3, 0);
        assert_near(entity(700)->altitude, 2, 0);
        assert_near(entity(700)->heading, 10, 0);
        take_frame();
    }
    assert_int_equal(pel_scene_state(scene)->clock->mode,
                     PELAGOS__CLOCK_MODE__HOST);
    assert_int_equal(pel_cigi_counters(cigi)->edits, 2);
}

static void nothing_older_is_applied(void **state)
{
    (void)state;
    begin_at(10);
    place_ship(1, 50, 0);
    send();
    begin_at(12);
    place_ship(1, 51, 0);
    send();
    double time_s = pel_scene_time(scene);
    begin_at(11); /* overtaken */
    place_ship(1, 52, 0);
    send();
    begin_at(12); /* again */
    place_ship(1, 53, 0);
    send();
    const struct pel_cigi_counters *c = pel_cigi_counters(cigi);
    assert_near(entity(1)->latitude, 51, 0);
    assert_near(pel_scene_time(scene), time_s, 0);
    assert_int_equal(c->late, 1);
    assert_int_equal(c->duplicate, 1);
    assert_int_equal(c->lost, 1);
    frame = 12;
    take_frame();
}

static void frame_numbers_wrap(void **state)
{
    (void)state;
    begin_at(UINT32_MAX);
    send();
    begin(); /* 0 */
    place_ship(1, 51, 0);
    send();
    assert_near(entity(1)->latitude, 51, 0);
    assert_int_equal(pel_cigi_counters(cigi)->lost, 0);
}

static void a_host_that_restarts_is_heard(void **state)
{
    (void)state;
    begin_at(5000);
    send();
    begin_at(1);
    place_ship(1, 51, 0);
    send();
    assert_near(entity(1)->latitude, 51, 0);
    take_frame();
}

static void frames_lead_time(void **state)
{
    (void)state;
    begin();
    send();
    double time_s = pel_scene_time(scene);
    begin();
    send();
    assert_near(pel_scene_time(scene), time_s + 1 / 60.0, 1e-9);
    begin_at(frame + 3); /* two lost */
    send();
    assert_near(pel_scene_time(scene), time_s + 4 / 60.0, 1e-9);
}

static void timestamps_lead_time(void **state)
{
    (void)state;
    stamped(4294967290.0, 0);
    send();
    double time_s = pel_scene_time(scene);
    stamped(994, 0); /* 1000 ticks of 10 us later, wrapped */
    send();
    assert_near(pel_scene_time(scene), time_s + 0.01, 1e-9);
    stamped(994, 0); /* stands */
    send();
    assert_near(pel_scene_time(scene), time_s + 0.01, 1e-9);
    stamped(900, 0); /* goes back: 12 h by the wrap, taken as one frame */
    send();
    assert_near(pel_scene_time(scene), time_s + 0.01 + 1 / 60.0, 1e-9);
}

static void time_goes_on_without_the_host(void **state)
{
    (void)state;
    begin();
    send();
    double time_s = pel_scene_time(scene);
    take_frame();
    assert_near(pel_scene_time(scene), time_s, 0);
    usleep(100000);
    take_frame();
    /* Two frames behind the wall clock, for at most 1 s. */
    double gone = pel_scene_time(scene) - time_s;
    assert_true(gone >= 0.1 - 2 / 60.0 && gone <= 1 + 1 / 60.0);
    begin(); /* late: its time is over, and time does not go back */
    send();
    assert_near(pel_scene_time(scene), time_s + gone, 1e-9);
    begin();
    send(); /* and goes on from there */
    assert_near(pel_scene_time(scene), time_s + gone + 1 / 60.0, 1e-9);
}

static void a_late_timestamp_waits_for_its_time(void **state)
{
    (void)state;
    stamped(0, 0);
    send();
    double time_s = pel_scene_time(scene);
    usleep(100000);
    take_frame();
    double gone = pel_scene_time(scene) - time_s;
    assert_true(gone >= 0.1 - 2 / 60.0 && gone <= 1 + 1 / 60.0);
    stamped(1000, 0); /* 10 ms: late */
    send();
    assert_near(pel_scene_time(scene), time_s + gone, 1e-9);
    stamped(110000, 0);
    send();
    assert_near(pel_scene_time(scene), time_s + 1.1, 1e-9);
}

static void another_clock_mode_is_left_alone(void **state)
{
    (void)state;
    Pelagos__Patch patch = PELAGOS__PATCH__INIT;
    Pelagos__State with_clock = PELAGOS__STATE__INIT;
    Pelagos__Clock clock = PELAGOS__CLOCK__INIT;
    begin();
    send();
    clock.has_mode = true;
    clock.mode = PELAGOS__CLOCK_MODE__STEPPED;
    with_clock.clock = &clock;
    patch.state = &with_clock;
    assert_int_equal(pel_scene_patch(scene, &patch, NULL), PEL_OK);
    double time_s = pel_scene_time(scene);
    begin();
    send();
    assert_near(pel_scene_time(scene), time_s, 0);
    assert_int_equal(pel_scene_state(scene)->clock->mode,
                     PELAGOS__CLOCK_MODE__STEPPED);
}

static void a_refused_datagram_changes_nothing(void **state)
{
    (void)state;
    begin();
    place_ship(1, 51, 0);
    send();
    begin();
    train(1, 2, 1);
    place_ship(1, 91, 0); /* no latitude */
    with(PEL_CIGI_KIND_HAT_REQUEST, PEL_CIGI_HAT_REQUEST_ID, 1.0, 0);
    send();
    const Pelagos__State *s = pel_scene_state(scene);
    assert_int_equal(pel_cigi_counters(cigi)->refused_edits, 1);
    assert_near(entity(1)->latitude, 51, 0);
    assert_int_equal(s->sea->n_wave, 0);
    take_frame();
    no_more_answers();
    begin();
    send(); /* the wave is not remembered either */
    assert_int_equal(pel_scene_state(scene)->sea->n_wave, 0);
    begin();
    train(1, 2, 1);
    send(); /* nor is it taken for old news */
    assert_int_equal(pel_scene_state(scene)->sea->n_wave, 1);
}

static void views_hang_on_entities_when_they_come(void **state)
{
    (void)state;
    begin();
    with(PEL_CIGI_KIND_VIEW_CONTROL, PEL_CIGI_VIEW_CONTROL_VIEW, 4.0,
         PEL_CIGI_VIEW_CONTROL_ENTITY, 30.0, PEL_CIGI_VIEW_CONTROL_Z_ENABLE,
         1.0, PEL_CIGI_VIEW_CONTROL_Z, -12.0, PEL_CIGI_VIEW_CONTROL_YAW_ENABLE,
         1.0, PEL_CIGI_VIEW_CONTROL_YAW, 45.0, 0);
    with(PEL_CIGI_KIND_VIEW_DEFINITION, PEL_CIGI_VIEW_DEFINITION_VIEW, 0.0,
         PEL_CIGI_VIEW_DEFINITION_GROUP, 2.0,
         PEL_CIGI_VIEW_DEFINITION_LEFT_ENABLE, 1.0,
         PEL_CIGI_VIEW_DEFINITION_LEFT, -40.0, 0);
    send();
    assert_false(view("cigi-4")->has_entity);
    assert_near(view("cigi-4")->up, 12, 0);
    assert_near(view("cigi-4")->yaw, 45, 0);
    assert_near(view("bridge")->frustum->left, -40, 0);
    assert_near(view("bridge")->frustum->right, 30, 1e-9);
    must(scene, "{\"views\":{\"cigi-4\":{\"at\":{\"latitude\":1,"
                "\"longitude\":2}}}}"); /* a place gives way */
    begin();
    place_ship(30, 52.6, 0);
    with(PEL_CIGI_KIND_VIEW_CONTROL, PEL_CIGI_VIEW_CONTROL_GROUP, 2.0,
         PEL_CIGI_VIEW_CONTROL_ENTITY, 30.0, PEL_CIGI_VIEW_CONTROL_PITCH_ENABLE,
         1.0, PEL_CIGI_VIEW_CONTROL_PITCH, -5.0, 0);
    send();
    assert_int_equal(view("cigi-4")->entity, 30);
    assert_null(view("cigi-4")->at);
    assert_int_equal(view("bridge")->entity, 30);
    assert_near(view("bridge")->pitch, -5, 0);
}

static void camera_of(const char *name, struct pel_camera *out)
{
    const struct pel_snapshot *s = pel_scene_snapshot(scene);
    int index = pel_snapshot_find_view(s, name);
    assert_true(index >= 0);
    pel_snapshot_camera(s, (size_t)index, pel_scene_time(scene), 0, 0, out);
    pel_snapshot_unref(s);
}

static void a_view_outlives_its_entity(void **state)
{
    (void)state;
    struct pel_camera before, after;
    begin();
    place_ship(1, 52.605, 77);
    with(PEL_CIGI_KIND_VIEW_CONTROL, PEL_CIGI_VIEW_CONTROL_ENTITY, 1.0,
         PEL_CIGI_VIEW_CONTROL_X_ENABLE, 1.0, PEL_CIGI_VIEW_CONTROL_X, 20.0,
         PEL_CIGI_VIEW_CONTROL_YAW_ENABLE, 1.0, PEL_CIGI_VIEW_CONTROL_YAW,
         -100.0, PEL_CIGI_VIEW_CONTROL_PITCH_ENABLE, 1.0,
         PEL_CIGI_VIEW_CONTROL_PITCH, -20.0, 0);
    send();
    camera_of("bridge", &before);
    /* One that circles about it, one that looks at it. */
    must(scene, "{\"views\":{\"circles\":{\"orbit\":{\"entity\":1}},"
                "\"looks\":{\"lookAt\":{\"entity\":1}}}}");
    begin();
    with(PEL_CIGI_KIND_ENTITY_CONTROL, PEL_CIGI_ENTITY_CONTROL_ID, 1.0,
         PEL_CIGI_ENTITY_CONTROL_STATE, 2.0, 0);
    send();
    assert_null(entity(1));
    assert_null(view("circles")->orbit);
    assert_null(view("looks")->look_at);
    camera_of("bridge", &after);
    assert_near(after.east_m, before.east_m, 1e-6);
    assert_near(after.north_m, before.north_m, 1e-6);
    assert_near(after.altitude_m, before.altitude_m, 1e-6);
    assert_near(after.world_from_camera.x.x, before.world_from_camera.x.x,
                1e-12);
    assert_near(after.world_from_camera.y.z, before.world_from_camera.y.z,
                1e-12);
    assert_near(after.world_from_camera.z.y, before.world_from_camera.z.y,
                1e-12);
}

static void rates_carry_ships_on(void **state)
{
    (void)state;
    begin();
    place_ship(1, 52.6, 90);
    with(PEL_CIGI_KIND_RATE, PEL_CIGI_RATE_ID, 1.0, PEL_CIGI_RATE_LOCAL, 1.0,
         PEL_CIGI_RATE_X, 10.0, PEL_CIGI_RATE_Z, -0.5, PEL_CIGI_RATE_YAW, 2.0,
         PEL_CIGI_RATE_ROLL, -4.0, PEL_CIGI_RATE_PITCH, 120.0, 0);
    with(PEL_CIGI_KIND_RATE, PEL_CIGI_RATE_ID, 99.0, 0); /* not there */
    send();
    /* Rolled by 3 degrees, its keel points to port. */
    double drift = -0.5 * -sin(3 * PEL_DEG);
    assert_near(entity(1)->speed, hypot(10, drift), 1e-12);
    assert_near(entity(1)->course, 90 + atan2(drift, 10) / PEL_DEG, 1e-9);
    assert_near(entity(1)->climb_rate, 0.5 * cos(3 * PEL_DEG), 1e-12);
    assert_near(entity(1)->turn_rate, 2, 0);
    assert_near(entity(1)->roll_rate, -4, 0);
    assert_near(entity(1)->pitch_rate, 90, 0); /* limited */
    assert_int_equal(pel_cigi_counters(cigi)->skipped_packets, 1);
    begin_at(frame + 60);
    place_ship(2, 52.6, 0);
    send();
    const struct pel_snapshot *s = pel_scene_snapshot(scene);
    struct pel_entity_state e;
    pel_snapshot_entity_at(s, 0, pel_scene_time(scene), &e);
    pel_snapshot_unref(s);
    assert_near(e.east_m, 10, 0.01); /* 1 s later, turned by 2 deg */
    assert_near(e.roll_rad / PEL_DEG, 3 - 4, 0.01);
    assert_near(e.altitude_m, 2 + 0.5 * cos(3 * PEL_DEG), 0.01);
}

static void attached_entities_ride_along(void **state)
{
    (void)state;
    begin();
    place_ship(1, 52.6, 90);
    with(PEL_CIGI_KIND_ENTITY_CONTROL, PEL_CIGI_ENTITY_CONTROL_ID, 2.0,
         PEL_CIGI_ENTITY_CONTROL_STATE, 1.0, PEL_CIGI_ENTITY_CONTROL_ATTACH,
         1.0, PEL_CIGI_ENTITY_CONTROL_PARENT, 1.0,
         PEL_CIGI_ENTITY_CONTROL_LATITUDE, 30.0,
         PEL_CIGI_ENTITY_CONTROL_ALTITUDE, -8.0, PEL_CIGI_ENTITY_CONTROL_YAW,
         30.0, 0);
    send();
    /* 30 m ahead of a ship that heads east: 30 m east. */
    double metre = 1 / (6378137 * PEL_DEG * cos(52.6 * PEL_DEG) * 1.0021);
    assert_near(entity(2)->longitude, 5.2 + 30 * metre, 0.5 * metre);
    assert_near(entity(2)->heading, 120, 0.3); /* roll 3 deg of the parent */
    assert_near(entity(2)->altitude, 2 + 8 * cos(3 * PEL_DEG), 1e-6);
    begin();
    place_ship(1, 52.7, 0);
    send();
    assert_near(entity(2)->latitude, 52.7 + 30 / 111200.0, 1e-5);
}

static void clamped_entities_ride_the_waves(void **state)
{
    (void)state;
    begin();
    with(PEL_CIGI_KIND_CONFORMAL, PEL_CIGI_CONFORMAL_ID, 8.0,
         PEL_CIGI_CONFORMAL_LATITUDE, 52.6, PEL_CIGI_CONFORMAL_LONGITUDE, 5.2,
         PEL_CIGI_CONFORMAL_YAW, 30.0, 0);
    send();
    for (int i = 0; i < 5; i++) {
        begin_at(frame + 20);
        send();
        const struct pel_snapshot *s = pel_scene_snapshot(scene);
        struct pel_surface_sample sample;
        pel_sea_sample(pel_snapshot_sea(s), 0, 0, pel_scene_time(scene),
                       &sample);
        pel_snapshot_unref(s);
        const Pelagos__Entity *e = entity(8);
        assert_near(e->altitude, sample.height_m, 1e-9);
        /* The mast is the normal. */
        double h = 30 * PEL_DEG, p = e->pitch * PEL_DEG, r = e->roll * PEL_DEG;
        double x = cos(h) * sin(r) - sin(h) * sin(p) * cos(r);
        assert_near(x, sample.normal.x, 1e-9);
        assert_near(cos(p) * cos(r), sample.normal.z, 1e-9);
    }
}

static void the_date_moves_the_sun(void **state)
{
    (void)state;
    begin();
    with(PEL_CIGI_KIND_CELESTIAL, PEL_CIGI_CELESTIAL_HOUR, 15.0,
         PEL_CIGI_CELESTIAL_MINUTE, 30.0, PEL_CIGI_CELESTIAL_VALID, 1.0,
         PEL_CIGI_CELESTIAL_EPHEMERIS, 1.0, PEL_CIGI_CELESTIAL_DATE, 12242025.0,
         0);
    double before_s = pel_scene_time(scene);
    send();
    const struct pel_snapshot *s = pel_scene_snapshot(scene);
    double now_s = pel_scene_time(scene), date_s = s->epoch_unix_s + now_s;
    /* 2025-12-24T15:30Z when the packet came, which was between the two; a
     * double of 1.8e9 s is exact to 2.4e-7. */
    assert_true(date_s >= 1766590200.0 - 1e-6);
    assert_true(date_s <= 1766590200.0 + (now_s - before_s) + 1e-6);
    pel_snapshot_unref(s);
    begin();
    with(PEL_CIGI_KIND_CELESTIAL, PEL_CIGI_CELESTIAL_VALID, 1.0,
         PEL_CIGI_CELESTIAL_DATE, 2302025.0, 0); /* 30 February */
    send();
    assert_int_equal(pel_cigi_counters(cigi)->refused_edits, 1);
}

static void databases_are_loaded(void **state)
{
    (void)state;
    const struct {
        double asked, told;
    } steps[] = { { 0, 0 },    { 5, -5 },   { 5, -5 }, { 0, 5 }, { 0, 5 },
                  { 9, -128 }, { 0, -128 }, { 5, -5 }, { 0, 5 } };
    for (size_t i = 0; i < sizeof steps / sizeof *steps; i++) {
        stamped(0, steps[i].asked);
        send();
        take_frame();
        assert_near(pel_cigi_get(&sof, PEL_CIGI_START_OF_FRAME_DATABASE),
                    steps[i].told, 0);
        assert_near(pel_cigi_get(&sof, PEL_CIGI_START_OF_FRAME_MINOR), 2, 0);
    }
}

static void heights_are_of_the_sea(void **state)
{
    (void)state;
    begin();
    wind(15, 30, 9000);
    send();
    begin();
    for (int type = 0; type < 3; type++) {
        with(PEL_CIGI_KIND_HAT_REQUEST, PEL_CIGI_HAT_REQUEST_ID, type + 1.0,
             PEL_CIGI_HAT_REQUEST_TYPE, (double)type,
             PEL_CIGI_HAT_REQUEST_LATITUDE, 52.6,
             PEL_CIGI_HAT_REQUEST_LONGITUDE, 5.2, PEL_CIGI_HAT_REQUEST_ALTITUDE,
             20.0, 0);
    }
    with(PEL_CIGI_KIND_HAT_REQUEST, PEL_CIGI_HAT_REQUEST_LOCAL, 1.0,
         PEL_CIGI_HAT_REQUEST_ENTITY, 999.0, 0);
    with(PEL_CIGI_KIND_ENVIRONMENT_REQUEST, PEL_CIGI_ENVIRONMENT_REQUEST_TYPE,
         5.0, PEL_CIGI_ENVIRONMENT_REQUEST_ID, 44.0,
         PEL_CIGI_ENVIRONMENT_REQUEST_LATITUDE, 52.6,
         PEL_CIGI_ENVIRONMENT_REQUEST_LONGITUDE, 5.2, 0);
    send();
    const struct pel_snapshot *s = pel_scene_snapshot(scene);
    struct pel_surface_sample sea;
    pel_sea_sample(pel_snapshot_sea(s), 0, 0, pel_scene_time(scene), &sea);
    pel_snapshot_unref(s);
    take_frame();
    struct pel_cigi_packet a = next_answer(PEL_CIGI_KIND_HAT_RESPONSE);
    assert_near(pel_cigi_get(&a, PEL_CIGI_HAT_RESPONSE_HEIGHT),
                20 - sea.height_m, 1e-9);
    assert_near(pel_cigi_get(&a, PEL_CIGI_HAT_RESPONSE_HOST_FRAME), 2, 0);
    a = next_answer(PEL_CIGI_KIND_HAT_RESPONSE);
    assert_near(pel_cigi_get(&a, PEL_CIGI_HAT_RESPONSE_HEIGHT), sea.height_m,
                1e-9);
    a = next_answer(PEL_CIGI_KIND_HAT_EXTENDED);
    assert_near(pel_cigi_get(&a, PEL_CIGI_HAT_EXTENDED_HOT), sea.height_m,
                1e-9);
    /* f32 degrees: 1e-5 of 180. */
    assert_near(pel_cigi_get(&a, PEL_CIGI_HAT_EXTENDED_ELEVATION),
                asin(sea.normal.z) / PEL_DEG, 2e-5);
    a = next_answer(PEL_CIGI_KIND_HAT_RESPONSE);
    assert_near(pel_cigi_get(&a, PEL_CIGI_HAT_RESPONSE_VALID), 0, 0);
    a = next_answer(PEL_CIGI_KIND_MARITIME_RESPONSE);
    assert_near(pel_cigi_get(&a, PEL_CIGI_MARITIME_RESPONSE_HEIGHT),
                sea.height_m, 1e-6);
    a = next_answer(PEL_CIGI_KIND_WEATHER_RESPONSE);
    assert_near(pel_cigi_get(&a, PEL_CIGI_WEATHER_RESPONSE_WIND), 15, 0);
    assert_near(pel_cigi_get(&a, PEL_CIGI_WEATHER_RESPONSE_WIND_DIRECTION), 30,
                1e-4);
    no_more_answers();
}

static void the_atmosphere_is_told_as_it_was_set(void **state)
{
    (void)state;
    begin();
    with(PEL_CIGI_KIND_ATMOSPHERE, PEL_CIGI_ATMOSPHERE_ENABLE, 1.0,
         PEL_CIGI_ATMOSPHERE_WIND, 7.0, PEL_CIGI_ATMOSPHERE_WIND_DIRECTION,
         210.0, PEL_CIGI_ATMOSPHERE_VISIBILITY, 4000.0,
         PEL_CIGI_ATMOSPHERE_VERTICAL_WIND, -2.5, PEL_CIGI_ATMOSPHERE_HUMIDITY,
         63.0, PEL_CIGI_ATMOSPHERE_TEMPERATURE, -4.5,
         PEL_CIGI_ATMOSPHERE_PRESSURE, 987.5, 0);
    send();
    begin();
    with(PEL_CIGI_KIND_ENVIRONMENT_REQUEST, PEL_CIGI_ENVIRONMENT_REQUEST_TYPE,
         4.0, PEL_CIGI_ENVIRONMENT_REQUEST_ID, 9.0,
         PEL_CIGI_ENVIRONMENT_REQUEST_LATITUDE, 52.6,
         PEL_CIGI_ENVIRONMENT_REQUEST_LONGITUDE, 5.2, 0);
    send();
    take_frame();
    struct pel_cigi_packet a = next_answer(PEL_CIGI_KIND_WEATHER_RESPONSE);
    static const struct {
        int field;
        double value;
    } told[] = {
        { PEL_CIGI_WEATHER_RESPONSE_ID, 9 },
        { PEL_CIGI_WEATHER_RESPONSE_WIND, 7 },
        { PEL_CIGI_WEATHER_RESPONSE_WIND_DIRECTION, 210 },
        { PEL_CIGI_WEATHER_RESPONSE_VISIBILITY, 4000 },
        { PEL_CIGI_WEATHER_RESPONSE_VERTICAL_WIND, -2.5 },
        { PEL_CIGI_WEATHER_RESPONSE_HUMIDITY, 63 },
        { PEL_CIGI_WEATHER_RESPONSE_TEMPERATURE, -4.5 },
        { PEL_CIGI_WEATHER_RESPONSE_PRESSURE, 987.5 },
    };
    for (size_t i = 0; i < sizeof told / sizeof *told; i++) {
        /* f32 degrees: 1e-5 of 180. */
        assert_near(pel_cigi_get(&a, told[i].field), told[i].value, 2e-5);
    }
    no_more_answers();
}

static void periodic_requests_come_again(void **state)
{
    (void)state;
    unsigned got = 0;
    begin();
    with(PEL_CIGI_KIND_HAT_REQUEST, PEL_CIGI_HAT_REQUEST_ID, 6.0,
         PEL_CIGI_HAT_REQUEST_PERIOD, 3.0, PEL_CIGI_HAT_REQUEST_LATITUDE, 52.6,
         PEL_CIGI_HAT_REQUEST_LONGITUDE, 5.2, 0);
    send();
    for (int i = 0; i < 9; i++) {
        struct pel_cigi_packet p;
        take_frame();
        while (pel_cigi_next(&answers, &p)) {
            assert_int_equal(i % 3, 0);
            got++;
        }
    }
    assert_int_equal(got, 3);
    begin();
    with(PEL_CIGI_KIND_HAT_REQUEST, PEL_CIGI_HAT_REQUEST_ID, 6.0,
         PEL_CIGI_HAT_REQUEST_LATITUDE, 52.6, PEL_CIGI_HAT_REQUEST_LONGITUDE,
         5.2, 0);
    send(); /* once, and no more */
    take_frame();
    next_answer(PEL_CIGI_KIND_HAT_RESPONSE);
    for (int i = 0; i < 4; i++) {
        no_more_answers();
        take_frame();
    }
}

static void many_answers_take_several_frames(void **state)
{
    (void)state;
    unsigned got = 0;
    begin();
    for (int i = 0; i < 1200; i++) {
        with(PEL_CIGI_KIND_HAT_REQUEST, PEL_CIGI_HAT_REQUEST_ID, (double)i,
             PEL_CIGI_HAT_REQUEST_TYPE, 2.0, PEL_CIGI_HAT_REQUEST_LATITUDE,
             52.6, PEL_CIGI_HAT_REQUEST_LONGITUDE, 5.2, 0);
    }
    send();
    for (int i = 0; i < 3; i++) {
        struct pel_cigi_packet p;
        take_frame();
        while (pel_cigi_next(&answers, &p)) {
            assert_near(pel_cigi_get(&p, PEL_CIGI_HAT_EXTENDED_ID), got, 0);
            got++;
        }
    }
    assert_int_equal(got, PEL_CIGI_MAX_QUESTIONS);
    assert_int_equal(pel_cigi_counters(cigi)->dropped_answers,
                     1200 - PEL_CIGI_MAX_QUESTIONS);
    /* It is told, once for all of them. */
    assert_int_equal(pel_cigi_counters(cigi)->told_dropped, 1);
}

static void sight(double elevation, double most, double extended)
{
    with(PEL_CIGI_KIND_LOS_VECTOR, PEL_CIGI_LOS_VECTOR_ID, 3.0,
         PEL_CIGI_LOS_VECTOR_TYPE, extended, PEL_CIGI_LOS_VECTOR_LATITUDE, 52.6,
         PEL_CIGI_LOS_VECTOR_LONGITUDE, 5.2, PEL_CIGI_LOS_VECTOR_ALTITUDE, 25.0,
         PEL_CIGI_LOS_VECTOR_ELEVATION, elevation, PEL_CIGI_LOS_VECTOR_AZIMUTH,
         60.0, PEL_CIGI_LOS_VECTOR_MAX_RANGE, most, 0);
}

static void sight_ends_at_the_waves(void **state)
{
    (void)state;
    begin();
    wind(12, 250, 9000);
    send();
    begin();
    sight(-90, 100, 1);
    sight(-8, 1000, 1);
    sight(2, 1000, 0);
    send();
    const struct pel_snapshot *s = pel_scene_snapshot(scene);
    double time_s = pel_scene_time(scene);
    struct pel_surface_sample sea;
    take_frame();
    struct pel_cigi_packet a = next_answer(PEL_CIGI_KIND_LOS_EXTENDED);
    pel_sea_sample(pel_snapshot_sea(s), 0, 0, time_s, &sea);
    assert_near(pel_cigi_get(&a, PEL_CIGI_LOS_EXTENDED_RANGE),
                25 - sea.height_m, 1e-3);
    a = next_answer(PEL_CIGI_KIND_LOS_EXTENDED);
    double range = pel_cigi_get(&a, PEL_CIGI_LOS_EXTENDED_RANGE);
    double along = range * cos(8 * PEL_DEG);
    pel_sea_sample(pel_snapshot_sea(s), along * sin(60 * PEL_DEG),
                   along * cos(60 * PEL_DEG), time_s, &sea);
    /* The Earth of the picture sinks by 2 mm until there. */
    assert_near(25 - range * sin(8 * PEL_DEG) + along * along / (2 * 6.36e6),
                sea.height_m, 1e-3);
    assert_near(pel_cigi_get(&a, PEL_CIGI_LOS_EXTENDED_ALTITUDE), sea.height_m,
                1e-3);
    a = next_answer(PEL_CIGI_KIND_LOS_RESPONSE);
    assert_near(pel_cigi_get(&a, PEL_CIGI_LOS_RESPONSE_VALID), 0, 0);
    pel_snapshot_unref(s);
}

static void of_type(double type)
{
    begin();
    with(PEL_CIGI_KIND_ENTITY_CONTROL, PEL_CIGI_ENTITY_CONTROL_ID, 9.0,
         PEL_CIGI_ENTITY_CONTROL_STATE, 1.0, PEL_CIGI_ENTITY_CONTROL_LATITUDE,
         52.6, PEL_CIGI_ENTITY_CONTROL_LONGITUDE, 5.2,
         PEL_CIGI_ENTITY_CONTROL_TYPE, type, 0);
    send();
    pel_scene_settle(scene);
}

static enum pel_err open_with_types(const char *text, struct pel_cigi **out,
                                    struct pel_fault *fault)
{
    char path[] = "/tmp/cigi_typesXXXXXX";
    int fd = mkstemp(path);
    assert_true(fd >= 0);
    assert_int_equal(write(fd, text, strlen(text)), (ssize_t)strlen(text));
    close(fd);
    struct pel_cigi_options options = pel_cigi_default_options();
    options.listen = NULL;
    options.entities = path;
    enum pel_err err = pel_cigi_create(&options, scene, out, fault);
    unlink(path);
    return err;
}

static void types_have_models(void **state)
{
    (void)state;
    pel_cigi_destroy(cigi);
    assert_int_equal(
        open_with_types("# ours\n17 {\"name\": \"tanker\", \"length\": 180}\n"
                        "\n 18\t{\"name\":\"tug\"}\r\n",
                        &cigi, NULL),
        PEL_OK);
    of_type(17);
    assert_string_equal(entity(9)->model->name, "tanker");
    assert_near(entity(9)->model->length, 180, 0);
    of_type(18);
    assert_string_equal(entity(9)->model->name, "tug");
    assert_false(entity(9)->model->has_length);
    of_type(19);
    assert_null(entity(9)->model);
    /* Removed while its model is made: it does not come back. */
    begin();
    with(PEL_CIGI_KIND_ENTITY_CONTROL, PEL_CIGI_ENTITY_CONTROL_ID, 9.0,
         PEL_CIGI_ENTITY_CONTROL_STATE, 1.0, PEL_CIGI_ENTITY_CONTROL_LATITUDE,
         52.6, PEL_CIGI_ENTITY_CONTROL_LONGITUDE, 5.2,
         PEL_CIGI_ENTITY_CONTROL_TYPE, 17.0, 0);
    pel_cigi_feed(cigi, bytes, used);
    begin();
    with(PEL_CIGI_KIND_ENTITY_CONTROL, PEL_CIGI_ENTITY_CONTROL_ID, 9.0,
         PEL_CIGI_ENTITY_CONTROL_STATE, 2.0, 0);
    send();
    pel_scene_settle(scene);
    assert_null(entity(9));
}

static void wrong_types_are_refused(void **state)
{
    (void)state;
    static const struct {
        const char *text, *says;
    } wrong[] = {
        { "17 {\"name\": \"tanker\"}\n17 {\"name\": \"tug\"}", "line 2" },
        { "70000 {\"name\": \"tanker\"}", "0 .. 65535" },
        { "17 {\"name\": \"tankr\"}", "tankr is neither" },
        { "17 {\"name\": \"tanker\", \"length\": 5}", "24.4 to" },
        { "17 {\"name\": \"tanker\", \"length\": -5}", "0.1 to 1000 m" },
        { "17 {\"nam\": \"tanker\"}", "nam" },
        { "17 {}", "wants a name" },
        { "# nothing", "no type" },
    };
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        struct pel_cigi *none;
        struct pel_fault fault = { 0 };
        assert_int_not_equal(open_with_types(wrong[i].text, &none, &fault),
                             PEL_OK);
        if (!strstr(fault.message, wrong[i].says)) {
            fail_msg("%s: %s", wrong[i].text, fault.message);
        }
    }
}

/* A tanker of 42 m beam heads north at the origin. */
static void moor_tanker(void)
{
    Pelagos__Patch patch = PELAGOS__PATCH__INIT;
    Pelagos__State to = PELAGOS__STATE__INIT;
    Pelagos__Entity e = PELAGOS__ENTITY__INIT, *list = &e;
    Pelagos__Model model = PELAGOS__MODEL__INIT;
    model.name = (char *)"tanker";
    e.has_id = e.has_latitude = e.has_longitude = 1;
    e.id = 7;
    e.latitude = 52.6;
    e.longitude = 5.2;
    e.model = &model;
    to.n_entities = 1;
    to.entities = &list;
    patch.state = &to;
    assert_int_equal(pel_scene_patch(scene, &patch, NULL), PEL_OK);
}

/* From 300 m east, towards the west; the entity that is met, or -1. */
static double look_west(double altitude, double *range)
{
    double latitude, longitude;
    pel_geo_from_local(52.6, 5.2, 300, 0, &latitude, &longitude);
    begin();
    with(PEL_CIGI_KIND_LOS_VECTOR, PEL_CIGI_LOS_VECTOR_ID, 9.0,
         PEL_CIGI_LOS_VECTOR_LATITUDE, latitude, PEL_CIGI_LOS_VECTOR_LONGITUDE,
         longitude, PEL_CIGI_LOS_VECTOR_ALTITUDE, altitude,
         PEL_CIGI_LOS_VECTOR_AZIMUTH, -90.0, PEL_CIGI_LOS_VECTOR_MAX_RANGE,
         600.0, 0);
    send();
    take_frame();
    struct pel_cigi_packet p = next_answer(PEL_CIGI_KIND_LOS_RESPONSE);
    *range = pel_cigi_get(&p, PEL_CIGI_LOS_RESPONSE_RANGE);
    return pel_cigi_get(&p, PEL_CIGI_LOS_RESPONSE_ENTITY_VALID) != 0
               ? pel_cigi_get(&p, PEL_CIGI_LOS_RESPONSE_ENTITY)
               : -1;
}

static double height_at_origin(double material)
{
    begin();
    with(PEL_CIGI_KIND_HAT_REQUEST, PEL_CIGI_HAT_REQUEST_ID, 3.0,
         PEL_CIGI_HAT_REQUEST_TYPE, 2.0, PEL_CIGI_HAT_REQUEST_LATITUDE, 52.6,
         PEL_CIGI_HAT_REQUEST_LONGITUDE, 5.2, PEL_CIGI_HAT_REQUEST_ALTITUDE,
         100.0, 0);
    send();
    take_frame();
    struct pel_cigi_packet p = next_answer(PEL_CIGI_KIND_HAT_EXTENDED);
    assert_near(pel_cigi_get(&p, PEL_CIGI_HAT_EXTENDED_MATERIAL), material, 0);
    return pel_cigi_get(&p, PEL_CIGI_HAT_EXTENDED_HOT);
}

static void ships_are_met(void **state)
{
    (void)state;
    double range;
    height_at_origin(1);
    moor_tanker();
    /* The side is plane amidships: 300 m less half the beam. */
    assert_near(look_west(4, &range), 7, 0);
    assert_near(range, 300 - 21, 0.1);
    assert_near(look_west(60, &range), -1, 0); /* above its truck */
    /* What stands there meets a level ray just below its top too. */
    double hot = height_at_origin(3);
    assert_true(hot > 4 && hot < 46);
    assert_near(look_west(hot - 0.05, &range), 7, 0);
    /* From above, in a segment that ends below the keel. */
    begin();
    with(PEL_CIGI_KIND_LOS_SEGMENT, PEL_CIGI_LOS_SEGMENT_ID, 4.0,
         PEL_CIGI_LOS_SEGMENT_TYPE, 1.0, PEL_CIGI_LOS_SEGMENT_LATITUDE, 52.6,
         PEL_CIGI_LOS_SEGMENT_LONGITUDE, 5.2, PEL_CIGI_LOS_SEGMENT_ALTITUDE,
         100.0, PEL_CIGI_LOS_SEGMENT_TO_LATITUDE, 52.6,
         PEL_CIGI_LOS_SEGMENT_TO_LONGITUDE, 5.2,
         PEL_CIGI_LOS_SEGMENT_TO_ALTITUDE, -50.0, 0);
    send();
    take_frame();
    struct pel_cigi_packet p = next_answer(PEL_CIGI_KIND_LOS_EXTENDED);
    assert_near(pel_cigi_get(&p, PEL_CIGI_LOS_EXTENDED_ENTITY_VALID), 1, 0);
    assert_near(pel_cigi_get(&p, PEL_CIGI_LOS_EXTENDED_ENTITY), 7, 0);
    assert_near(pel_cigi_get(&p, PEL_CIGI_LOS_EXTENDED_VISIBLE), 0, 0);
    assert_near(pel_cigi_get(&p, PEL_CIGI_LOS_EXTENDED_RANGE), 100 - hot, 1e-3);
    assert_near(pel_cigi_get(&p, PEL_CIGI_LOS_EXTENDED_MATERIAL), 3, 0);
}

int main(void)
{
#define TEST(name)                                                             \
    cmocka_unit_test_setup_teardown(name, open_bridge, close_bridge)
    const struct CMUnitTest tests[] = {
        TEST(ships_move_in_both_orders),
        TEST(nothing_older_is_applied),
        TEST(frame_numbers_wrap),
        TEST(a_host_that_restarts_is_heard),
        TEST(frames_lead_time),
        TEST(timestamps_lead_time),
        TEST(time_goes_on_without_the_host),
        TEST(a_late_timestamp_waits_for_its_time),
        TEST(another_clock_mode_is_left_alone),
        TEST(a_refused_datagram_changes_nothing),
        TEST(views_hang_on_entities_when_they_come),
        TEST(a_view_outlives_its_entity),
        TEST(rates_carry_ships_on),
        TEST(attached_entities_ride_along),
        TEST(clamped_entities_ride_the_waves),
        TEST(the_date_moves_the_sun),
        TEST(databases_are_loaded),
        TEST(heights_are_of_the_sea),
        TEST(the_atmosphere_is_told_as_it_was_set),
        TEST(periodic_requests_come_again),
        TEST(many_answers_take_several_frames),
        TEST(sight_ends_at_the_waves),
        TEST(ships_are_met),
        TEST(types_have_models),
        TEST(wrong_types_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
