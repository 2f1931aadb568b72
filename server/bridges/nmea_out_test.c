#include "bridges/nmea_out.h"

#include <string.h>

#include "base/near.h"
#include "bridges/nmea_parse.h"

static const struct pel_nmea_report usual = {
    .unix_s = 1782043200.5, /* 2026-06-21 12:00:00.5 */
    .latitude = 52.6,
    .longitude = 5.2,
    .altitude_m = 0.3,
    .heading = 359.97,
    .course = 90,
    .turn_rate = -0.5,
    .speed_mps = 5,
    .roll = -3.25,
    .pitch = 1.5,
    .wind_from = 270,
    .wind_mps = 8,
    .depth_m = 12.5,
    .rudder = -7.5,
};

static char text[PEL_NMEA_OUT_SIZE + 1];
static size_t count;

static void write_report(const struct pel_nmea_report *r)
{
    text[pel_nmea_out_write(r, text, &count)] = 0;
}

/* Reads the sentence of this kind with our own parser. */
static struct pel_nmea_sentence find(enum pel_nmea_kind kind)
{
    struct pel_nmea_sentence s;
    for (const char *line = text; *line;) {
        size_t length = strcspn(line, "\r");
        assert_true(length + 2 <= 82);
        assert_memory_equal(line + length, "\r\n", 2);
        assert_int_equal(pel_nmea_parse(line, length, &s), PEL_NMEA_OK);
        if (s.kind == kind) {
            return s;
        }
        line += length + 2;
    }
    fail_msg("no such sentence in %s", text);
    return s;
}

static void says_what_is(void **state)
{
    (void)state;
    write_report(&usual);
    assert_int_equal(count, 11);
    assert_non_null(strstr(
        text, "$GPRMC,120000.50,A,5236.00000,N,00512.00000,E,9.72,90.0,210626,"
              ",,A*"));
    assert_non_null(strstr(text, "$GPZDA,120000.50,21,06,2026,00,00*"));
    assert_non_null(strstr(text, "$HEHDT,0.0,T*")); /* not 360.0 */
    struct pel_nmea_sentence s = find(PEL_NMEA_GGA);
    assert_near(s.latitude, 52.6, 1e-7);
    assert_near(s.longitude, 5.2, 1e-7);
    s = find(PEL_NMEA_VTG);
    assert_near(s.speed, 5, 0.005); /* a hundredth of a knot */
    s = find(PEL_NMEA_ROT);
    assert_near(s.turn_rate, -0.5, 1e-9);
    s = find(PEL_NMEA_MWD);
    assert_near(s.wind_direction, 270, 0);
    assert_near(s.wind_speed, 8, 0.005);
    s = find(PEL_NMEA_MWV); /* sailing east with it, heading north */
    assert_near(s.wind_speed, 3, 0.005);
    assert_near(s.wind_angle, 270, 0.05);
    s = find(PEL_NMEA_DPT);
    assert_near(s.depth, 12.5, 0);
    s = find(PEL_NMEA_RSA);
    assert_near(s.rudder, -7.5, 0);
    s = find(PEL_NMEA_XDR);
    assert_int_equal(s.transducer_count, 2);
    assert_near(s.transducers[0].value, 1.5, 0);
    assert_near(s.transducers[1].value, -3.25, 0);
}

static void leaves_out_what_is_not_known(void **state)
{
    (void)state;
    struct pel_nmea_report r = usual;
    r.depth_m = r.rudder = NAN;
    write_report(&r);
    assert_int_equal(count, 9);
    assert_null(strstr(text, "DPT"));
    assert_null(strstr(text, "RSA"));
}

static void extremes_fit(void **state)
{
    (void)state;
    struct pel_nmea_report r = usual;
    r.latitude = -59.9999999999; /* not 59 degrees 60 minutes */
    r.longitude = -179.9999999999;
    r.speed_mps = 200;
    r.altitude_m = -100;
    r.turn_rate = -90;
    r.roll = -180;
    r.pitch = -90;
    r.heading = -720.04;
    r.course = 1e6;
    r.depth_m = 11000;
    r.rudder = -45;
    write_report(&r);
    assert_int_equal(count, 11); /* none was too long */
    struct pel_nmea_sentence s = find(PEL_NMEA_RMC);
    assert_near(s.latitude, -60, 1e-9);
    assert_near(s.longitude, -180, 1e-9);
    assert_non_null(strstr(text, ",6000.00000,S,18000.00000,W,"));
    s = find(PEL_NMEA_HDT);
    assert_near(s.heading, 0, 0);
}

static void looks_at_the_scene(void **state)
{
    (void)state;
    struct pel_scene_options options = { .wave_count = 20 };
    struct pel_scene *scene;
    struct pel_nmea_report r;
    assert_int_equal(pel_scene_create(&options, &scene, NULL), PEL_OK);
    assert_true(pel_nmea_out_report_of(scene, 1, &r));
    assert_near(r.latitude, 52.6, 1e-9);
    assert_near(r.heading, 0, 1e-9);
    assert_near(r.wind_mps, 8, 0);
    assert_true(isnan(r.rudder));
    assert_false(pel_nmea_out_report_of(scene, 2, &r));
    pel_scene_destroy(scene);
}

static void refuses_bad_addresses(void **state)
{
    (void)state;
    static const char *const bad[] = { "", "10110", "host:0", "host name:1",
                                       "127.0.0.1:x" };
    struct pel_nmea_out *out;
    struct pel_fault fault;
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        struct pel_nmea_out_options options = { .to = bad[i],
                                                .rate_hz = 1,
                                                .entity = 1 };
        assert_int_equal(pel_nmea_out_create(&options, NULL, &out, &fault),
                         PEL_ERR_INVALID);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(says_what_is),
        cmocka_unit_test(leaves_out_what_is_not_known),
        cmocka_unit_test(extremes_fit),
        cmocka_unit_test(looks_at_the_scene),
        cmocka_unit_test(refuses_bad_addresses),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
