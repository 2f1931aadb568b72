#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include <cmocka.h>
#include <glib.h>

#include "base/clock.h"
#include "base/log.h"
#include "base/watch.h"

static void spin(int64_t ns)
{
    int64_t end_ns = pel_now_ns() + ns;
    while (pel_now_ns() < end_ns) {
    }
}

static gint sleeping_poll(GPollFD *fds, guint count, gint timeout)
{
    pel_watch_sleep();
    gint n = g_poll(fds, count, timeout);
    pel_watch_wake();
    return n;
}

static gboolean long_one(gpointer user)
{
    PEL_WATCH("long one");
    spin(3000000);
    (void)user;
    return G_SOURCE_REMOVE;
}

static void inner(void)
{
    PEL_WATCH("inner");
    spin(3000000);
}

static gboolean outer(gpointer user)
{
    PEL_WATCH("outer");
    inner();
    (void)user;
    return G_SOURCE_REMOVE;
}

static gboolean nameless(gpointer user)
{
    spin(3000000);
    (void)user;
    return G_SOURCE_REMOVE;
}

static gpointer elsewhere(gpointer user)
{
    PEL_WATCH("elsewhere");
    spin(3000000);
    return user;
}

static gboolean nothing(gpointer user)
{
    (void)user;
    return G_SOURCE_REMOVE;
}

struct turns {
    GSourceFunc calls[4];
    size_t at;
    gpointer user;
};

/* Each call in a turn of its own, however late the turns come. */
static gboolean next_turn(gpointer user)
{
    struct turns *turns = user;
    turns->calls[turns->at++](turns->user);
    return turns->at < G_N_ELEMENTS(turns->calls) && turns->calls[turns->at]
               ? G_SOURCE_CONTINUE
               : G_SOURCE_REMOVE;
}

static void run_turns(struct turns *turns)
{
    guint source = g_timeout_add(1, next_turn, turns);
    while (g_main_context_find_source_by_id(NULL, source)) {
        g_main_context_iteration(NULL, TRUE);
    }
}

/* Waits as a thread does that gets no processor. */
static gboolean waiting(gpointer user)
{
    PEL_WATCH("waiting");
    g_usleep(3000);
    (void)user;
    return G_SOURCE_REMOVE;
}

static int64_t thread_ns(void)
{
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return (int64_t)t.tv_sec * 1000000000 + t.tv_nsec;
}

static gboolean working(gpointer user)
{
    PEL_WATCH("working");
    int64_t end_ns = thread_ns() + 3000000;
    while (thread_ns() < end_ns) {
    }
    *(int64_t *)user = pel_watch_spent_ns();
    return G_SOURCE_REMOVE;
}

/* By its own processor time the thread is busy with work alone, whatever else
 * the machine does. */
static void busy_is_processor_time(void **state)
{
    (void)state;
    int64_t spent_ns = 0;
    struct turns turns = { { waiting, working }, 0, &spent_ns };
    pel_log_set_level(PEL_LOG_ERROR);
    pel_watch_begin();
    run_turns(&turns);
    assert_int_equal(pel_watch_stalls("waiting"), 1);
    assert_int_equal(pel_watch_busy("waiting"), 0);
    assert_int_equal(pel_watch_stalls("working"), 1);
    assert_int_equal(pel_watch_busy("working"), 1);
    assert_true(spent_ns >= 3000000);
    assert_int_equal(pel_watch_spent_ns(), 0);
    pel_watch_end();
}

/* A busy machine may take the processor away in `outer`, whose stall it is
 * then: another trial. */
static void stalls_are_seen(void **state)
{
    (void)state;
    pel_log_set_level(PEL_LOG_ERROR);
    g_main_context_set_poll_func(NULL, sleeping_poll);
    for (int trial = 0; trial < 500; trial++) {
        struct turns turns = { { long_one, outer, nameless, nothing },
                               0,
                               NULL };
        pel_watch_begin();
        run_turns(&turns);
        if (pel_watch_stalls("outer") == 0) {
            break;
        }
    }
    assert_int_equal(pel_watch_count("long one"), 1);
    assert_int_equal(pel_watch_stalls("long one"), 1);
    assert_int_equal(pel_watch_count("inner"), 1);
    assert_int_equal(pel_watch_stalls("inner"), 1);
    assert_int_equal(pel_watch_count("outer"), 1);
    assert_int_equal(pel_watch_stalls("outer"), 0);
    assert_true(pel_watch_stalls("other") >= 1);
    struct pel_metrics *metrics = pel_metrics_create();
    pel_metrics_add(metrics, pel_watch_collect, NULL);
    char *text = pel_metrics_text(metrics, NULL);
    assert_non_null(
        strstr(text, "pelagos_control_stalls_total{what=\"long one\"} 1\n"));
    free(text);
    pel_metrics_destroy(metrics);
    pel_watch_end();
}

static void other_threads_are_not_watched(void **state)
{
    (void)state;
    pel_watch_begin();
    g_thread_join(g_thread_new("elsewhere", elsewhere, NULL));
    assert_int_equal(pel_watch_count("elsewhere"), 0);
    pel_watch_end();
    elsewhere(NULL);
    assert_int_equal(pel_watch_count("elsewhere"), 0);
}

/* Ten hours with a stall a second leave few lines, and waiting for a busy
 * machine leaves none. */
static void the_log_is_not_filled(void **state)
{
    (void)state;
    const int64_t ms = 1000000, second = 1000 * ms;
    struct pel_watch_told told = { 0 }, waited = { 0 };
    int64_t last_s = -60;
    int lines = 0;
    for (int64_t s = 0; s < 36000; s++) {
        bool tells = pel_watch_tells(&told, 3 * ms, 2 * ms, s * second);
        assert_true(!tells || s - last_s >= 60);
        last_s = tells ? s : last_s;
        lines += tells;
        assert_false(pel_watch_tells(&waited, 30 * ms, ms / 2, s * second));
    }
    assert_in_range(lines, 8, 20);
    assert_true(pel_watch_tells(&waited, 60 * ms, 0, 0));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(stalls_are_seen),
        cmocka_unit_test(busy_is_processor_time),
        cmocka_unit_test(other_threads_are_not_watched),
        cmocka_unit_test(the_log_is_not_filled),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
