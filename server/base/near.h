/* For the test programs: cmocka with what it needs before it, and comparison
 * in double precision (cmocka's own compares floats). */
#pragma once

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

/* Fails unless |actual − expected| ≤ tolerance; NaN fails. */
#define assert_near(actual, expected, tolerance)                               \
    near_check(actual, expected, tolerance, #actual, __FILE__, __LINE__)

static inline void near_check(double actual, double expected, double tolerance,
                              const char *what, const char *file, int line)
{
    if (!(fabs(actual - expected) <= tolerance)) {
        print_error("%s is %.17g, not %.17g within %.3g\n", what, actual,
                    expected, tolerance);
        _fail(file, line);
    }
}
