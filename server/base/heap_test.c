/* Pages between blocks that are in use go back to the system; what is discarded
 * is dropped once, by the thread where there is one. */
#include "base/heap.h"

#include <pthread.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include <cmocka.h>

/* Too small to be the system's own, large enough to have whole pages. */
enum { BLOCKS = 2000, BLOCK = 32 << 10 };

static double resident(void)
{
    long all = 0, pages = 0;
    FILE *f = fopen("/proc/self/statm", "r");
    assert_non_null(f);
    assert_int_equal(fscanf(f, "%ld %ld", &all, &pages), 2);
    fclose(f);
    return (double)pages * (double)sysconf(_SC_PAGESIZE);
}

static void free_pages_go_back(void **state)
{
    (void)state;
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
    skip(); /* another's heap */
#endif
    static void *blocks[BLOCKS];
    pel_heap_settle();
    for (int i = 0; i < BLOCKS; i++) {
        blocks[i] = malloc(BLOCK);
        assert_non_null(blocks[i]);
        memset(blocks[i], i, BLOCK);
    }
    for (int i = 0; i < BLOCKS; i += 2) {
        free(blocks[i]);
    }
    const double before = resident(), free_bytes = BLOCKS / 2.0 * BLOCK;
    pel_heap_begin();
    double gone = 0;
    /* Three pauses: a busy machine may be late. */
    for (int i = 0; i < 30 * PEL_HEAP_PAUSE_S && gone < 0.5 * free_bytes; i++) {
        nanosleep(&(struct timespec){ .tv_nsec = 100000000 }, NULL);
        gone = before - resident();
    }
    pel_heap_end();
    print_message("%.1f of %.1f MB\n", gone * 1e-6, free_bytes * 1e-6);
    /* Of a block of eight pages seven lie whole in it. */
    assert_true(gone > 0.5 * free_bytes);
    for (int i = 1; i < BLOCKS; i += 2) {
        free(blocks[i]);
    }
}

struct load {
    struct pel_discard discard; /* first */
    pthread_t by;
    int times;
};

static void drop(struct pel_discard *discard)
{
    struct load *load = (struct load *)discard;
    load->by = pthread_self();
    load->times++;
}

static void loads_are_dropped_once(void **state)
{
    (void)state;
    static struct load loads[100], late;
    for (int round = 0; round < 2; round++) { /* the thread can begin again */
        memset(loads, 0, sizeof loads);
        pel_heap_begin();
        for (int i = 0; i < 100; i++) {
            loads[i].discard.drop = drop;
            pel_heap_discard(&loads[i].discard);
        }
        pel_heap_end();
        for (int i = 0; i < 100; i++) {
            assert_int_equal(loads[i].times, 1);
            assert_false(pthread_equal(loads[i].by, pthread_self()));
        }
    }
    late.discard.drop = drop;
    pel_heap_discard(&late.discard);
    assert_true(late.times == 1 && pthread_equal(late.by, pthread_self()));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(free_pages_go_back),
        cmocka_unit_test(loads_are_dropped_once),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
