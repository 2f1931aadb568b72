/* Real time for answers: its rule, and what the system then says. */
#include <math.h>
#include <pthread.h>
#include <sched.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <glib.h>

#include "base/urgent.h"

#define NS_MS 1000000LL

/* Threads use `used` of each millisecond for `ms`; how many of these the rule
 * lets it be real time. */
static int real_ms(struct pel_urgent *self, int ms, double used)
{
    int real = 0;
    for (int i = 0; i < ms; i++) {
        self->real =
            pel_urgent_credit(self, self->wall_ns + NS_MS,
                              self->cpu_ns + (int64_t)(used * (double)NS_MS));
        real += self->real;
    }
    return real;
}

static void modest_threads_stay_real(void **state)
{
    (void)state;
    struct pel_urgent self = { .real = true, .credit_ns = PEL_URGENT_BURST_NS };
    assert_int_equal(real_ms(&self, 10000, 0.99 * PEL_URGENT_SHARE), 10000);
}

static void greedy_threads_have_a_burst(void **state)
{
    (void)state;
    struct pel_urgent self = { .real = true, .credit_ns = PEL_URGENT_BURST_NS };
    int burst = (int)(PEL_URGENT_BURST_NS / NS_MS / (1 - PEL_URGENT_SHARE));
    assert_in_range(real_ms(&self, 10000, 1.0), burst, burst + 1);
    /* it went as deep as a burst is high, and needs half of one */
    int rest = (int)(1.5 * PEL_URGENT_BURST_NS / NS_MS / PEL_URGENT_SHARE);
    assert_int_equal(real_ms(&self, rest - 1, 0.0), 0);
    assert_int_equal(real_ms(&self, 10, 0.0), 9);
}

static void bursts_leave_the_share(void **state)
{
    (void)state;
    struct pel_urgent self = { .real = true, .credit_ns = PEL_URGENT_BURST_NS };
    double used_real = 0; /* works while real, waits while not */
    for (int i = 0; i < 100000; i++) {
        used_real += self.real;
        (void)real_ms(&self, 1, self.real ? 1.0 : 0.0);
    }
    assert_true(fabs(used_real * 1e-5 - PEL_URGENT_SHARE) < 0.01);
}

/* What is used beyond an allowance is owed. */
static void allowances_are_shares(void **state)
{
    (void)state;
    struct pel_allowance self = { .share = 0.1, .burst_ns = 5 * NS_MS };
    int64_t now_ns = 1000000 * NS_MS, used_ns = 0;
    for (int i = 0; i < 10000; i++, now_ns += NS_MS) {
        if (pel_allowance_has(&self, now_ns)) {
            used_ns += 7 * NS_MS;
            pel_allowance_spend(&self, 7 * NS_MS);
        }
    }
    assert_in_range(used_ns / NS_MS, 1000, 1000 + 5 + 7);
    now_ns += 3600 * 1000 * NS_MS; /* no more than a burst is saved */
    assert_true(pel_allowance_has(&self, now_ns));
    pel_allowance_spend(&self, 5 * NS_MS);
    assert_false(pel_allowance_has(&self, now_ns));
}

/* Atomic, since ThreadSanitizer does not see how GLib's pools wait. */
static void *ask(void *out)
{
    atomic_store((atomic_int *)out, sched_getscheduler(0));
    return NULL;
}

static int policy_of_child(void)
{
    atomic_int policy = -1;
    pthread_t thread;
    assert_int_equal(pthread_create(&thread, NULL, ask, &policy), 0);
    pthread_join(thread, NULL);
    return policy;
}

static void ask_in_pool(gpointer out, gpointer user)
{
    (void)user;
    (void)ask(out);
}

/* GStreamer's and GIO's threads come from such pools. */
static int policy_of_pool(void)
{
    atomic_int policy = -1;
    GThreadPool *pool = g_thread_pool_new(ask_in_pool, NULL, 1, FALSE, NULL);
    g_thread_pool_push(pool, &policy, NULL);
    g_thread_pool_free(pool, FALSE, TRUE);
    return policy;
}

static void *be_urgent(void *unused)
{
    struct pel_urgent self;
    (void)unused;
    pel_urgent_begin(&self, PEL_URGENT_ANSWERS);
    assert_true(self.real);
    assert_int_equal(sched_getscheduler(0), SCHED_RR | SCHED_RESET_ON_FORK);
    assert_int_equal(policy_of_child(), SCHED_OTHER);
    assert_int_equal(policy_of_pool(), SCHED_OTHER);
    /* More than it can have earned meanwhile, on a busy machine too. */
    self.credit_ns = -60000 * NS_MS;
    pel_urgent_account(&self);
    assert_false(self.real);
    assert_int_equal(sched_getscheduler(0) & ~SCHED_RESET_ON_FORK, SCHED_OTHER);
    self.credit_ns = PEL_URGENT_BURST_NS;
    pel_urgent_account(&self);
    assert_int_equal(sched_getscheduler(0), SCHED_RR | SCHED_RESET_ON_FORK);
    return NULL;
}

static void the_system_agrees(void **state)
{
    (void)state;
    bool real = true;
    struct pel_fault fault;
    assert_int_equal(pel_urgent_init(PEL_REALTIME_OFF, &real, &fault), PEL_OK);
    assert_false(real);
    assert_int_equal(pel_urgent_init(PEL_REALTIME_AUTO, &real, &fault), PEL_OK);
    if (!real) {
        assert_int_equal(pel_urgent_init(PEL_REALTIME_ON, &real, &fault),
                         PEL_ERR_IO);
        skip(); /* not permitted here */
    }
    assert_int_equal(sched_getscheduler(0), SCHED_OTHER);
    pthread_t thread;
    assert_int_equal(pthread_create(&thread, NULL, be_urgent, NULL), 0);
    pthread_join(thread, NULL);
    pel_nudge();
}

/* Waits until there are more beats than `before`, or for `ms`. */
static bool beats_beyond(unsigned long before, int ms)
{
    const struct timespec rest = { .tv_nsec = NS_MS };
    for (int i = 0; i < ms && pel_beats() <= before; i++) {
        nanosleep(&rest, NULL);
    }
    return pel_beats() > before;
}

static void beats_while_clients_ask(void **state)
{
    (void)state;
    bool real;
    struct pel_fault fault;
    assert_int_equal(pel_urgent_init(PEL_REALTIME_OFF, &real, &fault), PEL_OK);
    assert_false(beats_beyond(0, 50)); /* nobody has asked */
    for (int round = 0; round < 2; round++) {
        unsigned long before = pel_beats();
        for (int i = 0; i < 20;
             i++) { /* one that comes before the wait is lost */
            pel_beat();
            if (beats_beyond(before, 500)) {
                break;
            }
        }
        assert_true(pel_beats() > before);
        /* It ends PEL_BEAT_NS after the last. */
        const struct timespec end = { .tv_nsec = 2 * PEL_BEAT_NS };
        nanosleep(&end, NULL);
        unsigned long last = pel_beats();
        assert_false(beats_beyond(last, 100));
    }
}

static void real_time_needs_no_beat(void **state)
{
    (void)state;
    bool real;
    struct pel_fault fault;
    assert_int_equal(pel_urgent_init(PEL_REALTIME_AUTO, &real, &fault), PEL_OK);
    if (!real) {
        skip(); /* not permitted here */
    }
    unsigned long before = pel_beats();
    pel_beat();
    assert_false(beats_beyond(before, 50));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(modest_threads_stay_real),
        cmocka_unit_test(greedy_threads_have_a_burst),
        cmocka_unit_test(bursts_leave_the_share),
        cmocka_unit_test(allowances_are_shares),
        cmocka_unit_test(the_system_agrees),
        cmocka_unit_test(beats_while_clients_ask),
        cmocka_unit_test(real_time_needs_no_beat),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
