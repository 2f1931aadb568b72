#include "pelagos.h"

#include <pthread.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cmocka.h>

#include "proto/wire.h"

/* A daemon of a few lines: answers each request by `answer`, which may write
 * what it likes. One connection. */
struct fake {
    int listener, fd;
    pthread_t thread;
    char path[64], address[80];
    bool (*answer)(struct fake *fake, const Pelagos__Request *request);
    size_t chunk; /* bytes of one write */
};

static void put_bytes(struct fake *fake, const uint8_t *data, size_t size)
{
    while (size > 0) {
        size_t n = size < fake->chunk ? size : fake->chunk;
        if (send(fake->fd, data, n, MSG_NOSIGNAL) != (ssize_t)n) {
            return;
        }
        data += n;
        size -= n;
    }
}

static void put_reply(struct fake *fake, const Pelagos__Reply *reply)
{
    size_t size = 0;
    uint8_t *bytes = pel_wire_pack(&reply->base, &size);
    put_bytes(fake, bytes, size);
    free(bytes);
}

static void put_state(struct fake *fake, uint64_t id, uint64_t revision)
{
    Pelagos__State state = PELAGOS__STATE__INIT;
    state.has_revision = 1;
    state.revision = revision;
    Pelagos__Reply reply = PELAGOS__REPLY__INIT;
    reply.has_id = 1;
    reply.id = id;
    reply.result_case = PELAGOS__REPLY__RESULT_STATE;
    reply.state = &state;
    put_reply(fake, &reply);
}

static void *serve(void *user)
{
    struct fake *fake = user;
    fake->fd = accept(fake->listener, NULL, NULL);
    static uint8_t data[PEL_WIRE_MAX_REQUEST + PEL_WIRE_MAX_PREFIX];
    size_t there = 0;
    for (bool on = true; on;) {
        size_t offset = 0, length = 0;
        if (pel_wire_next(data, there, PEL_WIRE_MAX_REQUEST, &offset,
                          &length) == PEL_WIRE_MESSAGE) {
            Pelagos__Request *request =
                pelagos__request__unpack(NULL, length, data + offset);
            on = request && fake->answer(fake, request);
            pelagos__request__free_unpacked(request, NULL);
            there -= offset + length;
            memmove(data, data + offset + length, there);
            continue;
        }
        ssize_t n = recv(fake->fd, data + there, sizeof data - there, 0);
        on = n > 0;
        there += n > 0 ? (size_t)n : 0;
    }
    close(fake->fd);
    return NULL;
}

static struct pel_client *
start(struct fake *fake,
      bool (*answer)(struct fake *, const Pelagos__Request *), int timeout_ms)
{
    *fake = (struct fake){ .answer = answer, .chunk = SIZE_MAX };
    snprintf(fake->path, sizeof fake->path, "/tmp/pelagos-test-%d", getpid());
    snprintf(fake->address, sizeof fake->address, "unix:%s", fake->path);
    unlink(fake->path);
    struct sockaddr_un address = { .sun_family = AF_UNIX };
    memcpy(address.sun_path, fake->path, sizeof fake->path);
    fake->listener = socket(AF_UNIX, SOCK_STREAM, 0);
    assert_int_equal(
        bind(fake->listener, (struct sockaddr *)&address, sizeof address), 0);
    assert_int_equal(listen(fake->listener, 1), 0);
    pthread_create(&fake->thread, NULL, serve, fake);
    struct pel_client *client = NULL;
    struct pel_client_error error;
    assert_int_equal(
        pel_client_connect(fake->address, timeout_ms, &client, &error),
        PEL_CLIENT_OK);
    return client;
}

static void stop(struct fake *fake, struct pel_client *client)
{
    pel_client_close(client);
    pthread_join(fake->thread, NULL);
    close(fake->listener);
    unlink(fake->path);
}

static bool answer_state(struct fake *fake, const Pelagos__Request *request)
{
    put_state(fake, request->id, 7);
    return true;
}

static void test_get_whole_and_in_single_bytes(void **state)
{
    (void)state;
    struct fake fake;
    struct pel_client *client = start(&fake, answer_state, 2000);
    const size_t chunks[] = { SIZE_MAX, 1, 2 };
    for (size_t i = 0; i < 3; i++) {
        fake.chunk = chunks[i];
        Pelagos__State *got = NULL;
        assert_int_equal(pel_client_get(client, &got, NULL), PEL_CLIENT_OK);
        assert_int_equal(got->revision, 7);
        pelagos__state__free_unpacked(got, NULL);
    }
    stop(&fake, client);
}

static bool answer_error(struct fake *fake, const Pelagos__Request *request)
{
    Pelagos__Error error = PELAGOS__ERROR__INIT;
    error.has_code = error.has_minimum = error.has_maximum = 1;
    error.code = PELAGOS__ERROR_CODE__OUT_OF_RANGE;
    error.path = (char *)"sea.windSpeed";
    error.value = (char *)"99";
    error.unit = (char *)"m/s";
    error.maximum = 30;
    error.message = (char *)"99 is outside 0 .. 30 m/s";
    Pelagos__Reply reply = PELAGOS__REPLY__INIT;
    reply.has_id = 1;
    reply.id = request->id;
    reply.result_case = PELAGOS__REPLY__RESULT_ERROR;
    reply.error = &error;
    put_reply(fake, &reply);
    return true;
}

static void test_a_refusal_names_the_field(void **state)
{
    (void)state;
    struct fake fake;
    struct pel_client *client = start(&fake, answer_error, 2000);
    Pelagos__Patch patch = PELAGOS__PATCH__INIT;
    struct pel_client_error error;
    /* Twice: a refusal leaves the client usable. */
    for (int i = 0; i < 2; i++) {
        assert_int_equal(pel_client_patch(client, &patch, NULL, &error),
                         PEL_CLIENT_OUT_OF_RANGE);
        assert_string_equal(error.path, "sea.windSpeed");
        assert_string_equal(error.unit, "m/s");
        assert_true(error.minimum == 0 && error.maximum == 30);
    }
    stop(&fake, client);
}

/* Before the answer to anything come two states for the watcher (id 1). */
static bool answer_late(struct fake *fake, const Pelagos__Request *request)
{
    if (request->command_case != PELAGOS__REQUEST__COMMAND_WATCH) {
        put_state(fake, 1, 10);
        put_state(fake, 1, 11);
    }
    put_state(fake, request->id, request->id);
    return true;
}

static void test_watched_states_come_between(void **state)
{
    (void)state;
    struct fake fake;
    struct pel_client *client = start(&fake, answer_late, 2000);
    Pelagos__State *got = NULL;
    struct pel_client_error error;
    assert_int_equal(pel_client_watch(client, &got, &error), PEL_CLIENT_OK);
    assert_int_equal(got->revision, 1);
    pelagos__state__free_unpacked(got, NULL);
    assert_int_equal(pel_client_next_state(client, 20, &got, &error),
                     PEL_CLIENT_TIMEOUT);
    assert_int_equal(pel_client_get(client, &got, &error), PEL_CLIENT_OK);
    assert_int_equal(got->revision, 2);
    pelagos__state__free_unpacked(got, NULL);
    assert_int_equal(pel_client_next_state(client, 1000, &got, &error),
                     PEL_CLIENT_OK);
    assert_int_equal(got->revision, 11);
    pelagos__state__free_unpacked(got, NULL);
    stop(&fake, client);
}

static bool answer_points(struct fake *fake, const Pelagos__Request *request)
{
    static Pelagos__SurfacePoint points[10000];
    static Pelagos__SurfacePoint *list[10000];
    const Pelagos__SurfaceQuery *query = request->surface;
    Pelagos__Surface surface = PELAGOS__SURFACE__INIT;
    surface.has_time = 1;
    surface.time = query->has_time ? query->time : 42.0;
    surface.n_points = query->n_points;
    surface.points = list;
    for (size_t i = 0; i < query->n_points; i++) {
        pelagos__surface_point__init(&points[i]);
        points[i].has_height = 1;
        points[i].height = query->points[i]->east + query->points[i]->north;
        /* What else was asked for, where the caller sees it. */
        points[i].sounding = query->acceleration ? 1 : 0;
        points[i].has_sounding = 1;
        points[i].depth = (double)query->frame;
        points[i].has_depth = 1;
        points[i].foam = 0.25;
        points[i].has_foam = query->foam;
        list[i] = &points[i];
    }
    Pelagos__Reply reply = PELAGOS__REPLY__INIT;
    reply.has_id = 1;
    reply.id = request->id;
    reply.result_case = PELAGOS__REPLY__RESULT_SURFACE;
    reply.surface = &surface;
    put_reply(fake, &reply);
    return true;
}

static void test_many_points_keep_order_and_time(void **state)
{
    (void)state;
    struct fake fake;
    struct pel_client *client = start(&fake, answer_points, 5000);
    static double points[10000][2];
    for (size_t i = 0; i < 10000; i++) {
        points[i][0] = (double)i;
        points[i][1] = 0.5;
    }
    Pelagos__Surface *surface = NULL;
    struct pel_client_error error;
    assert_int_equal(pel_client_surface(client, (const double(*)[2])points,
                                        10000, NULL, &surface, &error),
                     PEL_CLIENT_OK);
    assert_int_equal(surface->n_points, 10000);
    assert_true(surface->time == 42.0);
    for (size_t i = 0; i < 10000; i++) {
        assert_true(surface->points[i]->height == (double)i + 0.5);
    }
    assert_true(surface->points[0]->sounding == 0);
    pelagos__surface__free_unpacked(surface, NULL);
    const double when = 7.5;
    const struct pel_client_sea sea = { &when, 12, true, true };
    assert_int_equal(pel_client_surface(client, (const double(*)[2])points,
                                        5000, &sea, &surface, &error),
                     PEL_CLIENT_OK);
    assert_true(surface->time == 7.5);
    for (size_t i = 0; i < 5000; i++) {
        assert_true(surface->points[i]->sounding == 1);
        assert_true(surface->points[i]->depth == 12);
    }
    pelagos__surface__free_unpacked(surface, NULL);
    assert_int_equal(pel_client_surface(client, (const double(*)[2])points, 0,
                                        NULL, &surface, &error),
                     PEL_CLIENT_OUT_OF_RANGE);
    stop(&fake, client);
}

static bool answer_nothing(struct fake *fake, const Pelagos__Request *request)
{
    (void)fake, (void)request;
    return true;
}

static bool answer_close(struct fake *fake, const Pelagos__Request *request)
{
    (void)fake, (void)request;
    return false;
}

static bool answer_noise(struct fake *fake, const Pelagos__Request *request)
{
    (void)request;
    static const char http[] = "HTTP/1.1 400 Bad Request\r\n\r\n";
    put_bytes(fake, (const uint8_t *)http, sizeof http - 1);
    return false;
}

static bool answer_giant(struct fake *fake, const Pelagos__Request *request)
{
    (void)request;
    static const uint8_t prefix[] = { 0xff, 0xff, 0xff, 0xff, 0x0f };
    put_bytes(fake, prefix, sizeof prefix);
    return true;
}

static void test_broken_daemons(void **state)
{
    (void)state;
    static const struct {
        bool (*answer)(struct fake *, const Pelagos__Request *);
        enum pel_client_code code;
    } cases[] = {
        { answer_nothing, PEL_CLIENT_TIMEOUT },
        { answer_close, PEL_CLIENT_CLOSED },
        { answer_noise, PEL_CLIENT_PROTOCOL },
        { answer_giant, PEL_CLIENT_PROTOCOL },
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct fake fake;
        struct pel_client *client = start(&fake, cases[i].answer, 300);
        Pelagos__State *got = NULL;
        struct pel_client_error error;
        assert_int_equal(pel_client_get(client, &got, &error), cases[i].code);
        assert_true(*error.message);
        stop(&fake, client);
    }
}

static void test_addresses(void **state)
{
    (void)state;
    static const struct {
        const char *address;
        enum pel_client_code code;
        const char *said;
    } cases[] = {
        { "127.0.0.1:1", PEL_CLIENT_BAD_ADDRESS, "mean tcp:127.0.0.1:1" },
        { "http://127.0.0.1:8080", PEL_CLIENT_BAD_ADDRESS,
          "mean tcp:127.0.0.1:7878?" },
        { "https://ship.example/v1", PEL_CLIENT_BAD_ADDRESS,
          "mean tls:ship.example:7878?" },
        { "http://[::1]:8080/", PEL_CLIENT_BAD_ADDRESS,
          "mean tcp:[::1]:7878?" },
        { "/run/pelagos/socket", PEL_CLIENT_BAD_ADDRESS,
          "mean unix:/run/pelagos/socket" },
        { "localhost", PEL_CLIENT_BAD_ADDRESS, "tcp:HOST:PORT" },
        { "tcp:", PEL_CLIENT_BAD_ADDRESS, NULL },
        { "tcp:host", PEL_CLIENT_BAD_ADDRESS, NULL },
        { "tcp::1", PEL_CLIENT_BAD_ADDRESS, NULL },
        { "tcp:[]:1", PEL_CLIENT_BAD_ADDRESS, NULL },
        { "unix:", PEL_CLIENT_BAD_ADDRESS, NULL },
        { "unix:/nonexistent/socket", PEL_CLIENT_UNREACHABLE, NULL },
        { "tcp:127.0.0.1:1", PEL_CLIENT_UNREACHABLE, NULL },
        { "tcp:[::1]:1", PEL_CLIENT_UNREACHABLE, NULL },
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct pel_client *client = NULL;
        struct pel_client_error error;
        assert_int_equal(
            pel_client_connect(cases[i].address, 500, &client, &error),
            cases[i].code);
        assert_int_equal(error.code, cases[i].code);
        assert_non_null(strstr(error.message, cases[i].address));
        assert_null(strstr(error.message, "tcp:tcp:"));
        if (cases[i].said) {
            assert_non_null(strstr(error.message, cases[i].said));
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_get_whole_and_in_single_bytes),
        cmocka_unit_test(test_a_refusal_names_the_field),
        cmocka_unit_test(test_watched_states_come_between),
        cmocka_unit_test(test_many_points_keep_order_and_time),
        cmocka_unit_test(test_broken_daemons),
        cmocka_unit_test(test_addresses),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
