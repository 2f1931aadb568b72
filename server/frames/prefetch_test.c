/* When questions about now will come. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "frames/prefetch.h"

#define MS INT64_C(1000000)

static const int sea, other_sea, who[8];

/* A clock that showed `start_s` at 0 ns. */
struct asking {
    struct pel_prefetch prefetch;
    double start_s, rate;
    double answered_s; /* the last answer's time */
    int prefetched, exact, begun;
};

static double clock_s(const struct asking *a, int64_t ns)
{
    return a->start_s + (double)ns * 1e-9 * a->rate;
}

static void ask(struct asking *a, int asker, int64_t now_ns)
{
    double next_s = NAN, time_s = clock_s(a, now_ns);
    int64_t begin_ns = -1;
    double answer_s = pel_prefetch_now(&a->prefetch, &sea, time_s, a->rate);
    assert_true(fabs(answer_s - time_s) <= PEL_PREFETCH_S * a->rate);
    assert_true(answer_s >= a->answered_s);
    a->answered_s = answer_s;
    a->exact += answer_s == time_s;
    a->prefetched += answer_s != time_s;
    if (pel_prefetch_next(&a->prefetch, &who[asker], &sea, now_ns, time_s,
                          a->rate, &next_s, &begin_ns)) {
        a->begun++;
        assert_true(next_s > time_s);
        assert_true(begin_ns > now_ns);
        assert_true(clock_s(a, begin_ns) < next_s);
    }
}

/* −1 .. 1 */
static double jitter(uint32_t *state)
{
    *state = *state * 1664525u + 1013904223u;
    return (double)(*state >> 8) / (1 << 23) - 1.0;
}

static void in_step(void **state)
{
    (void)state;
    static const double rates[] = { 1, 0.1, 10 };
    for (int r = 0; r < 3; r++) {
        struct asking a = { .start_s = 1e6, .rate = rates[r] };
        uint32_t seed = 1;
        for (int i = 0; i < 600; i++) {
            ask(&a, 0,
                i * 50 * MS / 3 + (int64_t)(1.5 * (double)MS * jitter(&seed)));
        }
        assert_int_equal(a.exact, 2); /* the first two */
        assert_int_equal(a.prefetched, 598);
        assert_int_equal(a.begun, 599);
    }
}

static void several_at_once(void **state)
{
    (void)state;
    struct asking a = { .start_s = 3, .rate = 1 };
    uint32_t seed = 7;
    for (int i = 0; i < 6000; i++) {
        int64_t turn = i / 3, phase = i % 3 * 4 * MS;
        ask(&a, i % 3,
            turn * 20 * MS + phase + (int64_t)((double)MS * jitter(&seed)));
    }
    assert_in_range(a.exact, 0, 30); /* of 6000 */
    /* fewer moments than questions: some are near enough to another's */
    assert_in_range(a.begun, 2000, 4500);
}

static void out_of_step(void **state)
{
    (void)state;
    struct asking a = { .start_s = 0, .rate = 1 };
    uint32_t seed = 3;
    int64_t now_ns = 0;
    for (int i = 0; i < 1000; i++) {
        now_ns += (int64_t)((150 + 140 * jitter(&seed)) * (double)MS);
        ask(&a, 0, now_ns);
    }
    assert_true(a.exact > 800);
    /* too seldom, and too often */
    memset(&a.prefetch, 0, sizeof a.prefetch);
    a.begun = 0;
    for (int i = 0; i < 100; i++) {
        ask(&a, 0, now_ns += 251 * MS);
    }
    for (int i = 0; i < 100; i++) {
        ask(&a, 1, now_ns += MS);
    }
    assert_int_equal(a.begun, 0);
}

static void jumps_are_not_followed(void **state)
{
    (void)state;
    struct asking a = { .start_s = 100, .rate = 1 };
    for (int i = 0; i < 10; i++) {
        ask(&a, 0, i * 20 * MS);
    }
    /* another sea, a clock set back or on: none of what was prefetched */
    double time_s = clock_s(&a, 200 * MS);
    assert_true(pel_prefetch_now(&a.prefetch, &sea, time_s + 0.001, 1) ==
                time_s);
    assert_true(pel_prefetch_now(&a.prefetch, &other_sea, time_s + 0.001, 1) ==
                time_s + 0.001);
    assert_true(pel_prefetch_now(&a.prefetch, &sea, 50.0, 1) == 50.0);
    assert_true(pel_prefetch_now(&a.prefetch, &sea, 150.0, 1) == 150.0);
    /* more askers than there is room for: the oldest goes */
    for (int i = 1; i < 8; i++) {
        ask(&a, i, (200 + i) * MS);
    }
    ask(&a, 0, 221 * MS);
    assert_ptr_equal(a.prefetch.askers[0].who == &who[0] ||
                             a.prefetch.askers[1].who == &who[0] ||
                             a.prefetch.askers[2].who == &who[0] ||
                             a.prefetch.askers[3].who == &who[0]
                         ? &who[0]
                         : NULL,
                     &who[0]);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(in_step),
        cmocka_unit_test(several_at_once),
        cmocka_unit_test(out_of_step),
        cmocka_unit_test(jumps_are_not_followed),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
