/* Requests of many host frames, asked faster than their seas are computed. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <glib.h>

#include "bounds.h"
#include "bridges/cigi_answers.h"
#include "bridges/cigi_testkit.h"

#define MOMENTS 40
#define EACH 100

static struct pel_cigi_answers *waiting;

static int open_all(void **state)
{
    open_bridge(state);
    must(scene, "{\"sea\":{\"synthesiser\":\"FFT\"}}");
    waiting = pel_cigi_answers_create(true);
    return 0;
}

static int close_all(void **state)
{
    pel_cigi_answers_destroy(waiting);
    return close_bridge(state);
}

/* `count` heights at moment `number`, whose ids tell the moment. */
static void ask_heights(uint32_t number, size_t count)
{
    static struct pel_cigi_world world;
    struct pel_cigi_packet p = pel_cigi_packet_of(PEL_CIGI_KIND_HAT_REQUEST);
    const struct pel_cigi_packet *list[PEL_CIGI_MAX_QUESTIONS];
    pel_cigi_world_init(&world);
    pel_cigi_set(&p, PEL_CIGI_HAT_REQUEST_ID, number);
    pel_cigi_set(&p, PEL_CIGI_HAT_REQUEST_TYPE, 2);
    pel_cigi_set(&p, PEL_CIGI_HAT_REQUEST_LATITUDE, 52.6);
    pel_cigi_set(&p, PEL_CIGI_HAT_REQUEST_LONGITUDE, 5.2);
    for (size_t i = 0; i < count; i++) {
        list[i] = &p;
    }
    struct pel_cigi_moment moment = {
        .snapshot = pel_scene_snapshot(scene),
        .world = &world,
        .time_s = number / 60.0,
        .host_frame = number,
    };
    pel_cigi_answers_ask(waiting, &moment, list, count);
    pel_snapshot_unref(moment.snapshot);
}

static struct pel_cigi_packet next_of_all(void)
{
    const struct pel_cigi_packet *p;
    while (!(p = pel_cigi_answers_peek(waiting))) {
        g_usleep(1000);
    }
    struct pel_cigi_packet answer = *p;
    pel_cigi_answers_pop(waiting);
    return answer;
}

static void all_are_answered(void **state)
{
    (void)state;
    for (uint32_t i = 1; i <= MOMENTS; i++) {
        ask_heights(i, EACH);
    }
    assert_int_equal(pel_cigi_answers_dropped(waiting), 0);
    const struct pel_snapshot *s = pel_scene_snapshot(scene);
    for (uint32_t i = 0; i < MOMENTS * EACH; i++) {
        struct pel_cigi_packet a = next_of_all();
        uint32_t asked = 1 + i / EACH;
        uint32_t of = (uint32_t)pel_cigi_get(&a, PEL_CIGI_HAT_EXTENDED_ID);
        assert_int_equal(of, asked); /* in their order */
        /* The answer is the sea of the frame that it names: its own, or a later
         * one. */
        uint32_t low =
            (uint32_t)pel_cigi_get(&a, PEL_CIGI_HAT_EXTENDED_HOST_FRAME);
        bool found = false;
        for (uint32_t n = asked; n <= MOMENTS && !found; n++) {
            struct pel_vec2 at = { 0, 0 };
            struct pel_surface_sample sea;
            if ((n & 15) == low) {
                pel_snapshot_surface(s, &at, 1, n / 60.0, false, &sea);
                found = fabs(pel_cigi_get(&a, PEL_CIGI_HAT_EXTENDED_HOT) -
                             sea.height_m) < 1e-6;
            }
        }
        assert_true(found || i % EACH != 0);
    }
    assert_null(pel_cigi_answers_peek(waiting));
    pel_snapshot_unref(s);
}

static void beyond_the_bound_the_oldest_go(void **state)
{
    (void)state;
    size_t most = PEL_BOUND_CIGI_WAITING, asked = 0;
    uint32_t number = 0;
    while (asked < 3 * most) {
        ask_heights(++number, 512);
        asked += 512;
    }
    size_t dropped = pel_cigi_answers_dropped(waiting);
    assert_int_equal(dropped, asked - most);
    for (size_t i = 0; i < most; i++) {
        next_of_all();
    }
    /* What was taken still counts until its frame is sent. */
    ask_heights(++number, 512);
    assert_int_equal(pel_cigi_answers_dropped(waiting), dropped + 512);
    pel_cigi_answers_begin(waiting, true);
    ask_heights(++number, 512);
    next_of_all();
    assert_int_equal(pel_cigi_answers_dropped(waiting), dropped + 512);
}

static void what_is_not_sent_comes_again(void **state)
{
    (void)state;
    for (uint32_t i = 1; i <= 3; i++) {
        ask_heights(i, 2);
    }
    double seen = 0;
    for (int i = 0; i < 3; i++) {
        struct pel_cigi_packet a = next_of_all();
        seen = pel_cigi_get(&a, PEL_CIGI_HAT_EXTENDED_ID);
    }
    assert_near(seen, 2, 0);
    const double again[] = { 1, 1, 2, 2, 3 };
    pel_cigi_answers_begin(waiting, false);
    for (size_t i = 0; i < G_N_ELEMENTS(again); i++) {
        struct pel_cigi_packet a = next_of_all();
        assert_near(pel_cigi_get(&a, PEL_CIGI_HAT_EXTENDED_ID), again[i], 0);
    }
    pel_cigi_answers_begin(waiting, true);
    struct pel_cigi_packet a = next_of_all();
    assert_near(pel_cigi_get(&a, PEL_CIGI_HAT_EXTENDED_ID), 3, 0);
    pel_cigi_answers_begin(waiting, false);
    a = next_of_all();
    assert_near(pel_cigi_get(&a, PEL_CIGI_HAT_EXTENDED_ID), 3, 0);
    pel_cigi_answers_begin(waiting, true);
    assert_null(pel_cigi_answers_peek(waiting));
    pel_cigi_answers_begin(waiting, false);
    assert_null(pel_cigi_answers_peek(waiting));
}

static void a_host_that_is_gone_gets_none(void **state)
{
    (void)state;
    for (uint32_t i = 1; i <= MOMENTS; i++) {
        ask_heights(i, EACH);
    }
    next_of_all();
    pel_cigi_answers_clear(waiting);
    ask_heights(100, 1);
    struct pel_cigi_packet a = next_of_all();
    assert_near(pel_cigi_get(&a, PEL_CIGI_HAT_EXTENDED_ID), 100, 0);
    pel_cigi_answers_begin(waiting, true);
    assert_null(pel_cigi_answers_peek(waiting));
    assert_int_equal(pel_cigi_answers_dropped(waiting), 0);
}

#define TEST(function)                                                         \
    cmocka_unit_test_setup_teardown(function, open_all, close_all)

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(all_are_answered),
        TEST(beyond_the_bound_the_oldest_go),
        TEST(what_is_not_sent_comes_again),
        TEST(a_host_that_is_gone_gets_none),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
