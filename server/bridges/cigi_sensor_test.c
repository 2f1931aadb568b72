/* CIGI's sensors: what views show of them, and what their trackers answer. */
#include "bridges/cigi_testkit.h"

static void sensor(double view_id, double id, double on, double track)
{
    with(PEL_CIGI_KIND_SENSOR, PEL_CIGI_SENSOR_VIEW, view_id,
         PEL_CIGI_SENSOR_SENSOR, id, PEL_CIGI_SENSOR_ON, on,
         PEL_CIGI_SENSOR_POLARITY, 1.0, PEL_CIGI_SENSOR_GAIN, 0.75,
         PEL_CIGI_SENSOR_LEVEL, 1.5, PEL_CIGI_SENSOR_NOISE, 0.125,
         PEL_CIGI_SENSOR_TRACK, track, PEL_CIGI_SENSOR_REPLY, 1.0, 0);
}

static void a_view_shows_its_sensor(void **state)
{
    (void)state;
    assert_null(view("bridge")->sensor);
    begin();
    sensor(0, 1, 1, 0);
    send();
    const Pelagos__Sensor *s = view("bridge")->sensor;
    assert_true(s->on && s->black_hot && !s->auto_gain && !s->dropout);
    assert_near(s->gain, 0.75, 0);
    assert_near(s->level, 1, 0); /* limited */
    assert_near(s->noise, 0.125, 0);
    const struct pel_snapshot *snapshot = pel_scene_snapshot(scene);
    const struct pel_sensor *drawn = &snapshot->views[0].sensor;
    /* the negative of grey · 4^0.5 + 0.5 */
    assert_int_equal(drawn->kind, PEL_SENSOR_ON);
    assert_near(drawn->scale, -2, 1e-15);
    assert_near(drawn->offset, 0.5, 1e-15);
    pel_snapshot_unref(snapshot);
    begin();
    sensor(0, 2, 0, 0); /* another one's end */
    send();
    assert_true(view("bridge")->sensor->on);
    begin();
    sensor(0, 1, 0, 0);
    send();
    assert_false(view("bridge")->sensor->on);
    assert_near(view("bridge")->sensor->gain, 0.75, 0);
    begin();
    sensor(0, 2, 1, 0);
    sensor(0, 1, 1, 0);
    sensor(0, 2, 0, 0); /* in one datagram */
    send();
    assert_true(view("bridge")->sensor->on);
    assert_int_equal(pel_cigi_counters(cigi)->skipped_packets, 0);
    for (int i = 0; i < 70; i++) {
        begin();
        sensor(0, 100 + i, 0, 0);
        send();
    }
    assert_int_equal(pel_cigi_counters(cigi)->skipped_packets, 8);
}

static void reset_gives_the_eye_back(void **state)
{
    (void)state;
    begin();
    sensor(0, 1, 1, 0);
    send();
    assert_non_null(view("bridge")->sensor);
    used = 0;
    frame++;
    with(PEL_CIGI_KIND_IG_CONTROL, PEL_CIGI_IG_CONTROL_MAJOR, 3.0,
         PEL_CIGI_IG_CONTROL_MINOR, 3.0, PEL_CIGI_IG_CONTROL_MAGIC, 32768.0,
         PEL_CIGI_IG_CONTROL_FRAME, (double)frame, 0);
    send();
    assert_null(view("bridge")->sensor);
}

/* The next Start of Frame's only answer. */
static struct pel_cigi_packet response(double status)
{
    take_frame();
    struct pel_cigi_packet p = next_answer(PEL_CIGI_KIND_SENSOR_EXTENDED);
    no_more_answers();
    assert_near(pel_cigi_get(&p, PEL_CIGI_SENSOR_EXTENDED_STATUS), status, 0);
    assert_near(pel_cigi_get(&p, PEL_CIGI_SENSOR_EXTENDED_HOST_FRAME), frame,
                0);
    return p;
}

static void target_at(double latitude)
{
    with(PEL_CIGI_KIND_ENTITY_CONTROL, PEL_CIGI_ENTITY_CONTROL_ID, 7.0,
         PEL_CIGI_ENTITY_CONTROL_STATE, 1.0, PEL_CIGI_ENTITY_CONTROL_LATITUDE,
         latitude, PEL_CIGI_ENTITY_CONTROL_LONGITUDE, 5.23, 0);
}

static void trackers_follow_entities(void **state)
{
    (void)state;
    /* The bridge looks east from 52.6 N 5.2 E; 2 km off, 60 degrees wide. */
    begin();
    with(PEL_CIGI_KIND_ENTITY_CONTROL, PEL_CIGI_ENTITY_CONTROL_ID, 1.0,
         PEL_CIGI_ENTITY_CONTROL_STATE, 1.0, PEL_CIGI_ENTITY_CONTROL_LATITUDE,
         52.6, PEL_CIGI_ENTITY_CONTROL_LONGITUDE, 5.2,
         PEL_CIGI_ENTITY_CONTROL_YAW, 90.0, 0);
    sensor(0, 1, 1, 3);
    send();
    struct pel_cigi_packet p = response(0); /* nothing is there */
    assert_near(pel_cigi_get(&p, PEL_CIGI_SENSOR_EXTENDED_GATE_WIDTH), 0, 0);
    begin();
    target_at(52.602);
    send();
    p = response(1);
    assert_near(pel_cigi_get(&p, PEL_CIGI_SENSOR_EXTENDED_ENTITY_VALID), 1, 0);
    assert_near(pel_cigi_get(&p, PEL_CIGI_SENSOR_EXTENDED_ENTITY), 7, 0);
    /* 222 m to the left of 2033 m ahead: 6.24 degrees, from the latitude's
     * 111.28 km a degree and the longitude's 67.77. */
    assert_near(pel_cigi_get(&p, PEL_CIGI_SENSOR_EXTENDED_GATE_X), -6.24, 0.03);
    assert_near(pel_cigi_get(&p, PEL_CIGI_SENSOR_EXTENDED_LATITUDE), 52.602,
                1e-9);
    /* 100 m at 2045 m of 1.155 across 1280 pixels */
    assert_near(pel_cigi_get(&p, PEL_CIGI_SENSOR_EXTENDED_GATE_WIDTH), 54, 1);
    begin();
    target_at(52.61); /* 1113 m: 28.7 of 30 degrees, 0.95 of the half */
    send();
    response(2);
    begin();
    target_at(52.63);
    send();
    response(3);
    begin();
    target_at(52.602);
    send();
    response(3); /* until it is switched anew */
    begin();
    sensor(0, 1, 1, 4);
    send();
    response(1);
    begin();
    sensor(0, 1, 1, 2); /* scenes are not tracked */
    send();
    response(0);
    begin();
    sensor(0, 1, 1, 0);
    send();
    take_frame();
    no_more_answers();
}

int main(void)
{
#define TEST(name)                                                             \
    cmocka_unit_test_setup_teardown(name, open_bridge, close_bridge)
    const struct CMUnitTest tests[] = {
        TEST(a_view_shows_its_sensor),
        TEST(reset_gives_the_eye_back),
        TEST(trackers_follow_entities),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
