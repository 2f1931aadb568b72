/* Datagrams on a real scene: one edit each, dead reckoning between them, wind,
 * AIS targets, silence and nonsense. */
#include "bridges/nmea.h"

#include <arpa/inet.h>
#include <glib.h>
#include <math.h>
#include <netinet/in.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include "base/clock.h"
#include "base/log.h"
#include "scene/scene_testkit.h"

#define KNOT (1852.0 / 3600.0)
#define near(a, b, tolerance) (fabs((a) - (b)) <= (tolerance))

struct fixture {
    struct pel_scene *scene;
    struct pel_nmea *nmea;
};

static void open_bridge(struct fixture *f, struct pel_nmea_options options)
{
    struct pel_fault fault;
    f->scene = make_scene((struct pel_scene_options){ .wave_count = 20 });
    assert_int_equal(pel_nmea_create(&options, f->scene, &f->nmea, &fault),
                     PEL_OK);
}

static void close_bridge(struct fixture *f)
{
    pel_nmea_destroy(f->nmea);
    pel_scene_destroy(f->scene);
}

static int set_up(void **state)
{
    static struct fixture f;
    struct pel_nmea_options options = pel_nmea_default_options();
    options.listen = NULL;
    options.ais = true;
    open_bridge(&f, options);
    *state = &f;
    return 0;
}

static int tear_down(void **state)
{
    close_bridge(*state);
    return 0;
}

/* Feeds bodies, NULL at the end, as one datagram with sums and CR LF. */
static void feed(struct fixture *f, const char *body, ...)
{
    char datagram[2000];
    size_t size = 0;
    va_list bodies;
    va_start(bodies, body);
    for (; body; body = va_arg(bodies, const char *)) {
        unsigned sum = 0;
        for (const char *p = body + 1; *p; p++) {
            sum ^= (unsigned char)*p;
        }
        size += (size_t)snprintf(datagram + size, sizeof datagram - size,
                                 "%s*%02X\r\n", body, sum);
    }
    va_end(bodies);
    pel_nmea_feed(f->nmea, datagram, size);
    pel_scene_settle(f->scene);
}

static void one_datagram_is_one_edit(void **state)
{
    struct fixture *f = *state;
    uint64_t before = pel_scene_state(f->scene)->revision;
    feed(f, "$GPRMC,120000,A,5300.0,N,00530.0,E,10.0,90.0,210626,,,A",
         "$HEHDT,93.5,T", "$HEROT,12.0,A", "$IIXDR,A,-4.0,D,HEEL,A,1.5,D,TRIM",
         "$WIMWD,300.0,T,,M,,N,9.0,M", NULL);
    /* but the wind's, whose sea takes longer */
    assert_int_equal(pel_scene_state(f->scene)->revision, before + 2);
    const Pelagos__Entity *e = entity_of(f->scene, 1);
    assert_true(near(e->latitude, 53, 1e-9));
    assert_true(near(e->longitude, 5.5, 1e-9));
    assert_true(near(e->speed, 10 * KNOT, 1e-9));
    assert_true(near(e->course, 90, 1e-9));
    assert_true(near(e->heading, 93.5, 1e-9));
    assert_true(near(e->turn_rate, 0.2, 1e-9));
    assert_true(near(e->roll, -4, 1e-9));
    assert_true(near(e->pitch, 1.5, 1e-9));
    const Pelagos__Sea *sea = pel_scene_state(f->scene)->sea;
    assert_true(sea->wind_speed == 9 && sea->wind_direction == 300);
    assert_int_equal(pel_nmea_counters(f->nmea)->edits, 2);
}

/* A heading between two fixes must not throw the ship back. */
static void reckons_between_fixes(void **state)
{
    struct fixture *f = *state;
    int64_t before = pel_now_ns();
    feed(f, "$GPRMC,120000,A,5300.0,N,00530.0,E,100.0,0.0,210626,,,A",
         "$HEHDT,0.0,T", NULL);
    int64_t start = pel_now_ns();
    g_usleep(200000);
    int64_t end = pel_now_ns();
    feed(f, "$HEHDT,1.0,T", NULL);
    double longest = (double)(pel_now_ns() - before) * 1e-9;
    double shortest = (double)(end - start) * 1e-9;
    const Pelagos__Entity *e = entity_of(f->scene, 1);
    /* A minute of latitude is 1855.7 m at 53 N, to a few centimetres. */
    double north_m = (e->latitude - 53) * 60 * 1855.7;
    assert_true(north_m > 100 * KNOT * shortest - 0.1);
    assert_true(north_m < 100 * KNOT * longest + 0.1);
    assert_true(near(e->heading, 1, 1e-9));
}

static void wind_said_again_is_no_news(void **state)
{
    struct fixture *f = *state;
    feed(f, "$WIMWD,300.0,T,,M,,N,9.0,M", NULL);
    Pelagos__Patch patch = PELAGOS__PATCH__INIT;
    Pelagos__State other = PELAGOS__STATE__INIT;
    Pelagos__Sea sea = PELAGOS__SEA__INIT;
    sea.has_wind_speed = 1;
    sea.wind_speed = 17;
    other.sea = &sea;
    patch.state = &other;
    assert_int_equal(pel_scene_patch(f->scene, &patch, NULL), PEL_OK);
    feed(f, "$WIMWD,300.0,T,,M,,N,9.0,M", NULL);
    assert_true(pel_scene_state(f->scene)->sea->wind_speed == 17);
    feed(f, "$WIMWD,300.0,T,,M,,N,9.5,M", NULL);
    assert_true(pel_scene_state(f->scene)->sea->wind_speed == 9.5);
}

static void mean_wind_ignores_gusts(void **state)
{
    (void)state;
    struct fixture f;
    struct pel_nmea_options options = pel_nmea_default_options();
    options.listen = NULL;
    options.wind = PEL_NMEA_WIND_MEAN;
    open_bridge(&f, options);
    /* Real time would add to the step as much as the machine is slow. */
    Pelagos__Patch patch = PELAGOS__PATCH__INIT;
    Pelagos__State other = PELAGOS__STATE__INIT;
    Pelagos__Clock clock = PELAGOS__CLOCK__INIT;
    other.clock = &clock;
    patch.state = &other;
    clock.has_mode = 1;
    clock.mode = PELAGOS__CLOCK_MODE__STEPPED;
    assert_int_equal(pel_scene_patch(f.scene, &patch, NULL), PEL_OK);
    feed(&f, "$WIMWD,300.0,T,,M,,N,9.0,M", NULL);
    assert_true(near(pel_scene_state(f.scene)->sea->wind_speed, 9, 1e-9));
    feed(&f, "$WIMWD,320.0,T,,M,,N,14.0,M", NULL);
    assert_true(near(pel_scene_state(f.scene)->sea->wind_speed, 9, 1e-9));
    /* 60 s later the mean has taken 1 - exp(-1/2) of the step. */
    clock.has_time = 1;
    clock.time = pel_scene_time(f.scene) + 60;
    assert_int_equal(pel_scene_patch(f.scene, &patch, NULL), PEL_OK);
    feed(&f, "$WIMWD,320.0,T,,M,,N,14.0,M", NULL);
    assert_true(near(pel_scene_state(f.scene)->sea->wind_speed,
                     9 + 5 * (1 - exp(-0.5)), 1e-6));
    close_bridge(&f);
    options.wind = PEL_NMEA_WIND_OFF;
    open_bridge(&f, options);
    double wind = pel_scene_state(f.scene)->sea->wind_speed;
    feed(&f, "$WIMWD,320.0,T,,M,,N,14.0,M", NULL);
    assert_true(pel_scene_state(f.scene)->sea->wind_speed == wind);
    close_bridge(&f);
}

static void ais_targets_become_entities(void **state)
{
    struct fixture *f = *state;
    size_t before = pel_scene_state(f->scene)->n_entities;
    feed(f, "!AIVDM,1,1,,B,13aDp<PP000IwSlN?Wm@0?wN2<1T,0",
         "!AIVDM,1,1,,A,B3`eLE00006R0J7Si`WQ3wP1jDkr,0", "$GPHDT,10.0,T", NULL);
    assert_int_equal(pel_scene_state(f->scene)->n_entities, before + 2);
    assert_true(near(entity_of(f->scene, 1)->heading, 10, 1e-9));
    const Pelagos__Entity *e = entity_of(f->scene, 20000);
    assert_non_null(e);
    assert_int_equal(strncmp(e->name, "mmsi-", 5), 0);
    assert_true(near(e->latitude, 53, 1) && near(e->longitude, 5.5, 1));
    struct pel_nmea_status status;
    pel_nmea_status(f->nmea, &status);
    assert_int_equal(status.targets, 2);
    feed(f, "!AIVDO,1,1,,B,13`kvwO005wJnb0Lfo:@7P8F05`L,0", NULL);
    assert_true(near(entity_of(f->scene, 1)->latitude, 50.21319, 1e-4));
}

static void more_targets_than_places(void **state)
{
    struct fixture *f = *state;
    for (int i = 0; i < 300; i++) { /* the MMSI varies in two characters */
        char body[64];
        snprintf(body, sizeof body,
                 "!AIVDM,1,1,,B,13%c%cp<PP000IwSlN?Wm@0?wN2<1T,0", '0' + i / 40,
                 '0' + i % 40);
        feed(f, body, NULL);
    }
    struct pel_nmea_status status;
    pel_nmea_status(f->nmea, &status);
    assert_int_equal(status.targets, 100);
    assert_int_equal(pel_nmea_counters(f->nmea)->targets.refused, 200);
    assert_int_equal(pel_nmea_counters(f->nmea)->targets.refused_edits, 0);
}

static void patch_own(struct fixture *f, const Pelagos__Entity *entity,
                      const Pelagos__OwnShip *own)
{
    Pelagos__Patch patch = PELAGOS__PATCH__INIT;
    Pelagos__State other = PELAGOS__STATE__INIT;
    Pelagos__Entity *entities = (Pelagos__Entity *)entity;
    other.n_entities = entity != NULL;
    other.entities = &entities;
    other.own_ship = (Pelagos__OwnShip *)own;
    patch.state = &other;
    assert_int_equal(pel_scene_patch(f->scene, &patch, NULL), PEL_OK);
}

#define SECOND 1000000000LL
#define UNDER_WAY "$GPRMC,120000,A,5300.0,N,00530.0,E,10.0,90.0,210626,,,A"

/* Dead reckoning ends 60 s after the last fix. */
static void silence_stops_what_nmea_moved(void **state)
{
    struct fixture *f = *state;
    feed(f, UNDER_WAY, "$HEROT,12.0,A", NULL);
    int64_t now = pel_now_ns();
    pel_nmea_tick(f->nmea, now + 9 * SECOND);
    assert_true(near(entity_of(f->scene, 1)->turn_rate, 0.2, 1e-9));
    pel_nmea_tick(f->nmea, now + 12 * SECOND);
    assert_true(entity_of(f->scene, 1)->turn_rate == 0);
    assert_true(near(entity_of(f->scene, 1)->speed, 10 * KNOT, 1e-9));
    assert_true(pel_scene_state(f->scene)->sources->nmea_stale);
    pel_nmea_tick(f->nmea, now + 61 * SECOND);
    assert_true(entity_of(f->scene, 1)->speed == 0);
    uint64_t before = pel_scene_state(f->scene)->revision;
    pel_nmea_tick(f->nmea, now + 62 * SECOND);
    assert_int_equal(pel_scene_state(f->scene)->revision, before);
    feed(f, UNDER_WAY, NULL);
    assert_true(near(entity_of(f->scene, 1)->speed, 10 * KNOT, 1e-9));
}

static void silence_leaves_the_ships_model_alone(void **state)
{
    struct fixture *f = *state;
    feed(f, UNDER_WAY, "$HEROT,12.0,A", "$IIXDR,A,-4.0,D,HEEL", NULL);
    int64_t now = pel_now_ns();
    Pelagos__OwnShip own = PELAGOS__OWN_SHIP__INIT;
    own.has_on = own.has_throttle = own.on = 1;
    own.throttle = 0.7;
    patch_own(f, NULL, &own);
    uint64_t edits = pel_nmea_counters(f->nmea)->edits;
    for (int s = 9; s < 200; s += 3) {
        pel_nmea_tick(f->nmea, now + s * SECOND);
    }
    assert_true(pel_scene_state(f->scene)->own_ship->on);
    assert_int_equal(pel_nmea_counters(f->nmea)->edits, edits);
    feed(f, UNDER_WAY, NULL); /* it speaks again, and leads */
    assert_false(pel_scene_state(f->scene)->own_ship->on);
}

static void silence_leaves_other_clients_alone(void **state)
{
    struct fixture *f = *state;
    feed(f, UNDER_WAY, NULL);
    int64_t now = pel_now_ns();
    Pelagos__Entity other = PELAGOS__ENTITY__INIT;
    other.has_id = other.id = 1;
    other.has_speed = other.has_turn_rate = 1;
    other.speed = 3;
    other.turn_rate = 0.5;
    patch_own(f, &other, NULL);
    for (int s = 9; s < 200; s += 3) {
        pel_nmea_tick(f->nmea, now + s * SECOND);
    }
    assert_true(entity_of(f->scene, 1)->speed == 3 &&
                entity_of(f->scene, 1)->turn_rate == 0.5);
    /* Heel by another client is no motion: NMEA's own one still ends. */
    feed(f, UNDER_WAY, "$HEROT,0.0,A", NULL);
    now = pel_now_ns();
    other = (Pelagos__Entity)PELAGOS__ENTITY__INIT;
    other.has_id = other.id = other.has_roll = 1;
    other.roll = 7;
    patch_own(f, &other, NULL);
    pel_nmea_tick(f->nmea, now + 61 * SECOND);
    assert_true(entity_of(f->scene, 1)->speed == 0 &&
                entity_of(f->scene, 1)->roll == 7);
}

/* An attitude of long ago is not said again with each fix. */
static void old_attitudes_are_not_repeated(void **state)
{
    struct fixture *f = *state;
    feed(f, UNDER_WAY, "$PASHR,120000.000,91.5,T,-4.0,1.5,0.75,0.1,0.1,0.1,1",
         NULL);
    assert_true(entity_of(f->scene, 1)->roll == -4 &&
                entity_of(f->scene, 1)->pitch == 1.5);
    assert_true(entity_of(f->scene, 1)->altitude == 0.75);
    assert_true(near(entity_of(f->scene, 1)->heading, 91.5, 1e-9));
    Pelagos__Entity other = PELAGOS__ENTITY__INIT;
    other.has_id = other.id = other.has_roll = 1;
    other.roll = 7;
    patch_own(f, &other, NULL);
    feed(f, UNDER_WAY, NULL);
    assert_true(entity_of(f->scene, 1)->roll == 7);
}

static void void_fixes_change_nothing(void **state)
{
    struct fixture *f = *state;
    feed(f, "$GPRMC,120000,A,5300.0,N,00530.0,E,0.0,,210626,,,A", NULL);
    uint64_t before = pel_scene_state(f->scene)->revision;
    feed(f, "$GPHDT,,T", "$GPGGA,,,,,,0,,,,M,,M,,", "$GPVTG,,T,,M,,N,,K,N",
         "$GPRMC,120001,V,,,,,,,210626,,,N", NULL);
    assert_int_equal(pel_scene_state(f->scene)->revision, before);
    assert_int_equal(pel_nmea_counters(f->nmea)->void_fixes, 2);
    struct pel_nmea_status status;
    pel_nmea_status(f->nmea, &status);
    assert_true(status.fix_fresh && !status.stale);
}

static uint32_t next(uint32_t *seed)
{
    *seed = *seed * 1664525 + 1013904223;
    return *seed >> 8;
}

/* A good sentence with one byte changed, cut short, or noise: never taken.
 * The sum finds each single changed byte. */
static void a_thousand_bad_datagrams(void **state)
{
    struct fixture *f = *state;
    static const char good[] =
        "$GPRMC,094737,A,5251.0093,N,00518.8170,E,5.6,230.5,200818,1.4,E,A*1F";
    uint64_t before = pel_scene_state(f->scene)->revision;
    uint32_t seed = 1;
    for (int i = 0; i < 1000; i++) {
        char bytes[300];
        size_t size = sizeof good - 1;
        memcpy(bytes, good, size);
        size_t at = next(&seed) % size;
        switch (i % 3) {
        case 0:
            do {
                bytes[at] = (char)(0x20 + next(&seed) % 0x5f);
            } while (bytes[at] == good[at]);
            break;
        case 1:
            size = 1 + next(&seed) % (size - 1);
            break;
        default:
            size = 1 + next(&seed) % sizeof bytes;
            for (size_t k = 0; k < size; k++) {
                bytes[k] = (char)(0x80 + next(&seed) % 0x80);
            }
        }
        pel_nmea_feed(f->nmea, bytes, size);
    }
    uint64_t counted = 0;
    for (int i = 0; i < PEL_NMEA_ERROR_COUNT; i++) {
        counted += pel_nmea_counters(f->nmea)->errors[i];
    }
    assert_int_equal(counted, 1000);
    assert_int_equal(pel_scene_state(f->scene)->revision, before);
}

static void listens_to_its_list_only(void **state)
{
    (void)state;
    struct fixture f;
    struct pel_nmea_options options = pel_nmea_default_options();
    options.listen = "127.0.0.1:0";
    for (int allowed = 0; allowed < 2; allowed++) {
        options.allow = allowed ? NULL : "10.0.0.0/8";
        open_bridge(&f, options);
        struct sockaddr_in to = { .sin_family = AF_INET,
                                  .sin_port = htons(pel_nmea_port(f.nmea)),
                                  .sin_addr = { htonl(INADDR_LOOPBACK) } };
        int fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
        char big[5000] = "$";
        static const char line[] = "$HEHDT,104.0,T*2A";
        sendto(fd, line, sizeof line - 1, 0, (struct sockaddr *)&to, sizeof to);
        sendto(fd, big, sizeof big, 0, (struct sockaddr *)&to, sizeof to);
        const struct pel_nmea_counters *c = pel_nmea_counters(f.nmea);
        for (int i = 0; i < 60000 && c->datagrams + c->refused_datagrams < 2;
             i++) {
            g_main_context_iteration(NULL, FALSE);
            g_usleep(1000);
        }
        assert_int_equal(c->datagrams, allowed);
        assert_int_equal(c->refused_datagrams, 2 - allowed);
        assert_int_equal(c->edits, allowed);
        close(fd);
        close_bridge(&f);
    }
}

/* A sentence may lack its checksum where that is permitted; a wrong one, or
 * half of one, is dropped all the same. */
static void checksums_may_be_optional(void **state)
{
    (void)state;
    static const struct {
        const char *line;
        bool taken, unchecked;
    } cases[] = {
        { "$GPHDT,10.0,T\r\n", true, true },
        { "$GPHDT,20.0,T  \r\n", true, true },
        { "noise$GPHDT,30.0,T\r\n", true, true },
        { "$GPHDT,40.0,T*02\r\n", false, false }, /* 06 is right */
        { "$GPHDT,50.0,T*\r\n", false, false },
        { "$GPHDT,60.0,T*0\r\n", false, false },
        { "GPHDT,70.0,T\r\n", false, false },
        { "$GPHDT,x,T\r\n", false, false },
    };
    for (int optional = 0; optional < 2; optional++) {
        struct fixture f;
        struct pel_nmea_options options = pel_nmea_default_options();
        options.listen = NULL;
        options.no_checksum = optional;
        open_bridge(&f, options);
        const struct pel_nmea_counters *c = pel_nmea_counters(f.nmea);
        for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
            uint64_t taken = c->sentences, bare = c->unchecked;
            pel_nmea_feed(f.nmea, cases[i].line, strlen(cases[i].line));
            assert_int_equal(c->sentences - taken, optional && cases[i].taken);
            assert_int_equal(c->unchecked - bare,
                             optional && cases[i].unchecked);
        }
        close_bridge(&f);
    }
}

int main(void)
{
    pel_log_set_level(PEL_LOG_ERROR);
#define TEST(name) cmocka_unit_test_setup_teardown(name, set_up, tear_down)
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(checksums_may_be_optional),
        TEST(one_datagram_is_one_edit),
        TEST(reckons_between_fixes),
        TEST(wind_said_again_is_no_news),
        cmocka_unit_test(mean_wind_ignores_gusts),
        TEST(ais_targets_become_entities),
        TEST(more_targets_than_places),
        TEST(silence_stops_what_nmea_moved),
        TEST(silence_leaves_the_ships_model_alone),
        TEST(silence_leaves_other_clients_alone),
        TEST(old_attitudes_are_not_repeated),
        TEST(void_fixes_change_nothing),
        TEST(a_thousand_bad_datagrams),
        cmocka_unit_test(listens_to_its_list_only),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
