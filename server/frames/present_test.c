#include "frames/present.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

static void feed(struct pel_present *p, int pictures, double ready_ms)
{
    for (int i = 0; i < pictures; i++) {
        pel_present_feed(p, ready_ms);
    }
}

static void the_slowest_decide(void **state)
{
    (void)state;
    struct pel_present p;
    pel_present_begin(&p);
    assert_true(p.delay_ms == 100.0);
    feed(&p, 15, 20.0);
    assert_true(p.delay_ms == 100.0);
    feed(&p, 1, 20.0);
    assert_true(p.delay_ms == 20.0 + PEL_DELIVERY_MS);
    /* Of 256 pictures five may come too late, the sixth not. */
    feed(&p, 240, 20.0);
    feed(&p, 5, 90.0);
    feed(&p, 11, 20.0);
    assert_true(p.delay_ms == 20.0 + PEL_DELIVERY_MS);
    feed(&p, 1, 90.0);
    feed(&p, 15, 20.0);
    assert_true(p.delay_ms == 90.0 + PEL_DELIVERY_MS);
}

static void it_shrinks_slowly(void **state)
{
    (void)state;
    struct pel_present p;
    pel_present_begin(&p);
    feed(&p, 256, 360.0);
    assert_true(p.delay_ms == 400.0);
    feed(&p, 240, 10.0);
    double before_ms = 400.0;
    while (p.delay_ms > 50.0) {
        feed(&p, 16, 10.0);
        assert_true(p.delay_ms < before_ms &&
                    p.delay_ms >= before_ms * (15.0 / 16) - 1e-9);
        before_ms = p.delay_ms;
    }
    assert_true(p.delay_ms == 50.0);
    /* But at another scale at once. */
    feed(&p, 256, 360.0);
    pel_present_anew(&p);
    feed(&p, 16, 10.0);
    assert_true(p.delay_ms == 50.0);
}

/* Pages take what is further away for a clock that is wrong (step.js). */
static void nobody_waits_longer(void **state)
{
    (void)state;
    struct pel_present p;
    pel_present_begin(&p);
    feed(&p, 256, 9000.0);
    assert_true(p.delay_ms == PEL_PRESENT_MOST_MS + PEL_DELIVERY_MS);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_slowest_decide),
        cmocka_unit_test(it_shrinks_slowly),
        cmocka_unit_test(nobody_waits_longer),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
