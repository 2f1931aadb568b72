/* Sentences of real devices, and what a bad line, a bad device or a bad person
 * may send instead. */
#include "bridges/nmea_parse.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "bridges/ais.h"
#include "bridges/nmea_values.h"

/* Decimal text to double and one or two operations: rounding only. */
#define EPS 1e-9
/* cmocka's assert_float_equal compares in single precision. */
#define assert_near(a, b, tolerance) assert_true(fabs((a) - (b)) <= (tolerance))
#define KNOT (1852.0 / 3600.0)

static enum pel_nmea_error parse(const char *text, struct pel_nmea_sentence *s)
{
    return pel_nmea_parse(text, strlen(text), s);
}

/* `body` with the right frame and sum. */
static const char *frame(const char *body)
{
    static char line[600];
    unsigned sum = 0;
    for (const char *p = body + 1; *p; p++) {
        sum ^= (unsigned char)*p;
    }
    snprintf(line, sizeof line, "%s*%02X", body, sum);
    return line;
}

static void take(struct pel_nmea_values *v, const char *body, int64_t now_ns)
{
    struct pel_nmea_sentence s;
    assert_int_equal(parse(frame(body), &s), PEL_NMEA_OK);
    pel_nmea_values_take(v, &s, now_ns);
}

static void reads_positions(void **state)
{
    (void)state;
    struct pel_nmea_sentence s;
    assert_int_equal(parse("$GPRMC,094737,A,5251.0093,N,00518.8170,E,5.6,230.5,"
                           "200818,1.4,E,A*1F",
                           &s),
                     PEL_NMEA_OK);
    assert_int_equal(s.kind, PEL_NMEA_RMC);
    assert_true(s.valid);
    assert_string_equal(s.talker, "GP");
    assert_near(s.latitude, 52 + 51.0093 / 60, EPS);
    assert_near(s.longitude, 5 + 18.8170 / 60, EPS);
    assert_near(s.speed, 5.6 * KNOT, EPS);
    assert_near(s.course, 230.5, EPS);
    assert_near(s.variation, 1.4, EPS);
    assert_near(s.utc_s, 9 * 3600 + 47 * 60 + 37, EPS);
    assert_int_equal(s.day, 20);
    assert_int_equal(s.month, 8);
    assert_int_equal(s.year, 2018);

    assert_int_equal(parse("$INRMC,194101,A,4426.1130,N,07140.5596,W,5.2,77.3,"
                           "160906,15.8,W*60",
                           &s),
                     PEL_NMEA_OK);
    assert_near(s.longitude, -(71 + 40.5596 / 60), EPS);
    assert_near(s.variation, -15.8, EPS);

    assert_int_equal(parse("$GPGGA,094737,5251.0085,N,00518.8151,E,1,12,0.60,"
                           "-4,M,46.8,M,,*4B",
                           &s),
                     PEL_NMEA_OK);
    assert_true(s.valid);
    assert_near(s.altitude, -4, EPS);
    /* No mode field: NMEA before 2.3. */
    assert_int_equal(parse("$INGLL,4426.1130,N,07140.5579,W,194102,A*2C", &s),
                     PEL_NMEA_OK);
    assert_true(s.valid);
}

static void reads_dates_of_bridge_command(void **state)
{
    (void)state;
    struct pel_nmea_sentence s;
    assert_int_equal(parse(frame("$GPRMC,120000,A,5000.0,N,00100.0,W,10.0,90.0,"
                                 "20260621,,,A"),
                           &s),
                     PEL_NMEA_OK);
    assert_int_equal(s.year, 2026);
    assert_int_equal(s.month, 6);
    assert_int_equal(s.day, 21);
}

static void reads_heading_wind_and_attitude(void **state)
{
    (void)state;
    struct pel_nmea_sentence s;
    assert_int_equal(parse("$SDHDG,229.8,,,1.3,E*36", &s), PEL_NMEA_OK);
    assert_near(s.magnetic_heading, 229.8, EPS);
    assert_true(isnan(s.deviation));
    assert_near(s.variation, 1.3, EPS);

    assert_int_equal(parse("$WIMWD,328.2,T,326.8,M,11.2,N,5.8,M*61", &s),
                     PEL_NMEA_OK);
    assert_near(s.wind_direction, 328.2, EPS);
    assert_near(s.wind_speed, 11.2 * KNOT, EPS);

    assert_int_equal(parse("$WIMWV,57.5,R,13.0,N,A*26", &s), PEL_NMEA_OK);
    assert_false(s.wind_true);
    assert_near(s.wind_angle, 57.5, EPS);

    assert_int_equal(parse("$IIXDR,C,,C,AIRTEMP,A,-1.0,D,HEEL,A,2.9,D,TRIM,P,,"
                           "B,BARO,A,-3.9,D,RUDDER*29",
                           &s),
                     PEL_NMEA_OK);
    assert_int_equal(s.transducer_count, 5);
    assert_true(isnan(s.transducers[0].value));
    assert_string_equal(s.transducers[1].name, "HEEL");
    assert_near(s.transducers[1].value, -1.0, EPS);
    assert_string_equal(s.transducers[2].name, "TRIM");

    assert_int_equal(parse(frame("$HEROT,-30.0,A"), &s), PEL_NMEA_OK);
    assert_near(s.turn_rate, -0.5, EPS);
    assert_int_equal(parse("$SDDPT,5.3,0.4,*79", &s), PEL_NMEA_OK);
    assert_near(s.depth, 5.3, EPS);
    assert_near(s.depth_offset, 0.4, EPS);
    assert_int_equal(parse("$SDDBT,18.0,f,5.4,M,3.0,F*3D", &s), PEL_NMEA_OK);
    assert_near(s.depth, 5.4, EPS);
    assert_int_equal(parse(frame("$IIRSA,-12.5,A,,V"), &s), PEL_NMEA_OK);
    assert_near(s.rudder, -12.5, EPS);
    assert_int_equal(parse(frame("$RATTM,7,1.50,45.0,T,9.0,270.0,T,0.2,5.0,N,"
                                 "x,T,,120000,A"),
                           &s),
                     PEL_NMEA_OK);
    assert_int_equal(s.target, 7);
    assert_near(s.target_range, 1.5 * 1852, 1e-6);
    assert_int_equal(parse("$GPZDA,094737,20,08,2018,-01,00*6B", &s),
                     PEL_NMEA_OK);
    assert_int_equal(s.year, 2018);
}

static void empty_fields_are_absent(void **state)
{
    (void)state;
    struct pel_nmea_sentence s;
    assert_int_equal(parse("$GPHDT,,T*1B", &s), PEL_NMEA_OK);
    assert_int_equal(s.kind, PEL_NMEA_HDT);
    assert_true(isnan(s.heading));
    assert_int_equal(parse("$GPGGA,,,,,,0,,,,M,,M,,*66", &s), PEL_NMEA_OK);
    assert_false(s.valid);
    assert_int_equal(parse("$GPVTG,,T,,M,,N,,K,N*2C", &s), PEL_NMEA_OK);
    assert_false(s.valid);
}

static void takes_tag_blocks_and_lower_case_sums(void **state)
{
    (void)state;
    struct pel_nmea_sentence s;
    assert_int_equal(parse("\\s:r3669961,c:1120959341*51\\$GPHDT,,T*1b", &s),
                     PEL_NMEA_OK);
    assert_int_equal(s.kind, PEL_NMEA_HDT);
}

static void refuses_what_is_wrong(void **state)
{
    (void)state;
    static const struct {
        const char *line;
        enum pel_nmea_error error;
    } lines[] = {
        { "", PEL_NMEA_NO_START },
        { "# a comment", PEL_NMEA_NO_START },
        { "GPHDT,,T*1B", PEL_NMEA_NO_START },
        { "!GPHDT,,T*1B", PEL_NMEA_NO_START },
        { "\\s:r36", PEL_NMEA_NO_START },
        { "\\", PEL_NMEA_NO_START },
        { "\\\\", PEL_NMEA_NO_START },
        { "$", PEL_NMEA_NO_CHECKSUM },
        { "$GPHDT,,T", PEL_NMEA_NO_CHECKSUM },
        { "$GPHDT,,T*1", PEL_NMEA_NO_CHECKSUM },
        { "$GPHDT,,T*1G", PEL_NMEA_NO_CHECKSUM },
        { "$GPHDT,,T*1B x", PEL_NMEA_NO_CHECKSUM },
        { "$GPHDT,,T*1C", PEL_NMEA_BAD_CHECKSUM },
        { "$GPHDT,,U*1B", PEL_NMEA_BAD_CHECKSUM },
        { "$GPHDT,\t,T*1B", PEL_NMEA_BAD_BYTE },
        { "$GPHDT,\xff,T*1B", PEL_NMEA_BAD_BYTE },
        { "$*00", PEL_NMEA_OK }, /* no sentence of ours */
    };
    struct pel_nmea_sentence s;
    for (size_t i = 0; i < sizeof lines / sizeof lines[0]; i++) {
        assert_int_equal(parse(lines[i].line, &s), lines[i].error);
    }
}

static void refuses_fields_that_are_no_numbers(void **state)
{
    (void)state;
    static const char *const bodies[] = {
        "$GPHDT,nan,T",
        "$GPHDT,inf,T",
        "$GPHDT,0x10,T",
        "$GPHDT,1e9,T",
        "$GPHDT,--1,T",
        "$GPHDT,.,T",
        "$GPHDT,1.2.3,T",
        "$GPHDT,1234567890123456,T",
        "$GPRMC,250000,A,,,,,,,,,,A",
        "$GPRMC,120000,A,5260.1,N,00100.0,W,,,,,,A",
        "$GPRMC,120000,A,9060.0,N,00100.0,W,,,,,,A",
        "$PASHR,120000,1.0,M,1.0,1.0,0.1",
        "$RATTM,1000,1.0,0.0,T",
        "$GPRMC,120000,A,9100.0,N,00100.0,W,,,,,,A",
        "$GPRMC,120000,A,5200.0,X,00100.0,W,,,,,,A",
        "$GPRMC,120000,A,5200.0,,00100.0,W,,,,,,A",
        "$GPRMC,120000,A,5200.0,N,18100.0,W,,,,,,A",
        "$GPRMC,120000,A,-5200.0,N,00100.0,W,,,,,,A",
        "$GPRMC,120000,A,5200.0,N,00100.0,W,,,321399,,,A",
        "$WIMWV,57.5,Q,13.0,N,A",
        "$WIMWV,57.5,R,13.0,Q,A",
        "$IIVWR,154.0,,,,7.0,M,,",
        "$IIVWR,154.0,X,,,7.0,M,,",
        "$IIVWR,184.0,R,,,7.0,M,,",
        "$IIVWR,-4.0,R,,,7.0,M,,",
        "$IIVWT,30.0,L,10.0,Q,,,,",
        "$IIVWT,30.0,L,10.0,,,,,",
        "$IIMDA,,,,,,,,,,,,,300.0,M,,,12.0,N,,",
        "$IIMDA,,,,,,,,,,,,,300.0,T,,,12.0,T,,",
        "!AIVDM,1,2,,A,15,0",
        "!AIVDM,1,1,,A,15\"5,0",
        "!AIVDM,1,1,,A,15",
        "!AIVDM,1,1,,A,,0",
        "!AIVDM",
    };
    struct pel_nmea_sentence s;
    for (size_t i = 0; i < sizeof bodies / sizeof bodies[0]; i++) {
        if (parse(frame(bodies[i]), &s) != PEL_NMEA_BAD_FIELD) {
            fail_msg("taken: %s", bodies[i]);
        }
    }
    char many[200] = "$IIXDR";
    memset(many + 6, ',', 150); /* more fields than any sentence has */
    assert_int_equal(parse(frame(many), &s), PEL_NMEA_BAD_FIELD);
}

static void long_sentences_end_at_256(void **state)
{
    (void)state;
    struct pel_nmea_sentence s;
    char body[300] = "$PXXX,";
    memset(body + 6, 'a', 256 - 3 - 6);
    assert_int_equal(parse(frame(body), &s), PEL_NMEA_OK);
    body[256 - 3] = 'a';
    assert_int_equal(parse(frame(body), &s), PEL_NMEA_TOO_LONG);
}

struct count {
    size_t lines, last;
    char text[PEL_NMEA_MAX_SENTENCE + 2];
};

static void count_line(void *user, const char *line, size_t length)
{
    struct count *c = user;
    c->lines++;
    c->last = length;
    memcpy(c->text, line, length);
    c->text[length] = 0;
}

static void cuts_streams_into_lines(void **state)
{
    (void)state;
    static const char stream[] = "$A*00\r\n\r\n$B*00\n$C*00";
    struct pel_nmea_lines lines = { 0 };
    struct count c = { 0 };
    for (size_t i = 0; i < sizeof stream - 1; i++) { /* byte by byte */
        pel_nmea_lines_feed(&lines, stream + i, 1, count_line, &c);
    }
    assert_int_equal(c.lines, 2);
    pel_nmea_lines_end(&lines, count_line, &c);
    assert_int_equal(c.lines, 3);
    assert_string_equal(c.text, "$C*00");
    for (int i = 0; i < 100000; i++) {
        pel_nmea_lines_feed(&lines, "x", 1, count_line, &c);
    }
    assert_int_equal(c.lines, 3);
    pel_nmea_lines_feed(&lines, "\n$D*00\n", 7, count_line, &c);
    assert_int_equal(c.lines, 5);
    assert_string_equal(c.text, "$D*00");
}

/* A rounded 59.99999 is 60.000: the next degree, not a lost fix. */
static void rounded_minutes_roll_over(void **state)
{
    (void)state;
    struct pel_nmea_sentence s;
    assert_int_equal(
        parse(frame("$GPGLL,5260.000,N,17960.0000,W,120000,A"), &s),
        PEL_NMEA_OK);
    assert_near(s.latitude, 53, EPS);
    assert_near(s.longitude, -180, EPS);
}

/* The sentence is what begins at the last `$` or `!`. */
static void resynchronises(void **state)
{
    (void)state;
    static const char *const lines[] = {
        "$$GPHDT,,T*1B",
        "$GPRMC,1200$GPHDT,,T*1B",
        "\xb5\x62\x01$GPHDT,,T*1B",
        "2011-06-01 12:00 $GPHDT,,T*1B",
        "\\c:1*52\\$$GPHDT,,T*1B",
    };
    struct pel_nmea_sentence s;
    for (size_t i = 0; i < sizeof lines / sizeof lines[0]; i++) {
        assert_int_equal(parse(lines[i], &s), PEL_NMEA_OK);
        assert_int_equal(s.kind, PEL_NMEA_HDT);
        assert_true(s.resynchronised);
    }
    /* A receiver's station and time behind the sum. */
    assert_int_equal(parse("$GPHDT,,T*1B,rnhjel,1325376012.83", &s),
                     PEL_NMEA_OK);
    assert_int_equal(s.kind, PEL_NMEA_HDT);
    assert_false(s.resynchronised);
}

static void reads_gns_ths_hdm_pashr(void **state)
{
    (void)state;
    struct pel_nmea_sentence s;
    assert_int_equal(parse(frame("$GNGNS,014035.00,4332.69262,S,17235.48549,E,"
                                 "RR,13,0.9,25.63,11.24,,"),
                           &s),
                     PEL_NMEA_OK);
    assert_true(s.valid);
    assert_near(s.latitude, -(43 + 32.69262 / 60), EPS);
    assert_near(s.longitude, 172 + 35.48549 / 60, EPS);
    assert_near(s.altitude, 25.63, EPS);
    assert_int_equal(parse(frame("$GNGNS,014035.00,,,,,NNN,00,,,,,"), &s),
                     PEL_NMEA_OK);
    assert_false(s.valid);
    assert_int_equal(parse(frame("$HETHS,77.5,A"), &s), PEL_NMEA_OK);
    assert_true(s.valid && s.heading == 77.5);
    assert_int_equal(parse(frame("$HETHS,77.5,V"), &s), PEL_NMEA_OK);
    assert_false(s.valid);
    assert_int_equal(parse(frame("$PASHR,130533.620,0.311,T,-80.467,-1.395,"
                                 "0.25,0.066,0.067,0.215,2,3"),
                           &s),
                     PEL_NMEA_OK);
    assert_int_equal(s.kind, PEL_NMEA_PASHR);
    assert_near(s.heading, 0.311, EPS);
    assert_near(s.roll, -80.467, EPS);
    assert_near(s.pitch, -1.395, EPS);
    assert_near(s.heave, 0.25, EPS);
    assert_int_equal(parse(frame("$PASHR,POS,2,8,124110.00,4028.58,N"), &s),
                     PEL_NMEA_OK);
    assert_int_equal(s.kind, PEL_NMEA_OTHER);

    struct pel_nmea_values v = { 0 };
    double deg;
    take(&v, "$HCHDM,90.0,M", 1); /* no variation known */
    assert_true(pel_nmea_heading(&v, 1, &deg) && deg == 90);
    take(&v, "$GPRMC,120000,A,5200.0,N,00500.0,E,0.0,,210626,3.0,W,A", 2);
    take(&v, "$HCHDM,90.0,M", 2);
    assert_true(pel_nmea_heading(&v, 2, &deg) && deg == 87);
    take(&v, "$HETHS,77.5,V", 3);
    assert_true(pel_nmea_heading(&v, 3, &deg) && deg == 87);
    take(&v, "$HETHS,77.5,A", 3);
    assert_true(pel_nmea_heading(&v, 3, &deg) && deg == 77.5);
    take(&v, "$GNGNS,120000,5300.0,N,00500.0,E,AN,9,,,,,", 20000000000);
    assert_near(v.latitude, 53, EPS);
}

/* The transponder's own report against the same ship's RMC, and a name joined
 * from two sentences. */
static void decodes_ais(void **state)
{
    (void)state;
    struct pel_nmea_sentence s, rmc;
    struct pel_ais_assembler assembler = { 0 };
    struct pel_ais ais;
    const char *payload;
    size_t length;
    assert_int_equal(
        parse("!AIVDO,1,1,,B,13`kvwO005wJnb0Lfo:@7P8F05`L,0*5B", &s),
        PEL_NMEA_OK);
    assert_int_equal(parse("$GPRMC,130711.00,A,5012.790800,N,00806.879600,W,"
                           "0.5,3.0,010611,,A*6A",
                           &rmc),
                     PEL_NMEA_OK);
    assert_int_equal(pel_ais_assemble(&assembler, &s, &payload, &length),
                     PEL_AIS_WHOLE);
    assert_true(pel_ais_decode(payload, length, &ais));
    assert_int_equal(ais.type, 1);
    /* Two receivers' fixes of one second: 1 m. */
    assert_near(ais.latitude, rmc.latitude, 1e-5);
    assert_near(ais.longitude, rmc.longitude, 1e-5);
    assert_near(ais.speed, rmc.speed, 0.05 * KNOT + EPS);
    assert_near(ais.course, rmc.course, 0.1);
    assert_near(ais.heading, 4, EPS);

    assert_int_equal(parse("!AIVDM,2,1,9,B,55R3Vn82=ILTQ3KKS>1<D60Dq@E918U<"
                           "F222221J1`?164vc03S1CCAD,0*2A",
                           &s),
                     PEL_NMEA_OK);
    assert_int_equal(pel_ais_assemble(&assembler, &s, &payload, &length),
                     PEL_AIS_WAIT);
    assert_int_equal(parse("!AIVDM,2,2,9,B,`88888888888880,2*76", &s),
                     PEL_NMEA_OK);
    assert_int_equal(pel_ais_assemble(&assembler, &s, &payload, &length),
                     PEL_AIS_WHOLE);
    assert_true(pel_ais_decode(payload, length, &ais));
    assert_string_equal(ais.name, "SEA ENTERPRISE");
    assert_int_equal(pel_ais_assemble(&assembler, &s, &payload, &length),
                     PEL_AIS_DROPPED); /* a second part without its first */
    assert_false(pel_ais_decode("1", 1, &ais));
}

static void unfinished_ais_messages_give_way(void **state)
{
    (void)state;
    struct pel_ais_assembler assembler = { 0 };
    struct pel_nmea_sentence s;
    const char *payload;
    size_t length;
    for (int i = 0; i < 1000; i++) {
        char body[64];
        snprintf(body, sizeof body, "!AIVDM,9,1,%d,%c,15,0", i % 10,
                 'A' + i % 7);
        assert_int_equal(parse(frame(body), &s), PEL_NMEA_OK);
        assert_int_equal(pel_ais_assemble(&assembler, &s, &payload, &length),
                         PEL_AIS_WAIT);
    }
}

static void ranks_heading_sources(void **state)
{
    (void)state;
    struct pel_nmea_values v = { 0 };
    const int64_t s = 1000000000;
    double deg;
    assert_false(pel_nmea_heading(&v, s, &deg));
    take(&v, "$GPVTG,100.0,T,,M,10.0,N,,K,A", s);
    assert_true(pel_nmea_heading(&v, s, &deg));
    assert_near(deg, 100, EPS); /* the course, for want of better */
    take(&v, "$SDVHW,101.0,T,99.0,M,10.0,N,,K", s);
    assert_true(pel_nmea_heading(&v, s, &deg));
    assert_near(deg, 101, EPS);
    take(&v, "$SDHDG,359.0,1.0,E,3.0,E", s);
    assert_true(pel_nmea_heading(&v, s, &deg));
    assert_near(deg, 3, EPS);
    take(&v, "$HEHDT,104.0,T", s);
    assert_true(pel_nmea_heading(&v, s, &deg));
    assert_near(deg, 104, EPS);
    take(&v, "$SDHDG,200.0,,,,", 8 * s); /* keeps the variation it had */
    assert_true(pel_nmea_heading(&v, 8 * s, &deg));
    assert_near(deg, 104, EPS);
    assert_true(pel_nmea_heading(&v, 12 * s, &deg)); /* HDT is 11 s old */
    assert_near(deg, 203, EPS);
    assert_true(pel_nmea_heading(&v, 100 * s, &deg)); /* the newest of old */
    assert_near(deg, 203, EPS);
}

static void keeps_the_last_fix(void **state)
{
    (void)state;
    struct pel_nmea_values v = { 0 };
    take(&v, "$GPRMC,120000,A,5200.0,N,00500.0,E,5.0,90.0,210626,,,A", 1);
    v.changed = 0;
    take(&v, "$GPRMC,120001,V,,,,,,,210626,,,N", 2);
    take(&v, "$GPGGA,120001,5300.0,N,00600.0,E,0,,,,M,,M,,", 3);
    take(&v, "$GPGLL,,,,,120001,V,N", 4);
    assert_int_equal(v.changed, 0);
    assert_int_equal(v.void_fixes, 3);
    assert_int_equal(v.fix_at_ns, 1);
    assert_near(v.latitude, 52, EPS);
    take(&v, "$GPRMC,120002,A,8600.0,N,00500.0,E,999.0,90.0,210626,,,A", 5);
    assert_int_equal(v.out_of_range, 1); /* 200 m/s */
    assert_near(v.latitude, 86, EPS);
}

/* A plotter's GGA and GLL say the next fix before its RMC does. */
static void takes_positions_of_one_source(void **state)
{
    (void)state;
    struct pel_nmea_values v = { 0 };
    const int64_t s = 1000000000;
    take(&v, "$GPGLL,5100.0,N,00500.0,E,120000,A,A", s);
    assert_near(v.latitude, 51, EPS);
    take(&v, "$GPRMC,120000,A,5200.0,N,00500.0,E,5.0,90.0,210626,,,A", s);
    v.changed = 0;
    take(&v, "$GPGGA,120000,5201.0,N,00500.0,E,1,,,,M,,M,,", 2 * s);
    assert_int_equal(v.changed, 0);
    assert_near(v.latitude, 52, EPS);
    take(&v, "$GPRMC,120011,V,,,,,,,210626,,,N", 12 * s);
    take(&v, "$GPGGA,120011,5203.0,N,00500.0,E,1,,,,M,,M,,", 12 * s);
    assert_near(v.latitude, 52 + 3.0 / 60, EPS);
    take(&v, "$GPGLL,5204.0,N,00500.0,E,120011,A,A", 13 * s);
    assert_near(v.latitude, 52 + 3.0 / 60, EPS);
}

static void drops_attitudes_out_of_range(void **state)
{
    (void)state;
    struct pel_nmea_values v = { 0 };
    take(&v, "$HCXDR,A,171,D,PITCH,A,-37,D,ROLL,G,367,,MAGX", 1);
    assert_int_equal(v.out_of_range, 1);
    assert_int_equal(v.pitch.at_ns, 0);
    assert_near(v.roll.value, -37, EPS);
}

/* A beam wind of 10 m/s felt on a ship that makes 10 m/s north: from 315. */
static void makes_relative_wind_true(void **state)
{
    (void)state;
    struct pel_nmea_values v = { 0 };
    double deg, mps;
    take(&v, "$HEHDT,0.0,T", 1);
    take(&v, "$GPVTG,0.0,T,,M,,N,36.0,K,A", 1);
    take(&v, "$WIMWV,315.0,R,14.142136,M,A", 1);
    assert_true(pel_nmea_wind(&v, 1, &deg, &mps));
    assert_near(mps, 10, 1e-5); /* the sentence's seventh digit */
    assert_near(deg, 270, 1e-4);
    take(&v, "$HEHDT,90.0,T", 1);
    take(&v, "$WIMWV,45.0,T,8.0,M,A", 1);
    assert_true(pel_nmea_wind(&v, 1, &deg, &mps));
    assert_near(deg, 135, EPS);
    take(&v, "$WIMWD,300.0,T,,M,,N,7.0,M", 1);
    v.changed = 0;
    take(&v, "$WIMWV,45.0,T,8.0,M,A", 1); /* MWD is there: no news */
    assert_int_equal(v.changed, 0);
    assert_true(pel_nmea_wind(&v, 1, &deg, &mps));
    assert_near(deg, 300, EPS);
    take(&v, "$WIMWD,300.0,T,,M,,N,70.0,M", 1);
    assert_int_equal(v.out_of_range, 1);
}

/* The same beam wind, and others, as older instruments send them. */
static void takes_wind_to_a_side(void **state)
{
    (void)state;
    static const struct {
        const char *text;
        double deg, mps; /* heading 0, 10 m/s north; NAN: none is taken */
    } rows[] = {
        { "$IIVWR,45.0,L,,,14.142136,M,,", 270, 10 },
        { "$IIVWR,45.0,R,27.490,N,14.1,M,50.9,K", 90, 10 },
        { "$IIVWR,45.0,R,,,,,50.911688,K", 90, 10 },
        { "$IIVWR,0.0,,,,12.0,M,,", 0, 2 },
        { "$IIVWR,,R,,,7.0,M,,", NAN, NAN },
        { "$IIVWT,030.0,L,10.0,N,5.1,M,18.5,K", 330, 10 * KNOT },
        { "$IIVWT,030.0,R,,,5.0,M,,", 30, 5 },
        { "$IIVWT,180.0,,,,5.0,M,,", 180, 5 },
        { "$IIVWT,030.0,R,,,,,,", NAN, NAN },
        { "$IIMDA,30.0,I,1.016,B,,,,,,,,,300.0,T,,,12.0,N,6.2,M", 300,
          12 * KNOT },
        { "$IIMDA,29.9,I,1.013,B,18.5,C,16.0,C,60,,10.1,C,20.0,T,,,,,6.5,M", 20,
          6.5 },
        { "$IIMDA,30.0,I,1.016,B,,,,,,,,,,,300.0,M,12.0,N,6.2,M", NAN, NAN },
    };
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        struct pel_nmea_values v = { 0 };
        double deg, mps;
        print_message("%s\n", rows[i].text);
        take(&v, "$HEHDT,0.0,T", 1);
        take(&v, "$GPVTG,0.0,T,,M,,N,36.0,K,A", 1);
        take(&v, rows[i].text, 1);
        bool has = pel_nmea_wind(&v, 1, &deg, &mps);
        assert_int_equal(has, !isnan(rows[i].mps));
        if (has) {
            assert_near(remainder(deg - rows[i].deg, 360), 0, 1e-2);
            assert_near(mps, rows[i].mps, 2e-3);
        }
    }
    /* MWD counts before MDA, VWT before VWR. */
    struct pel_nmea_values v = { 0 };
    double deg, mps;
    take(&v, "$HEHDT,0.0,T", 1);
    take(&v, "$GPVTG,0.0,T,,M,,N,36.0,K,A", 1);
    take(&v, "$IIVWR,45.0,L,,,14.142136,M,,", 1);
    take(&v, "$IIVWT,010.0,R,,,5.0,M,,", 1);
    assert_true(pel_nmea_wind(&v, 1, &deg, &mps) && deg == 10);
    take(&v, "$IIMDA,,,,,,,,,,,,,20.0,T,,,,,6.0,M", 1);
    take(&v, "$WIMWD,30.0,T,,M,,N,7.0,M", 1);
    take(&v, "$IIMDA,,,,,,,,,,,,,20.0,T,,,,,6.0,M", 1);
    assert_true(pel_nmea_wind(&v, 1, &deg, &mps) && deg == 30);
}

/* Behind the checksum, as loggers and padded datagrams leave them. */
static void passes_blanks_over(void **state)
{
    (void)state;
    static const struct {
        const char *end;
        size_t size;
    } ends[] = {
        { "", 0 },    { " ", 1 },    { "  ", 2 },      { "\t", 1 },
        { " \r", 2 }, { "\0\0", 2 }, { " ,r1,17", 7 }, { ",r1,17 ", 7 }
    };
    struct pel_nmea_sentence s;
    for (size_t i = 0; i < sizeof ends / sizeof *ends; i++) {
        char line[64];
        size_t length = strlen(frame("$HEHDT,125.0,T"));
        memcpy(line, frame("$HEHDT,125.0,T"), length);
        memcpy(line + length, ends[i].end, ends[i].size);
        assert_int_equal(pel_nmea_parse(line, length + ends[i].size, &s),
                         PEL_NMEA_OK);
        assert_near(s.heading, 125, EPS);
    }
    assert_int_equal(parse("$HEHDT,125.0,T*2 C", &s), PEL_NMEA_NO_CHECKSUM);
    assert_int_equal(parse("$HEHDT,125.0,T*", &s), PEL_NMEA_NO_CHECKSUM);
    assert_int_equal(parse("   ", &s), PEL_NMEA_NO_START);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(takes_wind_to_a_side),
        cmocka_unit_test(passes_blanks_over),
        cmocka_unit_test(reads_positions),
        cmocka_unit_test(reads_dates_of_bridge_command),
        cmocka_unit_test(reads_heading_wind_and_attitude),
        cmocka_unit_test(empty_fields_are_absent),
        cmocka_unit_test(takes_tag_blocks_and_lower_case_sums),
        cmocka_unit_test(refuses_what_is_wrong),
        cmocka_unit_test(refuses_fields_that_are_no_numbers),
        cmocka_unit_test(long_sentences_end_at_256),
        cmocka_unit_test(cuts_streams_into_lines),
        cmocka_unit_test(rounded_minutes_roll_over),
        cmocka_unit_test(resynchronises),
        cmocka_unit_test(reads_gns_ths_hdm_pashr),
        cmocka_unit_test(decodes_ais),
        cmocka_unit_test(unfinished_ais_messages_give_way),
        cmocka_unit_test(ranks_heading_sources),
        cmocka_unit_test(keeps_the_last_fix),
        cmocka_unit_test(takes_positions_of_one_source),
        cmocka_unit_test(drops_attitudes_out_of_range),
        cmocka_unit_test(makes_relative_wind_true),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
