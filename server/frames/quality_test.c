#include "frames/quality.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>

#include <cmocka.h>

#define PERIOD_MS (1000.0 / 30.0)
#define PIXELS (1280 * 720)

/* A renderer whose frames cost some ms at any size, and more by the pixel. */
struct machine {
    struct pel_quality quality;
    double fixed_ms, full_ms;
    uint64_t pixels;
    int64_t now_ns;
};

static double cost(const struct machine *m)
{
    double scale = pel_quality_scale(&m->quality);
    return m->fixed_ms + m->full_ms * scale * scale;
}

static struct machine machine(double fixed_ms, double full_ms)
{
    struct machine m = { .fixed_ms = fixed_ms,
                         .full_ms = full_ms,
                         .pixels = PIXELS,
                         .now_ns = 1000000000 };
    pel_quality_set(&m.quality, 0);
    return m;
}

/* Draws for so long; returns the number of changes. */
static unsigned draw_for(struct machine *m, double seconds)
{
    unsigned changes = 0;
    int64_t end = m->now_ns + (int64_t)(seconds * 1e9);
    while (m->now_ns < end) {
        double ms = cost(m);
        m->now_ns += (int64_t)(fmax(ms, PERIOD_MS) * 1e6);
        changes += pel_quality_feed(&m->quality, pel_quality_scale(&m->quality),
                                    m->pixels, ms, PERIOD_MS, m->now_ns);
    }
    return changes;
}

static void test_cheap_frames_stay_full(void **state)
{
    (void)state;
    struct machine m = machine(1, 20);
    assert_int_equal(draw_for(&m, 60), 0);
    assert_true(pel_quality_scale(&m.quality) == 1.0);
}

static void test_dear_frames_keep_the_rate_within_a_second(void **state)
{
    (void)state;
    struct machine m = machine(2, 104);
    assert_in_range(draw_for(&m, 1), 1, 2);
    assert_true(cost(&m) < PERIOD_MS);
    /* No coarser than needed: two steps finer would not do. */
    m.quality.step -= 2;
    assert_true(cost(&m) > PERIOD_MS);
}

static void test_it_does_not_flap(void **state)
{
    (void)state;
    /* Any machine, ten minutes: it finds its step and stays there. */
    for (double full = 10; full < 400; full *= 1.1) {
        struct machine m = machine(3, full);
        draw_for(&m, 10);
        unsigned step = m.quality.step;
        assert_int_equal(draw_for(&m, 600), 0);
        assert_int_equal(m.quality.step, step);
    }
}

/* Frames of a coarser scale, which another machine has asked for. */
static void test_coarser_frames_tell_of_an_overload_alone(void **state)
{
    (void)state;
    struct machine m = machine(1, 20);
    draw_for(&m, 1);
    for (int i = 0; i < 200; i++) {
        m.now_ns += 33000000;
        assert_false(
            pel_quality_feed(&m.quality, 0.5, PIXELS, 6, PERIOD_MS, m.now_ns));
    }
    assert_true(pel_quality_scale(&m.quality) == 1.0);
    for (int i = 0; i < PEL_QUALITY_SAMPLES; i++) {
        m.now_ns += 50000000;
        pel_quality_feed(&m.quality, 0.5, PIXELS, 50, PERIOD_MS, m.now_ns);
    }
    assert_true(pel_quality_scale(&m.quality) < 0.5);
    /* Finer ones are of before it was asked for less. */
    double scale = pel_quality_scale(&m.quality);
    for (int i = 0; i < 200; i++) {
        m.now_ns += 33000000;
        assert_false(
            pel_quality_feed(&m.quality, 1, PIXELS, 90, PERIOD_MS, m.now_ns));
    }
    assert_true(pel_quality_scale(&m.quality) == scale);
}

static void test_a_step_that_fails_is_tried_ever_less(void **state)
{
    (void)state;
    struct machine m = machine(3, 60);
    unsigned changes = 0;
    draw_for(&m, 1);
    unsigned found = m.quality.step;
    assert_true(found > 0);
    for (int i = 0; i < 600; i++) { /* the load lies about the finer step */
        m.full_ms = m.quality.step < found ? 60 : 30;
        changes += draw_for(&m, 1);
    }
    /* Down and up after 3, 6, 12 .. 96 s, then every 96 s. */
    assert_in_range(changes, 8, 24);
}

static void test_it_comes_back(void **state)
{
    (void)state;
    struct machine m = machine(2, 104);
    draw_for(&m, 5);
    m.full_ms = 15;
    draw_for(&m, 60);
    assert_true(pel_quality_scale(&m.quality) == 1.0);
}

static void test_one_slow_frame_is_no_reason(void **state)
{
    (void)state;
    struct machine m = machine(2, 20);
    for (int i = 0; i < 100; i++) {
        double ms = i % 7 == 0 ? 300 : 22;
        assert_false(pel_quality_feed(&m.quality, 1.0, PIXELS, ms, PERIOD_MS,
                                      m.now_ns += 33000000));
    }
}

static void test_frames_under_way_do_not_count(void **state)
{
    (void)state;
    struct machine m = machine(2, 104);
    draw_for(&m, 0.4);
    assert_true(m.quality.step > 0);
    unsigned step = m.quality.step;
    for (int i = 0; i < 20; i++) { /* drawn before it changed */
        assert_false(pel_quality_feed(&m.quality, 1.0, PIXELS, 106, PERIOD_MS,
                                      m.now_ns));
    }
    assert_int_equal(m.quality.step, step);
}

static void test_hopeless_frames_stay_at_the_coarsest(void **state)
{
    (void)state;
    struct machine m = machine(50, 100);
    draw_for(&m, 5);
    assert_true(fabs(pel_quality_scale(&m.quality) - PEL_QUALITY_MIN) < 1e-12);
    assert_int_equal(draw_for(&m, 60), 0);
}

static void test_fixed(void **state)
{
    (void)state;
    struct machine m = machine(2, 104);
    pel_quality_set(&m.quality, 0.6);
    assert_int_equal(draw_for(&m, 5), 0);
    assert_true(pel_quality_scale(&m.quality) == 0.6);
    pel_quality_set(&m.quality, 0);
    assert_true(pel_quality_scale(&m.quality) == 1.0);
}

static void test_what_is_known_is_used_at_once(void **state)
{
    (void)state;
    struct pel_quality q = { .pixel_ms = 106.0 / PIXELS };
    pel_quality_set(&q, 0);
    assert_false(pel_quality_expect(&q, 320 * 180, PERIOD_MS));
    assert_true(pel_quality_expect(&q, PIXELS, PERIOD_MS));
    double scale = pel_quality_scale(&q);
    assert_true(106.0 * scale * scale < PERIOD_MS && scale > 0.4);
    assert_false(pel_quality_expect(&q, PIXELS, PERIOD_MS));
    /* Frames cost a third of what was thought: that is learnt. */
    for (int i = 0; i < 20; i++) {
        pel_quality_feed(&q, pel_quality_scale(&q), PIXELS,
                         35.0 * scale * scale, PERIOD_MS, 0);
    }
    assert_true(fabs(q.pixel_ms * PIXELS - 35.0) < 1e-6);
    /* Nothing is known: nothing is done. */
    q = (struct pel_quality){ 0 };
    pel_quality_set(&q, 0);
    assert_false(pel_quality_expect(&q, 64 * PIXELS, PERIOD_MS));
    pel_quality_set(&q, 0.9);
    q.pixel_ms = 1;
    assert_false(pel_quality_expect(&q, 65 * PIXELS, PERIOD_MS));
}

static void test_sizes(void **state)
{
    (void)state;
    assert_int_equal(pel_quality_size(1.0, 1281), 1281);
    assert_int_equal(pel_quality_size(0.5, 1280), 640);
    assert_int_equal(pel_quality_size(0.5, 721), 360);
    assert_int_equal(pel_quality_size(0.25, 40), 16);
    assert_int_equal(pel_quality_size(0.25, 11), 11);
    for (uint32_t full = 16; full < 4097; full++) {
        uint32_t size = pel_quality_size(0.42, full);
        assert_true(size <= full && size >= 16 && size % 2 == 0);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_cheap_frames_stay_full),
        cmocka_unit_test(test_dear_frames_keep_the_rate_within_a_second),
        cmocka_unit_test(test_it_does_not_flap),
        cmocka_unit_test(test_coarser_frames_tell_of_an_overload_alone),
        cmocka_unit_test(test_a_step_that_fails_is_tried_ever_less),
        cmocka_unit_test(test_it_comes_back),
        cmocka_unit_test(test_one_slow_frame_is_no_reason),
        cmocka_unit_test(test_frames_under_way_do_not_count),
        cmocka_unit_test(test_hopeless_frames_stay_at_the_coarsest),
        cmocka_unit_test(test_fixed),
        cmocka_unit_test(test_what_is_known_is_used_at_once),
        cmocka_unit_test(test_sizes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
