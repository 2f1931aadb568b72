#include "bridges/nmea_traffic.h"

#include <string.h>

#include "base/near.h"
#include "base/vec.h"
#include "bridges/ais_out.h"
#include "bridges/nmea_parse.h"
#include "scene/geodesy.h"

#define KNOT (1852.0 / 3600.0)

static char text[1400];

static struct pel_nmea_writer empty(void)
{
    memset(text, 0, sizeof text);
    return (struct pel_nmea_writer){ text, sizeof text - 1, 0, 0 };
}

/* What is written, by our own reader; returns the messages. */
static int read_all(struct pel_ais *last)
{
    static struct pel_ais_assembler joined;
    int messages = 0;
    for (const char *line = text; *line;) {
        size_t length = strcspn(line, "\r"), size;
        struct pel_nmea_sentence s;
        const char *payload;
        assert_true(length + 2 <= 82);
        assert_int_equal(pel_nmea_parse(line, length, &s), PEL_NMEA_OK);
        if (pel_ais_assemble(&joined, &s, &payload, &size) == PEL_AIS_WHOLE) {
            assert_true(pel_ais_decode(payload, size, last));
            messages++;
        }
        line += length + 2;
    }
    return messages;
}

static const struct pel_ais ship = {
    .mmsi = 200000007,
    .status = 11,
    .latitude = -52.123456,
    .longitude = -5.654321,
    .speed = 7.3,
    .course = 359.96,
    .heading = 359.7,
    .turn_rate = -0.5,
    .name = "Tanker 7",
    .ship = { .type = 80,
              .bow_m = 122,
              .stern_m = 122,
              .port_m = 21,
              .starboard_m = 21,
              .draught_m = 14.5 },
};

static void positions_are_read_as_written(void **state)
{
    (void)state;
    struct pel_nmea_writer w = empty();
    struct pel_ais a;
    pel_ais_say_position(&w, &ship, 31);
    assert_int_equal(read_all(&a), 1);
    assert_int_equal(a.mmsi, ship.mmsi);
    assert_int_equal(a.status, 11);
    assert_near(a.latitude, ship.latitude, 1e-6);
    assert_near(a.longitude, ship.longitude, 1e-6);
    assert_near(a.speed, ship.speed, 0.05 * KNOT + 1e-9);
    assert_near(a.course, 0, 0.05); /* rounded up to north */
    assert_near(a.heading, 0, 0);
    /* 30 degrees a minute are 25.9 of its units, 26. */
    assert_near(a.turn_rate, -(26 / 4.733) * (26 / 4.733) / 60, 1e-6);
}

static void what_is_not_known_is_not_said(void **state)
{
    (void)state;
    struct pel_nmea_writer w = empty();
    struct pel_ais a = ship;
    a.speed = a.course = a.heading = a.turn_rate = NAN;
    pel_ais_say_position(&w, &a, 31);
    assert_int_equal(read_all(&a), 1);
    assert_true(isnan(a.speed) && isnan(a.course) && isnan(a.heading) &&
                isnan(a.turn_rate));
}

static void sizes_and_names_are_read_as_written(void **state)
{
    (void)state;
    struct pel_nmea_writer w = empty();
    struct pel_ais a;
    pel_ais_say_ship(&w, &ship, 7);
    assert_int_equal(w.count, 2);
    assert_int_equal(read_all(&a), 1);
    assert_int_equal(a.type, 5);
    assert_string_equal(a.name, "TANKER 7");
    assert_int_equal(a.ship.type, 80);
    assert_near(a.ship.bow_m, 122, 0);
    assert_near(a.ship.starboard_m, 21, 0);
    assert_near(a.ship.draught_m, 14.5, 1e-9);
}

static void aids_are_read_as_written(void **state)
{
    (void)state;
    struct pel_nmea_writer w = empty();
    struct pel_ais a = ship;
    a.mmsi = 992000040;
    a.ship.type = 24;
    pel_ais_say_aid(&w, &a, 59);
    assert_int_equal(read_all(&a), 1);
    assert_int_equal(a.type, 21);
    assert_near(a.latitude, ship.latitude, 1e-6);
    assert_int_equal(a.ship.type, 24);
    assert_false(a.ship.is_virtual);
}

/* North-east of own ship at 2 miles, crossing at a right angle: by hand. */
static void radar_targets_come_by_geometry(void **state)
{
    (void)state;
    struct pel_nmea_writer w = empty();
    struct pel_nmea_sentence s;
    struct pel_nmea_pose own = { 52.6, 5.2, 5, 0, 0, 0 };
    struct pel_nmea_pose other = { 0, 0, 5, 270, 270, 0 };
    double off = 2 * 1852.0 / sqrt(2.0);
    pel_geo_from_local(own.latitude, own.longitude, off, off, &other.latitude,
                       &other.longitude);
    pel_nmea_say_target(&w, 7, "red,hull", &own, &other, 1782043200.5);
    assert_int_equal(w.count, 1);
    assert_int_equal(pel_nmea_parse(text, strcspn(text, "\r"), &s),
                     PEL_NMEA_OK);
    assert_int_equal(s.kind, PEL_NMEA_TTM);
    assert_non_null(strstr(text, "$RATTM,07,2.00,45.0,T,9.7,270.0,T,0.00,"));
    /* 2619 m abeam and ahead, 5 m/s each: 8.7 minutes. */
    assert_non_null(strstr(text, ",8.7,N,red-hull,T,,120000.50,A*"));
}

static void classes_have_types(void **state)
{
    (void)state;
    bool aid;
    uint8_t type;
    assert_false(pel_nmea_ais_type(0, &aid, &type)); /* something else */
    assert_false(pel_nmea_ais_type(-1, &aid, &type));
    assert_false(pel_nmea_ais_type(9999, &aid, &type));
    assert_true(pel_nmea_ais_type(2, &aid, &type));
    assert_true(!aid && type == 80);
    assert_int_equal(pel_nmea_mmsi_of(7, false), 200000007);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(positions_are_read_as_written),
        cmocka_unit_test(what_is_not_known_is_not_said),
        cmocka_unit_test(sizes_and_names_are_read_as_written),
        cmocka_unit_test(aids_are_read_as_written),
        cmocka_unit_test(radar_targets_come_by_geometry),
        cmocka_unit_test(classes_have_types),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
