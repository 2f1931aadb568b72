#include "render/turn.h"

#include <pthread.h>
#include <sched.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

#define DEVICES 4
#define TURNS 2000

static atomic_int inside, most_inside, ready;
static int order[DEVICES * TURNS], taken; /* of who has the turn */

static void *give_commands(void *argument)
{
    int own = (int)(intptr_t)argument;
    atomic_fetch_add(&ready, 1);
    while (atomic_load(&ready) < DEVICES) {
        sched_yield();
    }
    for (int i = 0; i < TURNS; i++) {
        bool turn = pel_turn_begin();
        int now = atomic_fetch_add(&inside, 1) + 1;
        if (now > atomic_load(&most_inside)) {
            atomic_store(&most_inside, now);
        }
        order[taken++] = own;
        sched_yield();
        atomic_fetch_sub(&inside, 1);
        pel_turn_end(turn);
    }
    return NULL;
}

static void who_waited_longest_is_next(void **state)
{
    (void)state;
    pthread_t threads[DEVICES];
    pel_turn_count(DEVICES);
    for (intptr_t i = 0; i < DEVICES; i++) {
        assert_int_equal(
            pthread_create(&threads[i], NULL, give_commands, (void *)i), 0);
    }
    for (int i = 0; i < DEVICES; i++) {
        pthread_join(threads[i], NULL);
    }
    pel_turn_count(-DEVICES);
    assert_int_equal(most_inside, 1);
    assert_int_equal(taken, DEVICES * TURNS);
    /* Whoever has it again at once was alone: the others were not waiting yet.
     * A lock that is not fair gives it to the same one nearly always. */
    int again = 0;
    for (int i = 1; i < taken; i++) {
        again += order[i] == order[i - 1];
    }
    print_message("%d of %d turns followed one of the same device\n", again,
                  taken);
    assert_true(again < taken / 4);
}

static void one_device_does_not_wait(void **state)
{
    (void)state;
    assert_false(pel_turn_begin());
    pel_turn_count(1);
    assert_false(pel_turn_begin());
    pel_turn_end(false);
    pel_turn_count(-1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(who_waited_longest_is_next),
        cmocka_unit_test(one_device_does_not_wait),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
