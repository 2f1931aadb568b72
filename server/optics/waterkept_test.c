/* Kernels that are kept are those that are built, to the bit. */
#include "optics/waterkept.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "optics/waterbody.h"

enum { WATERS = 6, LEVELS = 2 };

static void kept_is_built(void **state)
{
    (void)state;
    static struct pel_water_kernel built[WATERS][LEVELS], taken[LEVELS];
    struct pel_water_body bodies[WATERS];
    const struct pel_water_depths depths = { LEVELS, 5.0, 20.0 };
    for (int i = 0; i < WATERS; i++) {
        /* Differences of every kind: constituents, bottom, orders. */
        struct pel_water_desc desc = { .chlorophyll_mg_m3 = i < 4 ? 1 + i : 1,
                                       .salinity_g_kg = 35,
                                       .temperature_c = 15,
                                       .depth_m = 20,
                                       .bottom = i == 4 ? PEL_BOTTOM_MUD
                                                        : PEL_BOTTOM_SAND };
        assert_int_equal(pel_water_resolve(&desc, &bodies[i], NULL), PEL_OK);
        assert_int_equal(
            pel_water_kernel_build(&bodies[i], &depths,
                                   i == 5 ? PEL_ORDERS_SINGLE : PEL_ORDERS_ALL,
                                   built[i]),
            PEL_OK);
    }
    /* Again at once, after others, after more than are kept. */
    static const int asked[] = { 0, 0, 1, 0, 2, 3, 1, 4, 5, 0, 5, 4, 3, 2, 1 };
    for (size_t k = 0; k < sizeof asked / sizeof *asked; k++) {
        int i = asked[k];
        assert_int_equal(
            pel_water_kernel_take(&bodies[i], &depths,
                                  i == 5 ? PEL_ORDERS_SINGLE : PEL_ORDERS_ALL,
                                  taken),
            PEL_OK);
        assert_memory_equal(taken, built[i], sizeof taken);
    }
}

static void depths_are_others(void **state)
{
    (void)state;
    static struct pel_water_kernel built, taken[LEVELS];
    struct pel_water_body body;
    const struct pel_water_depths two = { LEVELS, 5.0, 20.0 },
                                  one = { 1, 20.0, 20.0 };
    struct pel_water_desc desc = { .chlorophyll_mg_m3 = 1,
                                   .salinity_g_kg = 35,
                                   .temperature_c = 15,
                                   .depth_m = 20 };
    assert_int_equal(pel_water_resolve(&desc, &body, NULL), PEL_OK);
    assert_int_equal(
        pel_water_kernel_build(&body, &one, PEL_ORDERS_ALL, &built), PEL_OK);
    for (int i = 0; i < 2; i++) {
        assert_int_equal(
            pel_water_kernel_take(&body, &two, PEL_ORDERS_ALL, taken), PEL_OK);
        assert_int_equal(
            pel_water_kernel_take(&body, &one, PEL_ORDERS_ALL, taken), PEL_OK);
        assert_memory_equal(taken, &built, sizeof built);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(kept_is_built),
        cmocka_unit_test(depths_are_others),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
