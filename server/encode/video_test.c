/* H.264: key frames when asked, parameter sets in each, sizes and rates that
 * change while it runs; and what the way to the encoder costs beside it. */
#include "encode/video.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "base/clock.h"

/* A picture that moves and has detail. */
static void paint(uint8_t *rgba, uint32_t width, uint32_t height, int frame)
{
    uint32_t noise = 1;
    for (uint32_t y = 0; y < height; y++) {
        for (uint32_t x = 0; x < width; x++) {
            uint8_t *p = rgba + 4 * ((size_t)y * width + x);
            noise = noise * 1664525u + 1013904223u;
            p[0] = (uint8_t)(x + (uint32_t)frame * 3);
            p[1] = (uint8_t)(y * 2 + (noise >> 29));
            p[2] = (uint8_t)(x / 2 + y / 2 + (uint32_t)frame);
            p[3] = 255;
        }
    }
}

struct stream {
    struct pel_video *video;
    uint8_t *rgba;
    uint32_t width, height;
    int frame;
    int64_t period_ns;
    struct pel_fault fault;
};

static struct stream open_stream(const char *encoder, uint32_t width,
                                 uint32_t height)
{
    struct pel_video_config config = { .encoder = encoder, .fps = 30.0 };
    struct stream s = { .video = pel_video_create(&config),
                        .rgba = malloc((size_t)4 * width * height),
                        .width = width,
                        .height = height,
                        .period_ns = 33333333 };
    assert_non_null(s.video);
    assert_non_null(s.rgba);
    return s;
}

static void close_stream(struct stream *s)
{
    pel_video_destroy(s->video);
    free(s->rgba);
}

static enum pel_err encode(struct stream *s, unsigned kbps, bool want_key,
                           struct pel_bytes *out, bool *key)
{
    if (s->width <= 640 && s->height <= 360) { /* else it is refused unread */
        paint(s->rgba, s->width, s->height, s->frame);
    }
    struct pel_video_picture picture = {
        .rgba = s->rgba,
        .width = s->width,
        .height = s->height,
        .stamp_ns = s->frame++ * s->period_ns,
        .key = want_key,
    };
    return pel_video_encode(s->video, &picture, kbps, out, key, &s->fault);
}

/* Types of the NAL units, as a string of letters from 'a' = 0. */
static void types(const struct pel_bytes *unit, char *out, size_t size)
{
    size_t n = 0;
    for (size_t i = 0; i + 3 < unit->size && n + 1 < size; i++) {
        const uint8_t *p = unit->data + i;
        if (p[0] == 0 && p[1] == 0 && p[2] == 1) {
            out[n++] = (char)('a' + (p[3] & 31));
        }
    }
    out[n] = '\0';
}

static void check_key(const struct pel_bytes *unit)
{
    char letters[64];
    types(unit, letters, sizeof letters);
    assert_non_null(strchr(letters, 'a' + 7)); /* SPS */
    assert_non_null(strchr(letters, 'a' + 8)); /* PPS */
    assert_non_null(strchr(letters, 'a' + 5)); /* IDR slice */
    assert_memory_equal(unit->data, "\0\0", 2);
}

static void keys_when_asked(const char *encoder)
{
    struct stream s = open_stream(encoder, 322, 181);
    struct pel_bytes out;
    bool key;
    for (int i = 0; i < 40; i++) {
        enum pel_err err = encode(&s, 800, i == 20, &out, &key);
        if (err == PEL_ERR_NOT_FOUND) {
            print_message("%s: %s\n", encoder, s.fault.message);
            close_stream(&s);
            skip();
        }
        assert_int_equal(err, PEL_OK);
        assert_int_equal(key, i == 0 || i == 20);
        if (key) {
            check_key(&out);
        }
        pel_bytes_finish(&out);
    }
    assert_string_equal(pel_video_encoder(s.video), encoder);
    close_stream(&s);
}

static void test_x264(void **state)
{
    (void)state;
    keys_when_asked("x264enc");
}

static void test_openh264(void **state)
{
    (void)state;
    keys_when_asked("openh264enc");
}

static size_t bytes_of(struct stream *s, unsigned kbps, int frames)
{
    size_t total = 0;
    for (int i = 0; i < frames; i++) {
        struct pel_bytes out;
        bool key;
        assert_int_equal(encode(s, kbps, false, &out, &key), PEL_OK);
        assert_false(key && s->frame > 1);
        total += out.size;
        pel_bytes_finish(&out);
    }
    return total;
}

static void test_rate_changes(void **state)
{
    (void)state;
    struct stream s = open_stream("auto", 640, 360);
    size_t high, low;
    bytes_of(&s, 4000, 30);
    high = bytes_of(&s, 4000, 60);
    bytes_of(&s, 500, 30); /* until the buffer of the rate control is used */
    low = bytes_of(&s, 500, 60);
    print_message("%.0f kbit/s of 4000, %.0f of 500\n", high * 8e-3 / 2.0,
                  low * 8e-3 / 2.0);
    assert_true(low * 3 < high); /* an eighth was asked for */
    close_stream(&s);
}

/* A machine that draws 6 frames a second has the same bits for them. */
static void test_rate_is_of_time(void **state)
{
    (void)state;
    struct stream s = open_stream("auto", 640, 360);
    s.period_ns = 166666667;
    bytes_of(&s, 1500, 30); /* until it has noticed */
    size_t six = bytes_of(&s, 1500, 30);
    print_message("%.0f kbit/s of 1500 at 6 Hz\n", six * 8e-3 / 5.0);
    assert_true(six * 8e-3 / 5.0 < 2000.0);
    assert_true(six * 8e-3 / 5.0 > 1000.0); /* it sets out short */
    close_stream(&s);
}

static void test_size_changes(void **state)
{
    (void)state;
    struct stream s = open_stream("auto", 640, 360);
    struct pel_bytes out;
    bool key;
    bytes_of(&s, 2000, 3);
    s.width = 320;
    s.height = 180;
    assert_int_equal(encode(&s, 2000, false, &out, &key), PEL_OK);
    assert_true(key);
    check_key(&out);
    pel_bytes_finish(&out);
    close_stream(&s);
}

static void test_refusals(void **state)
{
    (void)state;
    struct stream s = open_stream("auto", 64, 64);
    struct pel_bytes out;
    bool key;
    assert_int_equal(encode(&s, 0, false, &out, &key), PEL_ERR_INVALID);
    assert_int_equal(encode(&s, 1u << 30, false, &out, &key), PEL_ERR_INVALID);
    s.width = 8;
    assert_int_equal(encode(&s, 500, false, &out, &key), PEL_ERR_INVALID);
    s.width = 5000;
    assert_int_equal(encode(&s, 500, false, &out, &key), PEL_ERR_INVALID);
    close_stream(&s);
    s = open_stream("nosuchenc", 64, 64);
    assert_int_equal(encode(&s, 500, false, &out, &key), PEL_ERR_NOT_FOUND);
    assert_non_null(strstr(s.fault.message, "gstreamer1.0-plugins-ugly"));
    close_stream(&s);
}

static void test_cancel(void **state)
{
    (void)state;
    atomic_bool cancel = true;
    struct pel_video_config config = { .fps = 30.0, .cancel = &cancel };
    static uint8_t rgba[64 * 64 * 4];
    struct pel_video *video = pel_video_create(&config);
    struct pel_video_picture picture = { .rgba = rgba,
                                         .width = 64,
                                         .height = 64 };
    struct pel_bytes out;
    bool key;
    assert_int_equal(pel_video_encode(video, &picture, 500, &out, &key, NULL),
                     PEL_ERR_CONFLICT);
    pel_video_destroy(video);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_x264),
        cmocka_unit_test(test_openh264),
        cmocka_unit_test(test_rate_changes),
        cmocka_unit_test(test_rate_is_of_time),
        cmocka_unit_test(test_size_changes),
        cmocka_unit_test(test_refusals),
        cmocka_unit_test(test_cancel),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
