/* The Modbus server on a real scene: staging, commits, refusals, framing,
 * heartbeat, and more descriptors than select() can count. */
#include "bridges/modbus.h"
#include "bridges/modbus_rtu.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <glib.h>
#include <math.h>
#include <netinet/in.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

#include "base/clock.h"
#include "base/log.h"
#include "scene/scene_testkit.h"

struct fixture {
    struct pel_scene *scene;
    struct pel_modbus *modbus;
    struct pel_modbus_session *session;
    uint8_t answer[600];
    long size;
};

static void open_server(struct fixture *f, struct pel_modbus_options options)
{
    struct pel_fault fault;
    f->scene = make_scene((struct pel_scene_options){ .wave_count = 20 });
    if (pel_modbus_create(&options, f->scene, &f->modbus, &fault) != PEL_OK) {
        fail_msg("%s", fault.message);
    }
    f->session = pel_modbus_session_open(f->modbus);
}

static int set_up(void **state)
{
    static struct fixture f;
    struct pel_modbus_options options = pel_modbus_default_options();
    options.listen = NULL;
    options.heartbeat_ms = 500;
    options.extrapolate_ms = 1500;
    open_server(&f, options);
    *state = &f;
    return 0;
}

static int tear_down(void **state)
{
    struct fixture *f = *state;
    pel_modbus_session_close(f->session);
    pel_modbus_destroy(f->modbus);
    pel_scene_destroy(f->scene);
    return 0;
}

/* Feeds unit 1 a PDU; returns the function of the answer, or minus the
 * exception code. */
static int ask(struct fixture *f, const uint8_t *pdu, size_t size)
{
    uint8_t adu[300] = { 0x12, 0x34, 0, 0, 0, (uint8_t)(size + 1), 1 };
    memcpy(adu + 7, pdu, size);
    f->size = pel_modbus_session_feed(f->session, adu, size + 7, f->answer,
                                      sizeof f->answer);
    assert_true(f->size >= 9);
    assert_int_equal(f->answer[0], 0x12); /* the transaction's id */
    assert_int_equal(f->answer[1], 0x34);
    assert_int_equal(f->answer[5], f->size - 6);
    return f->answer[7] & 0x80 ? -f->answer[8] : f->answer[7];
}

static int write_words(struct fixture *f, unsigned at, size_t count,
                       const uint16_t *words)
{
    uint8_t pdu[256] = { 16, (uint8_t)(at >> 8), (uint8_t)at,
                         0,  (uint8_t)count,     (uint8_t)(2 * count) };
    for (size_t i = 0; i < count; i++) {
        pdu[6 + 2 * i] = (uint8_t)(words[i] >> 8);
        pdu[7 + 2 * i] = (uint8_t)words[i];
    }
    return ask(f, pdu, 6 + 2 * count);
}

static int write_float(struct fixture *f, unsigned at, double value)
{
    uint16_t words[2];
    pel_register_encode(PEL_TYPE_F32, PEL_MODBUS_ABCD, value, words);
    return write_words(f, at, 2, words);
}

static int write_one(struct fixture *f, unsigned at, uint16_t value)
{
    const uint8_t pdu[] = { 6, (uint8_t)(at >> 8), (uint8_t)at,
                            (uint8_t)(value >> 8), (uint8_t)value };
    return ask(f, pdu, sizeof pdu);
}

static double read_number(struct fixture *f, uint8_t function, unsigned at,
                          enum pel_register_type type)
{
    const uint8_t count = (uint8_t)pel_register_words(type);
    const uint8_t pdu[] = { function, (uint8_t)(at >> 8), (uint8_t)at, 0,
                            count };
    assert_int_equal(ask(f, pdu, sizeof pdu), function);
    uint16_t words[4];
    for (int i = 0; i < count; i++) {
        words[i] =
            (uint16_t)(f->answer[9 + 2 * i] << 8 | f->answer[10 + 2 * i]);
    }
    return pel_register_decode(type, PEL_MODBUS_ABCD, words);
}

static uint64_t revision(struct fixture *f)
{
    return pel_scene_state(f->scene)->revision;
}

static void shows_the_probe(void **state)
{
    struct fixture *f = *state;
    for (uint8_t function = 3; function <= 4; function++) {
        assert_true(read_number(f, function, 0, PEL_TYPE_U32) == PEL_PROBE_U32);
        assert_true(read_number(f, function, 2, PEL_TYPE_F32) == PEL_PROBE_F32);
    }
    assert_int_equal(write_one(f, 0, 1), -2);
}

static void stages_until_the_commit(void **state)
{
    struct fixture *f = *state;
    uint64_t before = revision(f);
    double wind = pel_scene_state(f->scene)->sea->wind_speed;
    assert_int_equal(write_float(f, 10, 14.5), 16);
    assert_int_equal(write_float(f, 64, 123), 16);
    assert_true(read_number(f, 3, 10, PEL_TYPE_F32) == 14.5);
    assert_true(read_number(f, 3, 5, PEL_TYPE_U16) == 2);
    assert_true(pel_scene_state(f->scene)->sea->wind_speed == wind);
    assert_int_equal(write_one(f, 5, 1), 6);
    assert_int_equal(revision(f), before + 1); /* together */
    const Pelagos__State *now = pel_scene_state(f->scene);
    assert_true(now->sea->wind_speed == 14.5);
    assert_true(now->entities[0]->heading == 123);
    assert_true(read_number(f, 3, 5, PEL_TYPE_U16) == 0);
    assert_true(read_number(f, 4, 4, PEL_TYPE_U32) == (double)(before + 1));
}

static void zero_forgets_the_stage(void **state)
{
    struct fixture *f = *state;
    double wind = pel_scene_state(f->scene)->sea->wind_speed;
    assert_int_equal(write_float(f, 10, 3), 16);
    assert_int_equal(write_one(f, 5, 0), 6);
    assert_true(read_number(f, 3, 10, PEL_TYPE_F32) == wind);
    assert_int_equal(write_one(f, 5, 2), -3);
}

static void commits_within_one_request(void **state)
{
    struct fixture *f = *state;
    uint16_t words[5];
    pel_register_encode(PEL_TYPE_F32, PEL_MODBUS_ABCD, 11, words);
    pel_register_encode(PEL_TYPE_F32, PEL_MODBUS_ABCD, 200, words + 2);
    words[4] = 1;
    assert_int_equal(write_words(f, 10, 5, words), 16);
    assert_true(pel_scene_state(f->scene)->sea->wind_speed == 11);
    assert_true(pel_scene_state(f->scene)->sea->wind_direction == 200);
}

static void refuses_and_changes_nothing(void **state)
{
    struct fixture *f = *state;
    uint64_t before = revision(f);
    double wind = pel_scene_state(f->scene)->sea->wind_speed;
    assert_int_equal(write_float(f, 10, 31), -3);
    assert_int_equal(write_float(f, 10, -0.001), -3);
    assert_int_equal(write_float(f, 10, NAN), -3);
    assert_int_equal(write_float(f, 10, INFINITY), -3);
    assert_int_equal(write_one(f, 26, 99), -3);   /* no such spectrum */
    assert_int_equal(write_one(f, 10, 0), -2);    /* half a value */
    assert_int_equal(write_one(f, 6, 0), -2);     /* reserved */
    assert_int_equal(write_one(f, 90, 2), -3);    /* neither no nor yes */
    assert_int_equal(write_one(f, 999, 0), -2);   /* outside */
    assert_int_equal(write_float(f, 120, 0), -2); /* no second view */
    uint16_t words[5]; /* good speed, bad direction, commit */
    pel_register_encode(PEL_TYPE_F32, PEL_MODBUS_ABCD, 9, words);
    pel_register_encode(PEL_TYPE_F32, PEL_MODBUS_ABCD, 361, words + 2);
    words[4] = 1;
    assert_int_equal(write_words(f, 10, 5, words), -3);
    assert_true(read_number(f, 3, 10, PEL_TYPE_F32) == wind);
    assert_true(read_number(f, 3, 5, PEL_TYPE_U16) == 0);
    assert_int_equal(revision(f), before);
    assert_true(isnan(read_number(f, 3, 120, PEL_TYPE_F32)));
}

/* All of the water: six coefficients with a commit in one request, and back to
 * chlorophyll by what absent values read as. */
static void water_is_described(void **state)
{
    struct fixture *f = *state;
    assert_true(isnan(read_number(f, 3, 188, PEL_TYPE_F32)));
    assert_true(read_number(f, 3, 180, PEL_TYPE_U16) == 65535);
    uint16_t words[25] = { 0 };
    for (unsigned i = 0; i < 12; i++) {
        pel_register_encode(PEL_TYPE_F32, PEL_MODBUS_ABCD, 0.25 * (i % 4),
                            words + 2 * i);
    }
    words[24] = 1;
    assert_int_equal(write_words(f, 188, 25, words), -3); /* absorption 0 */
    for (unsigned i = 0; i < 12; i++) {
        pel_register_encode(PEL_TYPE_F32, PEL_MODBUS_ABCD, 0.25 + i / 24.0,
                            words + 2 * i);
    }
    assert_int_equal(write_words(f, 188, 25, words), 16);
    const Pelagos__Water *water = pel_scene_state(f->scene)->water;
    assert_true(water->has_absorption_680 && water->absorption_680 == 0.25);
    assert_true(water->has_scattering_440 && water->has_albedo_550);
    /* Two descriptions at once are refused, one instead of the other is not. */
    assert_int_equal(write_one(f, 180, 1), 6);
    assert_int_equal(write_one(f, 212, 1), -3);
    for (unsigned i = 0; i < 6; i++) {
        assert_true(write_float(f, 188 + 2 * i, NAN) > 0);
    }
    assert_int_equal(write_one(f, 180, 1), 6);
    assert_int_equal(write_one(f, 212, 1), 6);
    water = pel_scene_state(f->scene)->water;
    assert_true(!water->has_absorption_680 && water->has_jerlov);
    assert_int_equal(write_one(f, 180, 65535), 6);
    assert_int_equal(write_one(f, 182, 2), 6); /* orders: PAPER */
    assert_int_equal(write_one(f, 182, 9), -3);
    assert_int_equal(write_float(f, 184, 7.5), 16);
    assert_int_equal(write_one(f, 212, 1), 6);
    water = pel_scene_state(f->scene)->water;
    assert_true(!water->has_jerlov && water->salinity == 7.5);
    assert_int_equal(water->orders, PELAGOS__WATER_ORDERS__PAPER);
}

/* 0.01 mg/m3 is the schema's least; single precision holds a little less. */
static void limits_are_inside(void **state)
{
    struct fixture *f = *state;
    assert_int_equal(write_float(f, 46, 0.01), 16);
    assert_int_equal(write_one(f, 49, 1), 6);
    assert_true(pel_scene_state(f->scene)->water->chlorophyll == 0.01);
}

static void sets_swell_views_and_place(void **state)
{
    struct fixture *f = *state;
    uint16_t words[2];
    assert_true(isnan(read_number(f, 3, 30, PEL_TYPE_F32)) ||
                pel_scene_state(f->scene)->sea->n_swell > 0);
    assert_int_equal(write_float(f, 30, 2.5), 16);
    assert_int_equal(write_float(f, 32, 12), 16);
    assert_int_equal(write_float(f, 100, -15), 16);
    assert_int_equal(write_one(f, 26, 1), 6);
    pel_register_encode(PEL_TYPE_I32, PEL_MODBUS_ABCD, 526543210, words);
    assert_int_equal(write_words(f, 60, 2, words), 16);
    assert_int_equal(write_one(f, 5, 1), 6);
    const Pelagos__State *now = pel_scene_state(f->scene);
    assert_int_equal(now->sea->n_swell, 1);
    assert_true(now->sea->swell[0]->height == 2.5);
    assert_true(now->sea->swell[0]->period == 12);
    assert_int_equal(now->sea->spectrum, PELAGOS__SPECTRUM_KIND__JONSWAP);
    assert_true(now->views[0]->yaw == -15);
    assert_true(fabs(now->entities[0]->latitude - 52.654321) < 1e-9);
    assert_true(read_number(f, 3, 60, PEL_TYPE_I32) == 526543210);
    assert_true(read_number(f, 3, 26, PEL_TYPE_U16) == 1);
    assert_true(fabs(read_number(f, 4, 30, PEL_TYPE_I32) - 526543210) <= 1);
}

static void hands_the_sun_to_the_clock(void **state)
{
    struct fixture *f = *state;
    const uint8_t coil_on[] = { 5, 0, 0, 0xff, 0 };
    const uint8_t commit_coil[] = { 5, 0, 1, 0xff, 0 };
    double noon = read_number(f, 3, 42, PEL_TYPE_F32);
    assert_int_equal(write_float(f, 40, 180), 16);
    assert_int_equal(write_float(f, 42, 10), 16);
    assert_int_equal(write_one(f, 49, 1), 6);
    assert_true(pel_scene_state(f->scene)->sky->sun_elevation == 10);
    assert_true(read_number(f, 3, 48, PEL_TYPE_U16) == 0);
    assert_int_equal(ask(f, coil_on, sizeof coil_on), 5);
    assert_true(read_number(f, 3, 48, PEL_TYPE_U16) == 1); /* staged */
    assert_int_equal(ask(f, commit_coil, sizeof commit_coil), 5);
    assert_false(pel_scene_state(f->scene)->sky->has_sun_elevation);
    /* The clock ran a few ms, in which the Sun moves less than this. */
    assert_true(fabs(read_number(f, 3, 42, PEL_TYPE_F32) - noon) < 0.01);
    assert_int_equal(write_one(f, 48, 0), 6); /* stay where you are */
    assert_int_equal(write_one(f, 49, 1), 6);
    assert_true(fabs(pel_scene_state(f->scene)->sky->sun_elevation - noon) <
                0.01);
}

static void masks_and_reads_in_one(void **state)
{
    struct fixture *f = *state;
    const uint8_t mask[] = { 22, 0, 26, 0, 0, 0, 1 }; /* spectrum := 1 */
    assert_int_equal(ask(f, mask, sizeof mask), 22);
    assert_true(read_number(f, 3, 26, PEL_TYPE_U16) == 1);
    const uint8_t mask_half[] = { 22, 0, 10, 0, 0, 0, 1 };
    assert_int_equal(ask(f, mask_half, sizeof mask_half), -2);
    /* Read 5 (staged) and write 26 := 0, the write first. */
    const uint8_t both[] = { 23, 0, 26, 0, 2, 0, 26, 0, 1, 2, 0, 0 };
    assert_int_equal(ask(f, both, sizeof both), 23);
    assert_int_equal(f->answer[8], 4);
    assert_int_equal(f->answer[10], 0);
}

static void refuses_bad_forms(void **state)
{
    struct fixture *f = *state;
    static const struct {
        uint8_t pdu[10];
        size_t size;
        int code;
    } requests[] = {
        { { 3, 0, 0, 0, 0 }, 5, -3 },    /* none */
        { { 3, 0, 0, 0, 126 }, 5, -3 },  /* more than fit */
        { { 3, 0, 0, 0 }, 4, -3 },       /* short */
        { { 3, 0, 0, 0, 1, 0 }, 6, -3 }, /* long */
        { { 3, 0, 239, 0, 2 }, 5, -2 },  /* over the end */
        { { 3, 0xff, 0xff, 0, 1 }, 5, -2 },
        { { 5, 0, 0, 0x12, 0x34 }, 5, -3 }, /* neither on nor off */
        { { 15, 0, 0, 0, 2, 2, 1, 1 }, 8, -3 },
        { { 16, 0, 10, 0, 2, 4, 0, 0 }, 8, -3 }, /* values missing */
        { { 16, 0, 10, 0, 2 }, 5, -3 },
        { { 16 }, 1, -3 },
        { { 23, 0, 0, 0, 1 }, 5, -3 },
        { { 7 }, 1, -1 },
        { { 0 }, 1, -1 },
        { { 0xff, 1, 2, 3 }, 4, -1 },
    };
    for (size_t i = 0; i < sizeof requests / sizeof requests[0]; i++) {
        assert_int_equal(ask(f, requests[i].pdu, requests[i].size),
                         requests[i].code);
    }
}

static void frames_a_stream(void **state)
{
    struct fixture *f = *state;
    static const uint8_t one[] = { 0, 1, 0, 0, 0, 6, 255, 3, 0, 0, 0, 1 };
    uint8_t two[sizeof one * 2];
    memcpy(two, one, sizeof one);
    memcpy(two + sizeof one, one, sizeof one);
    for (size_t i = 0; i < sizeof one; i++) { /* byte by byte */
        long size = pel_modbus_session_feed(f->session, one + i, 1, f->answer,
                                            sizeof f->answer);
        assert_int_equal(size, i + 1 < sizeof one ? 0 : 11);
    }
    assert_int_equal(pel_modbus_session_feed(f->session, two, sizeof two,
                                             f->answer, sizeof f->answer),
                     22);
    uint8_t bad[sizeof one];
    memcpy(bad, one, sizeof one);
    bad[6] = 9; /* another's unit */
    assert_int_equal(pel_modbus_session_feed(f->session, bad, sizeof bad,
                                             f->answer, sizeof f->answer),
                     9);
    assert_int_equal(f->answer[8], 11);
    static const uint8_t heads[][6] = {
        { 0, 1, 0, 1, 0, 6 },   { 0, 1, 1, 0, 0, 6 }, { 0, 1, 0, 0, 0, 1 },
        { 0, 1, 0, 0, 0, 255 }, { 0, 1, 0, 0, 1, 0 }, { 0, 1, 0, 0, 0, 0 },
    };
    for (size_t i = 0; i < sizeof heads / sizeof heads[0]; i++) {
        struct pel_modbus_session *s = pel_modbus_session_open(f->modbus);
        assert_int_equal(pel_modbus_session_feed(s, heads[i], 6, f->answer, 16),
                         -1);
        pel_modbus_session_close(s);
    }
    assert_int_equal(pel_modbus_counters(f->modbus)->malformed, 6);
}

static void run_until(struct fixture *f, enum pel_modbus_source source)
{
    int64_t end = pel_now_ns() + 60000000000LL;
    while (pel_modbus_source(f->modbus) != source && pel_now_ns() < end) {
        while (g_main_context_iteration(NULL, FALSE)) {
        }
        g_usleep(2000);
    }
}

static void silence_makes_the_source_stale(void **state)
{
    struct fixture *f = *state;
    g_usleep(600000);
    while (g_main_context_iteration(NULL, FALSE)) {
    }
    assert_int_equal(pel_modbus_source(f->modbus), PEL_MODBUS_NEVER);
    assert_int_equal(write_float(f, 70, 5), 16); /* 5 m/s */
    assert_int_equal(write_one(f, 78, 1), 6);
    assert_int_equal(write_one(f, 4, 7), 6);
    assert_true(read_number(f, 3, 4, PEL_TYPE_U16) == 7);
    assert_int_equal(pel_modbus_source(f->modbus), PEL_MODBUS_LIVE);
    assert_true(read_number(f, 4, 16, PEL_TYPE_U16) == 1);
    g_usleep(600000);
    assert_true(read_number(f, 4, 16, PEL_TYPE_U16) == 2);
    assert_true(pel_scene_state(f->scene)->entities[0]->speed == 5);
    const uint8_t alarms[] = { 2, 0, 0, 0, 5 };
    assert_int_equal(ask(f, alarms, sizeof alarms), 2);
    assert_int_equal(f->answer[9], 3); /* any, and the source */
    run_until(f, PEL_MODBUS_HELD);
    assert_int_equal(pel_modbus_source(f->modbus), PEL_MODBUS_HELD);
    assert_true(pel_scene_state(f->scene)->entities[0]->speed == 0);
    assert_int_equal(write_one(f, 4, 8), 6);
    assert_int_equal(pel_modbus_source(f->modbus), PEL_MODBUS_LIVE);
    assert_int_equal(ask(f, alarms, sizeof alarms), 2);
    assert_int_equal(f->answer[9], 0);
}

static uint32_t next(uint32_t *seed)
{
    *seed = *seed * 1664525 + 1013904223;
    return *seed >> 8;
}

/* Every one of 1,000 bad ADUs is counted, and the state stays. The function
 * and the address are drawn so that nothing legal comes out. */
static void a_thousand_bad_requests(void **state)
{
    struct fixture *f = *state;
    const struct pel_modbus_counters *c = pel_modbus_counters(f->modbus);
    uint64_t before = revision(f), counted = 0;
    uint32_t seed = 1;
    for (int i = 0; i < 1000; i++) {
        uint8_t adu[260];
        size_t size = 8 + next(&seed) % 252;
        for (size_t k = 0; k < size; k++) {
            adu[k] = (uint8_t)next(&seed);
        }
        adu[2] = adu[3] = 0;
        adu[4] = (size - 6) >> 8;
        adu[5] = (uint8_t)(size - 6);
        adu[6] = 1;
        switch (i % 4) {
        case 0:
            adu[3] = (uint8_t)(1 + next(&seed) % 255); /* protocol id */
            break;
        case 1:
            adu[4] = (uint8_t)(1 + next(&seed) % 255); /* length */
            break;
        case 2:
            adu[7] = (uint8_t)(24 + next(&seed) % 200); /* function */
            break;
        default: /* a write outside, of a wrong length or of a wild value */
            adu[7] = 16;
            adu[8] |= 0x80;
            break;
        }
        struct pel_modbus_session *s = pel_modbus_session_open(f->modbus);
        pel_modbus_session_feed(s, adu, size, f->answer, sizeof f->answer);
        pel_modbus_session_close(s);
    }
    counted = c->malformed;
    for (size_t i = 0; i < sizeof c->exceptions / sizeof c->exceptions[0];
         i++) {
        counted += c->exceptions[i];
    }
    assert_int_equal(counted, 1000);
    assert_int_equal(revision(f), before);
    assert_true(read_number(f, 3, 5, PEL_TYPE_U16) == 0);
}

static int connect_to(uint16_t port)
{
    struct sockaddr_in to = { .sin_family = AF_INET,
                              .sin_port = htons(port),
                              .sin_addr = { htonl(INADDR_LOOPBACK) } };
    int fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    assert_true(fd >= 0);
    assert_int_equal(connect(fd, (struct sockaddr *)&to, sizeof to), 0);
    return fd;
}

/* Waits for `wanted` bytes (0: for the end), at most a minute; returns how long
 * it took [ms], or -1. */
static double await(int fd, long wanted)
{
    int64_t start = pel_now_ns();
    uint8_t bytes[300];
    while (pel_now_ns() - start < 60000000000LL) {
        while (g_main_context_iteration(NULL, FALSE)) {
        }
        long n = recv(fd, bytes, sizeof bytes, MSG_DONTWAIT);
        if (n == wanted) {
            return (double)(pel_now_ns() - start) * 1e-6;
        }
        g_usleep(500);
    }
    return -1;
}

static const uint8_t good[] = { 0, 1, 0, 0, 0, 6, 1, 3, 0, 0, 0, 2 };

static void answers_above_1024_descriptors(void **state)
{
    (void)state;
    enum { HELD = 1200 };
    static int held[HELD];
    struct rlimit limit = { 4096, 4096 };
    getrlimit(RLIMIT_NOFILE, &limit);
    limit.rlim_cur = limit.rlim_max < 4096 ? limit.rlim_max : 4096;
    setrlimit(RLIMIT_NOFILE, &limit);
    for (int i = 0; i < HELD; i++) {
        held[i] = open("/dev/null", O_RDONLY | O_CLOEXEC);
        assert_true(held[i] >= 0);
    }
    struct fixture f;
    struct pel_modbus_options options = pel_modbus_default_options();
    options.listen = "127.0.0.1:0";
    open_server(&f, options);
    int fd = connect_to(pel_modbus_port(f.modbus));
    assert_true(fd > 1024);
    assert_int_equal(send(fd, good, sizeof good, 0), sizeof good);
    double ms = await(fd, 13);
    print_message("1,200 descriptors open, then an answer in %.2f ms\n", ms);
    assert_true(ms >= 0);
    for (int i = 0; i < HELD; i++) {
        close(held[i]);
    }
    close(fd);
    pel_modbus_session_close(f.session);
    pel_modbus_destroy(f.modbus);
    pel_scene_destroy(f.scene);
}

static void slow_clients_cost_nobody_else(void **state)
{
    (void)state;
    struct fixture f;
    struct pel_modbus_options options = pel_modbus_default_options();
    options.listen = "127.0.0.1:0";
    options.max_clients = 2;
    options.request_ms = 500;
    open_server(&f, options);
    int slow = connect_to(pel_modbus_port(f.modbus));
    int fast = connect_to(pel_modbus_port(f.modbus));
    assert_int_equal(send(slow, good, 9, 0), 9); /* and no more */
    assert_int_equal(send(fast, good, sizeof good, 0), sizeof good);
    assert_true(await(fast, 13) >= 0);
    int third = connect_to(pel_modbus_port(f.modbus));
    assert_true(await(third, 0) >= 0); /* closed: two are taken */
    assert_int_equal(pel_modbus_counters(f.modbus)->refused_clients, 1);
    /* 500 ms from the first byte, looked at every 100 ms. */
    assert_true(await(slow, 0) >= 0);
    assert_int_equal(pel_modbus_counters(f.modbus)->late, 1);
    assert_int_equal(send(fast, good, sizeof good, 0), sizeof good);
    assert_true(await(fast, 13) >= 0);
    close(slow);
    close(fast);
    close(third);
    pel_modbus_session_close(f.session);
    pel_modbus_destroy(f.modbus);
    pel_scene_destroy(f.scene);
}

static void refuses_open_doors_and_bad_options(void **state)
{
    struct fixture *f = *state;
    struct pel_modbus *none = NULL;
    struct pel_fault fault;
    struct pel_modbus_options o = pel_modbus_default_options();
    o.listen = "0.0.0.0:0";
    assert_int_equal(pel_modbus_create(&o, f->scene, &none, &fault),
                     PEL_ERR_INVALID);
    o.allow = "10.0.0.0/33";
    assert_int_equal(pel_modbus_create(&o, f->scene, &none, &fault),
                     PEL_ERR_INVALID);
    o.allow = "10.0.0.0/8"; /* then loopback is not in the list */
    assert_int_equal(pel_modbus_create(&o, f->scene, &none, &fault), PEL_OK);
    int fd = connect_to(pel_modbus_port(none));
    assert_true(await(fd, 0) >= 0);
    close(fd);
    pel_modbus_destroy(none);
    o.listen = "127.0.0.1";
    assert_int_equal(pel_modbus_create(&o, f->scene, &none, &fault),
                     PEL_ERR_INVALID);
    o = pel_modbus_default_options();
    o.max_clients = 0;
    assert_int_equal(pel_modbus_create(&o, f->scene, &none, &fault),
                     PEL_ERR_INVALID);
}

/* Where there are none they say so, and refuse. */
static void exercises_are_none(void **state)
{
    struct fixture *f = *state;
    assert_true(read_number(f, 4, 40, PEL_TYPE_U16) == 0);
    assert_true(read_number(f, 4, 41, PEL_TYPE_U16) == UINT16_MAX);
    assert_true(read_number(f, 4, 42, PEL_TYPE_F64) == 0);
    assert_true(read_number(f, 4, 49, PEL_TYPE_U16) == 0);
    assert_true(read_number(f, 3, 222, PEL_TYPE_U16) == UINT16_MAX);
    assert_int_equal(write_one(f, 222, 0), -3);
    assert_int_equal(write_one(f, 222, UINT16_MAX), 6);
    for (uint16_t action = 6; action <= 10; action++) {
        assert_int_equal(write_one(f, 223, action), -3);
    }
    assert_true(read_number(f, 3, 223, PEL_TYPE_U16) == 0);
    assert_int_equal(write_float(f, 220, 12.5), 16);
    assert_true(read_number(f, 3, 220, PEL_TYPE_F32) == 12.5);
    assert_int_equal(write_one(f, 221, 1), -2); /* half a number */
}

/* --- identification ---------------------------------------------------------
 */

static size_t identify(struct fixture *f, uint8_t code, uint8_t object)
{
    const uint8_t adu[] = { 0, 9, 0, 0, 0, 5, 1, 0x2b, 0x0e, code, object };
    f->size = pel_modbus_session_feed(f->session, adu, sizeof adu, f->answer,
                                      sizeof f->answer);
    assert_true(f->size > 8);
    assert_int_equal(f->answer[1], 9);
    assert_int_equal(f->answer[4] << 8 | f->answer[5], f->size - 6);
    return (size_t)f->size;
}

static void says_what_it_is(void **state)
{
    struct fixture *f = *state;
    const uint8_t *pdu = f->answer + 7;
    size_t size = identify(f, 1, 0);
    static const uint8_t head[] = { 0x2b, 0x0e, 1, 0x82, 0, 0, 3, 0, 7, 'P' };
    assert_memory_equal(pdu, head, sizeof head);
    const uint8_t *at = pdu + 7, *end = f->answer + size;
    static const char *const basic[] = { "Pelagos", "pelagosd", PEL_VERSION };
    for (uint8_t id = 0; id < 3; id++) {
        assert_int_equal(at[0], id);
        assert_int_equal(at[1], strlen(basic[id]));
        assert_memory_equal(at + 2, basic[id], at[1]);
        at += 2 + at[1];
    }
    assert_ptr_equal(at, end);
    identify(f, 2, 0); /* regular: all seven */
    assert_int_equal(pdu[6], 7);
    identify(f, 3, 0); /* extended: as much as there is */
    assert_int_equal(pdu[6], 7);
    identify(f, 2, 4); /* from there on */
    assert_int_equal(pdu[6], 3);
    assert_int_equal(pdu[7], 4);
    identify(f, 1, 200); /* no such object: from the first */
    assert_int_equal(pdu[6], 3);
    assert_int_equal(pdu[7], 0);
    identify(f, 4, 2);
    assert_int_equal(pdu[6], 1);
    assert_int_equal(pdu[7], 2);
    assert_memory_equal(pdu + 9, PEL_VERSION, pdu[8]);
    static const struct {
        uint8_t code, object, exception;
    } bad[] = { { 0, 0, 3 }, { 5, 0, 3 }, { 4, 7, 2 }, { 4, 255, 2 } };
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        identify(f, bad[i].code, bad[i].object);
        assert_int_equal(pdu[0], 0xab);
        assert_int_equal(pdu[1], bad[i].exception);
    }
    static const uint8_t other[] = { 0, 9, 0, 0, 0, 5, 1, 0x2b, 0x0d, 1, 0 };
    assert_int_equal(pel_modbus_session_feed(f->session, other, sizeof other,
                                             f->answer, sizeof f->answer),
                     9);
    assert_int_equal(pdu[1], 1);
}

/* --- RTU over TCP -----------------------------------------------------------
 */

static int set_up_rtu(void **state)
{
    static struct fixture f;
    struct pel_modbus_options options = pel_modbus_default_options();
    options.listen = NULL;
    options.rtu = true;
    options.units = "1,2";
    open_server(&f, options);
    *state = &f;
    return 0;
}

/* A frame of these bytes and their CRC; what came of it. */
static long frame(struct fixture *f, const uint8_t *bytes, size_t size,
                  bool in_pieces)
{
    uint8_t whole[300];
    uint16_t crc = pel_modbus_crc(bytes, size);
    memcpy(whole, bytes, size);
    whole[size] = (uint8_t)crc;
    whole[size + 1] = (uint8_t)(crc >> 8);
    f->size = 0;
    for (size_t i = 0; in_pieces && i < size + 2 && f->size == 0; i++) {
        f->size = pel_modbus_session_feed(f->session, whole + i, 1, f->answer,
                                          sizeof f->answer);
        assert_true(f->size == 0 || i == size + 1);
    }
    if (!in_pieces) {
        f->size = pel_modbus_session_feed(f->session, whole, size + 2,
                                          f->answer, sizeof f->answer);
    }
    if (f->size > 2) {
        size_t body = (size_t)f->size - 2;
        crc = pel_modbus_crc(f->answer, body);
        assert_int_equal(f->answer[body], crc & 0xff);
        assert_int_equal(f->answer[body + 1], crc >> 8);
    }
    return f->size;
}
#define FRAME(in_pieces, ...)                                                  \
    frame(f, (const uint8_t[]){ __VA_ARGS__ },                                 \
          sizeof(const uint8_t[]){ __VA_ARGS__ }, in_pieces)

static void speaks_rtu(void **state)
{
    struct fixture *f = *state;
    /* The example of the specification's appendix B. */
    assert_int_equal(pel_modbus_crc((const uint8_t[]){ 2, 7 }, 2), 0x1241);
    for (int pieces = 0; pieces < 2; pieces++) {
        assert_int_equal(FRAME(pieces, 1, 3, 0, 0, 0, 2), 9); /* the probe */
        static const uint8_t probe[] = { 1, 3, 4, 1, 2, 3, 4 };
        assert_memory_equal(f->answer, probe, sizeof probe);
        assert_int_equal(FRAME(pieces, 2, 6, 0, 5, 0, 0), 8);
        assert_int_equal(FRAME(pieces, 1, 16, 0, 10, 0, 2, 4, 0x41, 0x20, 0, 0),
                         8);
        assert_int_equal(FRAME(pieces, 1, 22, 0, 5, 0xff, 0xff, 0, 0), 10);
        assert_int_equal(FRAME(pieces, 1, 23, 0, 0, 0, 2, 0, 5, 0, 1, 2, 0, 0),
                         9);
        assert_true(FRAME(pieces, 1, 17) > 4);
        assert_true(FRAME(pieces, 1, 0x2b, 0x0e, 1, 0) > 20);
        assert_int_equal(FRAME(pieces, 1, 0x2b, 0x0d, 1), 5);
        assert_int_equal(FRAME(pieces, 1, 99, 1, 2, 3), 5); /* unknown */
        assert_int_equal(f->answer[1], 99 | 0x80);
        assert_int_equal(f->answer[2], 1);
        assert_int_equal(FRAME(pieces, 1, 3, 0xff, 0, 0, 2), 5); /* address */
        assert_int_equal(f->answer[2], 2);
    }
    /* Nobody answers for a unit that is not there, nor for all of them. */
    uint64_t wrong = pel_modbus_counters(f->modbus)->wrong_unit;
    assert_int_equal(FRAME(false, 9, 3, 0, 0, 0, 2), 0);
    assert_int_equal(pel_modbus_counters(f->modbus)->wrong_unit, wrong + 1);
    uint64_t heard = pel_modbus_counters(f->modbus)->heartbeats;
    assert_int_equal(FRAME(false, 0, 6, 0, 4, 0, 1), 0);
    assert_int_equal(pel_modbus_counters(f->modbus)->heartbeats, heard + 2);
    /* Several at once, and then one that is damaged. */
    static const uint8_t two[] = { 1, 3, 0, 0, 0, 1, 0x84, 0x0a,
                                   1, 3, 0, 0, 0, 1, 0x84, 0x0a };
    assert_int_equal(pel_modbus_session_feed(f->session, two, sizeof two,
                                             f->answer, sizeof f->answer),
                     14);
    assert_int_equal(
        pel_modbus_session_feed(f->session,
                                (const uint8_t[]){ 1, 3, 0, 0, 0, 1, 0, 0 }, 8,
                                f->answer, sizeof f->answer),
        -1);
    assert_int_equal(pel_modbus_counters(f->modbus)->malformed, 1);
}

int main(void)
{
    pel_log_set_level(PEL_LOG_ERROR);
#define TEST(name) cmocka_unit_test_setup_teardown(name, set_up, tear_down)
    const struct CMUnitTest tests[] = {
        TEST(shows_the_probe),
        TEST(stages_until_the_commit),
        TEST(zero_forgets_the_stage),
        TEST(commits_within_one_request),
        TEST(refuses_and_changes_nothing),
        TEST(water_is_described),
        TEST(limits_are_inside),
        TEST(sets_swell_views_and_place),
        TEST(hands_the_sun_to_the_clock),
        TEST(masks_and_reads_in_one),
        TEST(refuses_bad_forms),
        TEST(frames_a_stream),
        TEST(silence_makes_the_source_stale),
        TEST(a_thousand_bad_requests),
        TEST(refuses_open_doors_and_bad_options),
        TEST(exercises_are_none),
        TEST(says_what_it_is),
        cmocka_unit_test_setup_teardown(speaks_rtu, set_up_rtu, tear_down),
        cmocka_unit_test(answers_above_1024_descriptors),
        cmocka_unit_test(slow_clients_cost_nobody_else),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
