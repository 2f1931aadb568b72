#include "pelagos.h"

#include <netinet/in.h>
#include <pthread.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cmocka.h>

/* Answers one connection with `text`, `chunk` bytes a write, then waits for
 * the client to go (or goes first). */
struct fake {
    int listener;
    pthread_t thread;
    char url[64], request[512];
    const char *text;
    size_t size, chunk;
    bool stay;
    atomic_bool sent;
};

static void *serve(void *user)
{
    struct fake *fake = user;
    int fd = accept(fake->listener, NULL, NULL);
    ssize_t n = recv(fd, fake->request, sizeof fake->request - 1, 0);
    fake->request[n > 0 ? n : 0] = '\0';
    for (size_t done = 0; done < fake->size;) {
        size_t left = fake->size - done;
        ssize_t sent =
            send(fd, fake->text + done, left < fake->chunk ? left : fake->chunk,
                 MSG_NOSIGNAL);
        if (sent <= 0) {
            break;
        }
        done += (size_t)sent;
    }
    atomic_store(&fake->sent, true);
    if (fake->stay) {
        char byte;
        while (recv(fd, &byte, 1, 0) > 0) {
        }
    }
    close(fd);
    return NULL;
}

static void start(struct fake *fake, const char *text, size_t chunk, bool stay)
{
    *fake = (struct fake){
        .text = text, .size = strlen(text), .chunk = chunk, .stay = stay
    };
    struct sockaddr_in address = { .sin_family = AF_INET };
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t length = sizeof address;
    fake->listener = socket(AF_INET, SOCK_STREAM, 0);
    assert_int_equal(
        bind(fake->listener, (struct sockaddr *)&address, sizeof address), 0);
    assert_int_equal(listen(fake->listener, 1), 0);
    assert_int_equal(
        getsockname(fake->listener, (struct sockaddr *)&address, &length), 0);
    snprintf(fake->url, sizeof fake->url, "http://127.0.0.1:%d/",
             ntohs(address.sin_port));
    assert_int_equal(pthread_create(&fake->thread, NULL, serve, fake), 0);
}

static void stop(struct fake *fake)
{
    pthread_join(fake->thread, NULL);
    close(fake->listener);
}

#define OK_HEAD "HTTP/1.1 200 OK\r\nContent-Type: multipart/x\r\n\r\n"
#define PART(number, text, length)                                             \
    "Content-Type: image/jpeg\r\nContent-Length: " length "\r\n"               \
    "X-Pelagos-Frame: " number "\r\nX-Pelagos-Time: " number ".5\r\n"          \
    "X-Pelagos-Revision: 3\r\nX-Pelagos-Stale: cigi,nmea\r\n"                  \
    "X-Pelagos-Host-Frame: 77\r\n\r\n" text "\r\n--pelagos\r\n"

static const char three[] = OK_HEAD "--pelagos\r\n" PART("7", "abc", "3")
    PART("8", "defg", "4") PART("9", "\r\n\r\nhi", "6");

static void test_newest_of_three(void **state)
{
    (void)state;
    struct fake fake;
    start(&fake, three, SIZE_MAX, true);
    struct pel_live *live = NULL;
    struct pel_client_error error;
    struct pel_live_frame frame = { 0 };
    assert_int_equal(
        pel_live_open(fake.url, "bridge", 2.5, 70, 60000, &live, &error),
        PEL_CLIENT_OK);
    while (!atomic_load(&fake.sent)) {
        usleep(1000); /* what is sent is there: this is one machine */
    }
    assert_int_equal(pel_live_next(live, 60000, &frame, &error), PEL_CLIENT_OK);
    assert_int_equal(frame.number, 9);
    assert_int_equal(frame.revision, 3);
    assert_int_equal(frame.host_frame, 77);
    assert_true(frame.stale);
    assert_true(frame.time_s == 9.5);
    assert_int_equal(frame.dropped, 2);
    assert_int_equal(frame.size, 6);
    assert_memory_equal(frame.data, "\r\n\r\nhi", 6);
    /* Silence leaves it usable. */
    for (int i = 0; i < 2; i++) {
        assert_int_equal(pel_live_next(live, 20, &frame, &error),
                         PEL_CLIENT_TIMEOUT);
    }
    pel_live_close(live);
    stop(&fake);
    assert_non_null(strstr(fake.request, "GET /v1/views/bridge/mjpeg"
                                         "?fps=2.5&quality=70 HTTP/1.0\r\n"));
}

static void test_single_bytes_and_the_end(void **state)
{
    (void)state;
    struct fake fake;
    start(&fake, three, 1, false);
    struct pel_live *live = NULL;
    struct pel_client_error error;
    struct pel_live_frame frame = { 0 };
    assert_int_equal(
        pel_live_open(fake.url, "bridge", 0, 0, 60000, &live, &error),
        PEL_CLIENT_OK);
    uint64_t last = 0;
    enum pel_client_code code;
    while ((code = pel_live_next(live, 60000, &frame, &error)) ==
           PEL_CLIENT_OK) {
        assert_true(frame.number > last);
        last = frame.number;
    }
    assert_int_equal(last, 9);
    assert_int_equal(code, PEL_CLIENT_CLOSED);
    assert_non_null(strstr(error.message, "ended"));
    pel_live_close(live);
    stop(&fake);
}

static void test_a_refusal_says_why(void **state)
{
    (void)state;
    struct fake fake;
    start(&fake,
          "HTTP/1.1 400 Bad Request\r\nContent-Type: "
          "application/problem+json\r\n\r\n{\"status\":400,\"code\":"
          "\"OUT_OF_RANGE\",\"detail\":\"fps must be \\\"less\\\"\",\"path\":"
          "\"fps\",\"value\":\"999\",\"unit\":\"1/s\",\"minimum\":0.1,"
          "\"maximum\":240}",
          7, false);
    struct pel_live *live = NULL;
    struct pel_client_error error;
    assert_int_equal(
        pel_live_open(fake.url, "bridge", 999, 0, 60000, &live, &error),
        PEL_CLIENT_OUT_OF_RANGE);
    assert_string_equal(error.message, "fps must be \"less\"");
    assert_string_equal(error.path, "fps");
    assert_string_equal(error.unit, "1/s");
    assert_true(error.minimum == 0.1 && error.maximum == 240);
    stop(&fake);
}

static void test_what_is_no_stream(void **state)
{
    (void)state;
    static char endless[40000];
    memset(endless, 'x', sizeof endless - 1);
    static const struct {
        const char *text;
        enum pel_client_code open, next;
    } cases[] = {
        { "", PEL_CLIENT_CLOSED, 0 },
        { "220 mail\r\n\r\n", PEL_CLIENT_PROTOCOL, 0 },
        { endless, PEL_CLIENT_PROTOCOL, 0 },
        { OK_HEAD "<html></html>\r\n\r\n", 0, PEL_CLIENT_PROTOCOL },
        { OK_HEAD PART("1", "", "0"), 0, PEL_CLIENT_PROTOCOL },
        { OK_HEAD PART("1", "", "-1"), 0, PEL_CLIENT_PROTOCOL },
        { OK_HEAD PART("1", "", "99999999999"), 0, PEL_CLIENT_PROTOCOL },
        { OK_HEAD PART("1", "abc", "4000"), 0, PEL_CLIENT_CLOSED },
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct fake fake;
        start(&fake, cases[i].text, SIZE_MAX, false);
        struct pel_live *live = NULL;
        struct pel_client_error error;
        struct pel_live_frame frame;
        assert_int_equal(
            pel_live_open(fake.url, "bridge", 0, 0, 60000, &live, &error),
            cases[i].open);
        if (live) {
            assert_int_equal(pel_live_next(live, 60000, &frame, &error),
                             cases[i].next);
            pel_live_close(live);
        }
        assert_true(*error.message);
        stop(&fake);
    }
}

static void test_addresses(void **state)
{
    (void)state;
    static const struct {
        const char *url, *view;
        enum pel_client_code code;
    } cases[] = {
        { "tcp:127.0.0.1:1", "a", PEL_CLIENT_BAD_ADDRESS },
        { "http://", "a", PEL_CLIENT_BAD_ADDRESS },
        { "http://host:1/path", "a", PEL_CLIENT_BAD_ADDRESS },
        { "http://127.0.0.1:1", "a", PEL_CLIENT_UNREACHABLE },
        { "http://[::1]:1/", "a", PEL_CLIENT_UNREACHABLE },
        { "http://127.0.0.1:1", "a b", PEL_CLIENT_INVALID },
        { "http://127.0.0.1:1", "", PEL_CLIENT_INVALID },
        { "http://127.0.0.1:1", "../state", PEL_CLIENT_INVALID },
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct pel_live *live = NULL;
        struct pel_client_error error;
        assert_int_equal(pel_live_open(cases[i].url, cases[i].view, 0, 0, 500,
                                       &live, &error),
                         cases[i].code);
        assert_true(*error.message);
    }
    pel_live_close(NULL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_newest_of_three),
        cmocka_unit_test(test_single_bytes_and_the_end),
        cmocka_unit_test(test_a_refusal_says_why),
        cmocka_unit_test(test_what_is_no_stream),
        cmocka_unit_test(test_addresses),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
