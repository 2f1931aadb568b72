#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "seabed/seabed.h"
#include "seabed/wire.h"

#define SPACING 10.0
#define WEST (-100.0)
#define SOUTH 50.0

/* 5 × 4 nodes of a plane, which bilinear interpolation keeps. */
static double plane(double east_m, double north_m)
{
    return -7 + 0.03 * east_m - 0.02 * north_m;
}

static void heights_of_plane(float out[20])
{
    for (int i = 0; i < 20; i++) {
        out[i] =
            (float)plane(WEST + SPACING * (i % 5), SOUTH + SPACING * (i / 5));
    }
}

static const struct pel_seabed *make(const float heights[20])
{
    const struct pel_seabed *bed = NULL;
    struct pel_fault fault;
    if (pel_seabed_create(5, 4, WEST, SOUTH, SPACING, heights, &bed, &fault)) {
        fail_msg("%s", fault.message);
    }
    return bed;
}

static void heights_between_nodes(void **state)
{
    (void)state;
    float heights[20];
    double h;
    heights_of_plane(heights);
    const struct pel_seabed *bed = make(heights);
    for (double e = WEST; e <= WEST + 40; e += 1.7) {
        for (double n = SOUTH; n <= SOUTH + 30; n += 2.3) {
            assert_true(pel_seabed_height(bed, e, n, &h));
            /* Heights are floats. */
            assert_true(fabs(h - plane(e, n)) < 2e-6);
            assert_true(pel_seabed_drawn(bed, e, n, -99) == h);
        }
    }
    assert_true(fabs(bed->lowest_m - plane(WEST, SOUTH + 30)) < 2e-6);
    assert_true(fabs(bed->highest_m - plane(WEST + 40, SOUTH)) < 2e-6);
    pel_seabed_unref(bed);
}

static void ends_half_a_spacing_beyond_its_nodes(void **state)
{
    (void)state;
    float heights[20];
    double h;
    heights_of_plane(heights);
    const struct pel_seabed *bed = make(heights);
    assert_true(pel_seabed_height(bed, WEST - 4.9, SOUTH, &h));
    assert_true(fabs(h - plane(WEST, SOUTH)) < 2e-6);
    assert_false(pel_seabed_height(bed, WEST - 5.1, SOUTH, &h));
    assert_false(pel_seabed_height(bed, WEST, SOUTH + 35.1, &h));
    assert_true(pel_seabed_drawn(bed, WEST, SOUTH + 35.1, -99) == -99);
    assert_false(pel_seabed_height(bed, 1e300, SOUTH, &h));
    pel_seabed_unref(bed);
}

static void nodes_without_data_are_drawn_and_not_answered(void **state)
{
    (void)state;
    float heights[20];
    double h;
    heights_of_plane(heights);
    heights[7] = NAN;
    heights[19] = -32768; /* no height on Earth */
    const struct pel_seabed *bed = make(heights);
    assert_false(pel_seabed_height(bed, WEST + 20, SOUTH + 10, &h));
    assert_false(pel_seabed_height(bed, WEST + 24, SOUTH + 6, &h));
    assert_true(pel_seabed_height(bed, WEST + 26, SOUTH + 10, &h));
    /* The mean of its three neighbours in a square of two. */
    h = pel_seabed_drawn(bed, WEST + 20, SOUTH + 10, -99);
    assert_true(fabs(h - (plane(WEST + 20, SOUTH) + plane(WEST + 30, SOUTH) +
                          plane(WEST + 30, SOUTH + 10)) /
                             3) < 1e-5);
    assert_true(bed->lowest_m > -12);
    pel_seabed_unref(bed);
}

static void what_is_no_field_is_refused(void **state)
{
    (void)state;
    float heights[20];
    const struct pel_seabed *bed = NULL;
    struct pel_fault fault;
    heights_of_plane(heights);
    assert_int_equal(pel_seabed_create(1, 4, 0, 0, 10, heights, &bed, &fault),
                     PEL_ERR_OUT_OF_RANGE);
    assert_non_null(strstr(fault.message, "1 × 4"));
    assert_int_equal(pel_seabed_create(PEL_SEABED_MOST + 1, 2, 0, 0, 10,
                                       heights, &bed, NULL),
                     PEL_ERR_OUT_OF_RANGE);
    assert_int_equal(pel_seabed_create(5, 4, 0, 0, 0.05, heights, &bed, &fault),
                     PEL_ERR_OUT_OF_RANGE);
    assert_int_equal(pel_seabed_create(5, 4, 0, 0, NAN, heights, &bed, &fault),
                     PEL_ERR_OUT_OF_RANGE);
    assert_int_equal(pel_seabed_create(5, 4, NAN, 0, 10, heights, &bed, &fault),
                     PEL_ERR_OUT_OF_RANGE);
    for (int i = 0; i < 20; i++) {
        heights[i] = NAN;
    }
    assert_int_equal(pel_seabed_create(5, 4, 0, 0, 10, heights, &bed, &fault),
                     PEL_ERR_INVALID);
    assert_null(bed);
}

static void the_wire_carries_it(void **state)
{
    (void)state;
    unsigned char bytes[PEL_SEABED_WIRE_HEAD + 80];
    float heights[20];
    double h;
    const struct pel_seabed *bed = NULL;
    struct pel_fault fault;
    heights_of_plane(heights);
    pel_seabed_wire_head(5, 4, WEST, SOUTH, SPACING, bytes);
    memcpy(bytes + PEL_SEABED_WIRE_HEAD, heights, 80);
    assert_int_equal(pel_seabed_wire_read(bytes, sizeof bytes, &bed, &fault),
                     PEL_OK);
    assert_true(pel_seabed_height(bed, WEST + 13, SOUTH + 21, &h));
    assert_true(fabs(h - plane(WEST + 13, SOUTH + 21)) < 2e-6);
    pel_seabed_unref(bed);
    assert_int_equal(
        pel_seabed_wire_read(bytes, sizeof bytes - 1, &bed, &fault),
        PEL_ERR_MALFORMED);
    assert_int_equal(pel_seabed_wire_read(bytes, 12, &bed, &fault),
                     PEL_ERR_MALFORMED);
    bytes[8] = 6;
    assert_int_equal(pel_seabed_wire_read(bytes, sizeof bytes, &bed, &fault),
                     PEL_ERR_MALFORMED);
    bytes[0] = 'x';
    assert_int_equal(pel_seabed_wire_read(bytes, sizeof bytes, &bed, &fault),
                     PEL_ERR_MALFORMED);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(heights_between_nodes),
        cmocka_unit_test(ends_half_a_spacing_beyond_its_nodes),
        cmocka_unit_test(nodes_without_data_are_drawn_and_not_answered),
        cmocka_unit_test(what_is_no_field_is_refused),
        cmocka_unit_test(the_wire_carries_it),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
