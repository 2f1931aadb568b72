/* The pieces of the network that are functions of their arguments. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cmocka.h>

#include "base/metrics.h"
#include "frames/job.h"
#include "json.h"
#include "net/command.h"
#include "net/frame_reply.h"
#include "net/http_request.h"
#include "net/liveviewer.h"
#include "net/outbox.h"
#include "net/rtspguard.h"
#include "net/surfacewire.h"
#include "net/websocket.h"
#include "wire.h"

static struct pel_surface_sample some_sample(unsigned i)
{
    double x = i * 0.37;
    return (struct pel_surface_sample){
        .height_m = i % 5 ? x - 2 : -0.0,
        .normal = { sin(x), cos(x), 1 / (1 + x) },
        .velocity_mps = { -x, x, 1e-300 },
        .acceleration_mps2 = { i % 3 ? NAN : x, i % 3 ? NAN : 2, 3 },
        .depth_m = i % 2   ? NAN
                   : i % 4 ? -1e6
                           : 40,
        .foam = i % 7 ? NAN : x / 4000,
    };
}

/* In slices, as the pool's threads write it; free(). */
static char *written(const struct pel_surface_form *form, double time_s,
                     const struct pel_surface_sample *samples, size_t count,
                     size_t *size)
{
    char *out = malloc(PEL_SURFACE_HEAD + 1000 * (count + 1));
    char *slices = malloc(1000 * (count + 1));
    size_t all = 0, one = 0;
    for (size_t i = 0; i < count; i += 7) {
        size_t n = count - i < 7 ? count - i : 7;
        char *slice = form->slice(samples + i, i, n, &one);
        memcpy(slices + all, slice, one);
        all += one;
        free(slice);
    }
    size_t head = form->head(form, time_s, count, all, out);
    const char *tail = form->tail ? form->tail(count) : "";
    memcpy(out + head, slices, all);
    memcpy(out + head + all, tail, strlen(tail) + 1);
    *size = head + all + strlen(tail);
    free(slices);
    return out;
}

/* Against protobuf-c, and the converter to JSON: what they write is theirs to
 * say. */
static void test_surface_reply(void **state)
{
    (void)state;
    static const size_t counts[] = { 0, 1, 2, 19, 10000 };
    static struct pel_surface_sample samples[10000];
    for (unsigned i = 0; i < 10000; i++) {
        samples[i] = some_sample(i);
    }
    for (size_t k = 0; k < 2 * (sizeof counts / sizeof *counts); k++) {
        size_t count = counts[k / 2], size = 0, want_size = 0;
        Pelagos__Reply reply = PELAGOS__REPLY__INIT;
        reply.has_id = k % 2;
        reply.id = k == 3 ? UINT64_MAX : k;
        reply.result_case = PELAGOS__REPLY__RESULT_SURFACE;
        reply.surface = pel_surface_message(1e9 / 3, samples, count);
        uint8_t *want = pel_wire_pack(&reply.base, &want_size);
        const struct pel_surface_form form =
            pel_surface_reply(reply.has_id, reply.id);
        char *got = written(&form, 1e9 / 3, samples, count, &size);
        assert_int_equal(size, want_size);
        assert_memory_equal(got, want, size);
        char *json = pel_json_from_message(&reply.surface->base, false);
        char *text = written(&pel_surface_json, 1e9 / 3, samples, count, &size);
        assert_string_equal(text, json);
        assert_int_equal(size, strlen(json));
        pel_surface_message_free(reply.surface);
        free(want);
        free(got);
        free(json);
        free(text);
    }
}

static void test_target(void **state)
{
    (void)state;
    struct pel_http_target t;
    assert_int_equal(pel_http_parse_target("/", &t, NULL), PEL_OK);
    assert_int_equal(t.segment_count, 0);
    assert_int_equal(
        pel_http_parse_target("/v1/a%20b/?x=1+2&y=%2f&z", &t, NULL), PEL_OK);
    assert_int_equal(t.segment_count, 3);
    assert_string_equal(t.segments[1], "a b");
    assert_string_equal(t.segments[2], "");
    assert_int_equal(t.query_count, 3);
    assert_string_equal(t.query[0].value, "1 2");
    assert_string_equal(t.query[1].value, "/");
    assert_string_equal(t.query[2].value, "");
    static const char *const bad[] = {
        "",        "v1",
        "*",       "http://x/",
        "/%",      "/%4",
        "/%zz",    "/a%00b",
        "/\n",     "ftp://x/",
        "/?=1",    "/?a=%",
        "/?a=%7f", "/1/2/3/4/5/6/7/8/9",
    };
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        struct pel_fault fault;
        assert_int_equal(pel_http_parse_target(bad[i], &t, &fault),
                         PEL_ERR_MALFORMED);
    }
}

static void test_longest_target(void **state)
{
    (void)state;
    /* The most text there can be: parameters of one byte, or a few. */
    static const char path[] = "/a/b/c/d/e/f/g/h?";
    char target[PEL_HTTP_MAX_TARGET];
    struct pel_http_target t;
    memset(target, 'x', sizeof target);
    memcpy(target, path, strlen(path));
    for (size_t i = 0; i < PEL_HTTP_MAX_QUERY; i++) {
        char *part = target + strlen(path) + 4 * i;
        part[0] = (char)('a' + i / 26);
        part[1] = (char)('a' + i % 26);
        part[2] = '=';
        part[3] = i + 1 < PEL_HTTP_MAX_QUERY ? '&' : 'x';
    }
    target[sizeof target - 1] = '\0';
    assert_int_equal(pel_http_parse_target(target, &t, NULL), PEL_OK);
    assert_int_equal(t.query_count, PEL_HTTP_MAX_QUERY);
    assert_true(t.used <= sizeof t.text);
}

static void test_host(void **state)
{
    (void)state;
    const char *const names[] = { "sea.example", NULL };
    static const char *const ours[] = { "localhost",      "LOCALHOST:8080",
                                        "127.0.0.1:80",   "10.1.2.3",
                                        "[::1]",          "[2001:db8::1]:8080",
                                        "Sea.Example:443" };
    static const char *const theirs[] = {
        "",
        ":80",
        "evil.example",
        "localhost.evil",
        "127.0.0.1.",
        "127.0.0.1:80x",
        "[::1",
        "::1",
        "[::1]x",
        "2130706433.ev",
        "localhost:123456",
    };
    for (size_t i = 0; i < sizeof ours / sizeof ours[0]; i++) {
        assert_true(pel_http_host_is_ours(ours[i], names));
    }
    assert_false(pel_http_host_is_ours("sea.example", NULL));
    for (size_t i = 0; i < sizeof theirs / sizeof theirs[0]; i++) {
        assert_false(pel_http_host_is_ours(theirs[i], names));
    }
    assert_true(pel_http_origin_is_ours("http://a:1", "a:1"));
    assert_true(pel_http_origin_is_ours("https://a", "A"));
    assert_false(pel_http_origin_is_ours("null", "a"));
    assert_false(pel_http_origin_is_ours("http://a:1", "a"));
    assert_false(pel_http_origin_is_ours("ftp://a", "a"));
}

static void test_type_and_tags(void **state)
{
    (void)state;
    assert_true(pel_http_type_is_json("application/json"));
    assert_true(pel_http_type_is_json("Application/JSON; charset=UTF-8"));
    assert_true(pel_http_type_is_json("application/merge-patch+json"));
    assert_false(pel_http_type_is_json(""));
    assert_false(pel_http_type_is_json("application/jsonp"));
    assert_false(pel_http_type_is_json("application/json; charset=latin1"));
    assert_true(pel_http_tag_matches("\"a\"", "\"a\"", false));
    assert_true(pel_http_tag_matches(" \"b\" , \"a\"", "\"a\"", false));
    assert_true(pel_http_tag_matches("*", "\"a\"", false));
    assert_true(pel_http_tag_matches("W/\"a\"", "\"a\"", true));
    assert_false(pel_http_tag_matches("W/\"a\"", "\"a\"", false));
    assert_false(pel_http_tag_matches("\"ab\"", "\"a\"", false));
    assert_false(pel_http_tag_matches("\"a", "\"a\"", false));
    assert_false(pel_http_tag_matches("a", "\"a\"", false));
}

static void test_command_number(void **state)
{
    (void)state;
    const ProtobufCMessageDescriptor *type =
        &pelagos__frame_request__descriptor;
    struct pel_fault fault;
    double value = 0;
    assert_int_equal(pel_command_number(type, "width", "640", &value, &fault),
                     PEL_OK);
    assert_true(value == 640.0);
    assert_int_equal(pel_command_number(type, "time", "1.5e1", &value, &fault),
                     PEL_OK);
    assert_true(value == 15.0);
    assert_int_equal(pel_command_number(type, "width", "15", &value, &fault),
                     PEL_ERR_OUT_OF_RANGE);
    assert_string_equal(fault.path, "width");
    assert_string_equal(fault.unit, "px");
    assert_true(fault.minimum == 16.0 && fault.maximum == 4096.0);
    static const char *const bad[] = { "",    "x",   "0x20", "20 ", " 20",
                                       "nan", "inf", "20.5", "1,5" };
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        assert_int_equal(
            pel_command_number(type, "width", bad[i], &value, &fault),
            PEL_ERR_INVALID);
    }
}

static void test_command_check(void **state)
{
    (void)state;
    struct pel_fault fault;
    Pelagos__Point good = PELAGOS__POINT__INIT, bad = PELAGOS__POINT__INIT;
    good.has_east = bad.has_east = true;
    bad.east = NAN;
    Pelagos__Point *points[] = { &good, &bad };
    Pelagos__SurfaceQuery query = PELAGOS__SURFACE_QUERY__INIT;
    query.points = points;
    query.n_points = 2;
    assert_int_equal(pel_command_check(&query.base, &fault), PEL_ERR_INVALID);
    assert_string_equal(fault.path, "points.1.east");
    bad.east = -2.1e7 - 1;
    assert_int_equal(pel_command_check(&query.base, &fault),
                     PEL_ERR_OUT_OF_RANGE);
    bad.east = -2.1e7;
    assert_int_equal(pel_command_check(&query.base, &fault), PEL_OK);
    Pelagos__FrameRequest frame = PELAGOS__FRAME_REQUEST__INIT;
    frame.has_format = true;
    frame.format = 77;
    assert_int_equal(pel_command_check(&frame.base, &fault), PEL_ERR_INVALID);
    assert_string_equal(fault.path, "format");
}

/* What an outbox sends, as one Reply after its length. */
static Pelagos__Reply *reply_of(struct pel_outbox *box)
{
    static uint8_t bytes[4096];
    size_t sent = 0, total = box->bytes, offset = 0, length = 0;
    int pair[2];
    assert_int_equal(socketpair(AF_UNIX, SOCK_STREAM, 0, pair), 0);
    assert_int_equal(pel_outbox_flush(box, pair[0], &sent), PEL_OUTBOX_EMPTY);
    assert_int_equal(
        recv(pair[1], bytes, sizeof bytes, MSG_WAITALL | MSG_DONTWAIT), total);
    close(pair[0]);
    close(pair[1]);
    assert_int_equal(pel_wire_next(bytes, total, 1 << 20, &offset, &length),
                     PEL_WIRE_MESSAGE);
    assert_int_equal(offset + length, total);
    Pelagos__Reply *reply =
        pelagos__reply__unpack(NULL, length, bytes + offset);
    assert_non_null(reply);
    assert_int_equal(reply->id, 99);
    return reply;
}

static struct pel_frame *picture_of(const char *view, const char *text)
{
    struct pel_frame *frame = pel_frame_create();
    struct pel_bytes bytes = { (uint8_t *)strdup(text), strlen(text) };
    snprintf(frame->view, sizeof frame->view, "%s", view);
    frame->number = 300;
    frame->width = 640;
    frame->format = PELAGOS__FRAME_FORMAT__EXR;
    pel_frame_set_bytes(frame, &bytes);
    return frame;
}

static void check_picture(const Pelagos__Frame *frame, const char *view,
                          const char *text)
{
    assert_string_equal(frame->view, view);
    assert_int_equal(frame->number, 300);
    assert_int_equal(frame->width, 640);
    assert_int_equal(frame->format, PELAGOS__FRAME_FORMAT__EXR);
    assert_int_equal(frame->data.len, strlen(text));
    assert_memory_equal(frame->data.data, text, strlen(text));
}

/* The heads written by hand and the pictures between them are one Reply. */
static void test_frame_reply(void **state)
{
    (void)state;
    struct pel_frame *pictures[] = { picture_of("bridge", "one"),
                                     picture_of("", ""),
                                     picture_of("wing", "three of them") };
    struct pel_outbox box;
    pel_outbox_init(&box);
    pel_frame_reply_add(&box, true, 99, pictures[2]);
    Pelagos__Reply *reply = reply_of(&box);
    assert_int_equal(reply->result_case, PELAGOS__REPLY__RESULT_FRAME);
    check_picture(reply->frame, "wing", "three of them");
    pelagos__reply__free_unpacked(reply, NULL);
    pel_frames_reply_add(&box, true, 99, pictures, 3);
    reply = reply_of(&box);
    assert_int_equal(reply->result_case, PELAGOS__REPLY__RESULT_FRAMES);
    assert_int_equal(reply->frames->n_frames, 3);
    check_picture(reply->frames->frames[0], "bridge", "one");
    check_picture(reply->frames->frames[1], "", "");
    check_picture(reply->frames->frames[2], "wing", "three of them");
    pelagos__reply__free_unpacked(reply, NULL);
    for (int i = 0; i < 3; i++) {
        pel_frame_unref(pictures[i]);
    }
    pel_outbox_finish(&box);
}

static void test_outbox(void **state)
{
    (void)state;
    int pair[2];
    assert_int_equal(socketpair(AF_UNIX, SOCK_STREAM, 0, pair), 0);
    struct pel_outbox box;
    pel_outbox_init(&box);
    size_t total = 0, sent = 0;
    for (int i = 0; i < 50; i++) {
        size_t size = 40000;
        uint8_t *data = malloc(size);
        memset(data, i, size);
        pel_outbox_add(&box, data, size);
        total += size;
    }
    assert_int_equal(pel_outbox_flush(&box, pair[0], &sent),
                     PEL_OUTBOX_WAITING);
    assert_int_equal(box.bytes, total - sent);
    static uint8_t buffer[33333];
    size_t got = 0;
    while (got < total) {
        ssize_t n = read(pair[1], buffer, sizeof buffer);
        assert_true(n > 0);
        for (ssize_t i = 0; i < n; i++) {
            assert_int_equal(buffer[i], (got + (size_t)i) / 40000);
        }
        got += (size_t)n;
        assert_int_not_equal(pel_outbox_flush(&box, pair[0], &sent),
                             PEL_OUTBOX_GONE);
    }
    assert_int_equal(box.bytes, 0);
    close(pair[1]);
    pel_outbox_add(&box, calloc(1, 1), 1);
    assert_int_equal(pel_outbox_flush(&box, pair[0], &sent), PEL_OUTBOX_GONE);
    pel_outbox_finish(&box);
    close(pair[0]);
}

static void collect_a(void *user, struct pel_metrics_page *page)
{
    (void)user;
    pel_metric(page, "pelagos_b_total", PEL_METRIC_COUNTER, "B.", "x=\"1\"", 3);
    pel_metric(page, "pelagos_a", PEL_METRIC_GAUGE, "A.", NULL, 0.5);
}

static void collect_b(void *user, struct pel_metrics_page *page)
{
    (void)user;
    pel_metric(page, "pelagos_b_total", PEL_METRIC_COUNTER, "other", "x=\"2\"",
               1e15);
}

static void test_metrics(void **state)
{
    (void)state;
    struct pel_metrics *metrics = pel_metrics_create();
    pel_metrics_add(metrics, collect_a, NULL);
    pel_metrics_add(metrics, collect_b, metrics);
    char *text = pel_metrics_text(metrics, NULL);
    assert_string_equal(text, "# HELP pelagos_a A.\n"
                              "# TYPE pelagos_a gauge\n"
                              "pelagos_a 0.5\n"
                              "# HELP pelagos_b_total B.\n"
                              "# TYPE pelagos_b_total counter\n"
                              "pelagos_b_total{x=\"1\"} 3\n"
                              "pelagos_b_total{x=\"2\"} 1e+15\n");
    free(text);
    pel_metrics_remove(metrics, collect_a, NULL);
    size_t size = 0;
    text = pel_metrics_text(metrics, &size);
    assert_int_equal(size, strlen(text));
    assert_null(strstr(text, "pelagos_a"));
    free(text);
    pel_metrics_destroy(metrics);
}

/* The example of RFC 6455, 1.3. */
static void test_websocket_key(void **state)
{
    (void)state;
    char out[32];
    assert_true(pel_websocket_accept_key("dGhlIHNhbXBsZSBub25jZQ==", out));
    assert_string_equal(out, "s3pPLMBiTxaQ9kYGzzhZRbK+xOo=");
    assert_false(pel_websocket_accept_key("", out));
    assert_false(pel_websocket_accept_key("dGhlIHNhbXBsZSBub25j", out));
    assert_false(pel_websocket_accept_key("dGhlIHNhbXBsZSBub25jZQAA", out));
}

static void test_live_header(void **state)
{
    (void)state;
    struct pel_frame frame = {
        .codec = PEL_CODEC_H264,
        .key = true,
        .number = 0x0102030405060708,
        .revision = 9,
        .time_s = 1.5,
        .width = 1280,
        .height = 720,
        .requested_ns = 1000000000,
        .drawn_ns = 1020000000,
        .encoded_ns = 1025000000,
        .present_ns = 1110000000,
        .drawn_width = 640,
        .drawn_height = 360,
    };
    static const uint8_t wanted[PEL_LIVE_HEADER] = {
        1,    1,    3,    80, 0,    5,    0xd0, 2,    /* 1280x720 */
        8,    7,    6,    5,  4,    3,    2,    1,    /* number */
        0,    0,    0,    0,  0,    0,    0xf8, 0x3f, /* 1.5 s */
        0,    0,    0,    0,  0,    0,    0,    0,    /* no host */
        0xb0, 0x7c, 0x1e, 0,  0,    0,    0,    0,    /* 2.028 s - 30 ms */
        0x20, 0x4e, 0,    0,  0xa8, 0x61, 0,    0,    /* 20 ms, 25 ms */
        0x30, 0x75, 0,    0,  7,    0,    0,    0,    /* 30 ms, 7 missed */
        9,    0,    0,    0,  0,    0,    0,    0,    /* revision */
        0x60, 0x2a, 0x20, 0,  0,    0,    0,    0,    /* 110 ms after stamp */
        0x80, 2,    0x68, 1,  0,    0,    0,    0,    /* drawn 640x360 */
    };
    uint8_t out[PEL_LIVE_HEADER];
    pel_live_header(&frame, 1030000000, 2028000000, 7, true, out);
    assert_memory_equal(out, wanted, sizeof out);
    frame.host_frame = 0x01020304;
    frame.stale = PEL_STALE_NMEA;
    pel_live_header(&frame, 1030000000, 2028000000, 7, true, out);
    assert_int_equal(out[2], 7);
    assert_memory_equal(out + 24, "\4\3\2\1\0\0\0\0", 8);
}

static void test_live_messages(void **state)
{
    (void)state;
    struct pel_live_order order;
    uint8_t data[17] = { 1, 0, 0, 0, 0, 0, 0, 0, 5, 1, 0, 0, 0, 0, 0, 0 };
    assert_true(pel_live_read(data, 16, &order));
    assert_int_equal(order.type, PEL_LIVE_ACK);
    assert_int_equal(order.frame, 261);
    assert_false(pel_live_read(data, 15, &order));
    assert_false(pel_live_read(data, 17, &order));
    data[0] = 3;
    data[1] = 70;
    data[4] = 0xe8;
    data[5] = 3;
    data[10] = 90;
    assert_true(pel_live_read(data, 16, &order));
    assert_int_equal(order.profile.quality, 70);
    assert_int_equal(order.profile.kbps, 1000);
    assert_int_equal(order.profile.width, 261);
    assert_int_equal(order.profile.height, 90);
    data[0] = 0;
    assert_false(pel_live_read(data, 16, &order));
    data[0] = 5;
    assert_false(pel_live_read(data, 16, &order));
}

/* Whole and byte by byte: whether all of it may come. */
static bool rtsp_takes(const char *text, size_t size)
{
    struct pel_rtsp_framing whole = { 0 }, bytes = { 0 };
    bool good = pel_rtsp_framing_take(&whole, (const uint8_t *)text, size);
    bool same = true;
    for (size_t i = 0; i < size; i++) {
        same = pel_rtsp_framing_take(&bytes, (const uint8_t *)text + i, 1);
    }
    assert_int_equal(good, same);
    return good;
}

static void test_rtsp_framing(void **state)
{
    (void)state;
#define OPTIONS "OPTIONS * RTSP/1.0\r\nCSeq: 1\r\n"
    static const struct {
        const char *text;
        bool good;
    } cases[] = {
        { OPTIONS "\r\n" OPTIONS "\r\n", true },
        { OPTIONS "\n", true },
        { OPTIONS "Content-Length: 3\r\n\r\nabc" OPTIONS "\r\n", true },
        { OPTIONS "content-length:0\r\n\r\n" OPTIONS "\r\n", true },
        { OPTIONS "Content-Length: 32768\r\n\r\n", true },
        { OPTIONS "Content-Length: 32769\r\n\r\n", false },
        { OPTIONS "Content-Length: 99999999999999999999999\r\n", false },
        { OPTIONS "Content-Length: 3\r\nContent-Length: 3\r\n", false },
        { OPTIONS "Content-Length : 3\r\n", false },
        { OPTIONS "Content-Length: -3\r\n", false },
        { OPTIONS "Content-Length:\r\n 3\r\n", false },
        { OPTIONS "X: y\r\n z\r\n", false },
        { OPTIONS "X: y\rz\r\n", false },
        { "GET / HTTP/1.0\r\n", false },
        { "GET x HTTP/1.0\r\n", false },
        { "get\trtsp://h/x HTTP/1.0\r\n", false },
        { "POST  /x HTTP/1.0\r\n", false },
        { "\fGET /x HTTP/1.0\r\n", false },
        { "GET_PARAMETER * RTSP/1.0\r\nCSeq: 1\r\n\r\n", true },
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        assert_int_equal(rtsp_takes(cases[i].text, strlen(cases[i].text)),
                         cases[i].good);
    }
    /* Receiver reports among requests, for as long as anybody plays. */
    static char reports[200 * 400];
    for (size_t i = 0; i < 400; i++) {
        memcpy(reports + 200 * i, "$\1\0\304", 4);
    }
    assert_true(rtsp_takes(reports, sizeof reports));
    static char head[PEL_RTSP_HEAD_BYTES + 1];
    for (size_t i = 0; i + 6 < sizeof head; i += 6) {
        memcpy(head + i, "A: b\r\n", 6);
    }
    memset(head + sizeof head - 5, 'x', 5);
    assert_false(rtsp_takes(head, sizeof head));
    assert_true(rtsp_takes(head, sizeof head - 1));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_surface_reply),
        cmocka_unit_test(test_rtsp_framing),
        cmocka_unit_test(test_target),
        cmocka_unit_test(test_longest_target),
        cmocka_unit_test(test_host),
        cmocka_unit_test(test_type_and_tags),
        cmocka_unit_test(test_command_number),
        cmocka_unit_test(test_command_check),
        cmocka_unit_test(test_frame_reply),
        cmocka_unit_test(test_outbox),
        cmocka_unit_test(test_metrics),
        cmocka_unit_test(test_websocket_key),
        cmocka_unit_test(test_live_header),
        cmocka_unit_test(test_live_messages),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
