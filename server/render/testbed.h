/* Height fields of the render room's tests, and environments over them. */
#pragma once

#include "render/rendertest.h"
#include "seabed/seabed.h"

#define TEST_BED_SIDE 64
#define TEST_BED_SPACING 50.0

/* An island of 30 m in a sea of 400 m, 600 m north of the origin, and a bank at
 * 12 m in the east. */
static inline double test_island(double east_m, double north_m)
{
    double r = hypot(east_m - 160, north_m - 600) / 400;
    return east_m > 1000 ? -12 : -400 + 430 / (1 + r * r * r);
}

/* All but level: a field of one height only is none. */
static inline double test_bank(double east_m, double north_m)
{
    return -8 + 1e-9 * (east_m + north_m);
}

/* A field of 64 by 64 nodes, 50 m apart, that begins 800 m south. */
static inline const struct pel_seabed *
test_bed(double (*height)(double east_m, double north_m))
{
    static float heights[TEST_BED_SIDE * TEST_BED_SIDE];
    const double west = -0.5 * TEST_BED_SIDE * TEST_BED_SPACING, south = -800;
    for (int i = 0; i < TEST_BED_SIDE * TEST_BED_SIDE; i++) {
        heights[i] =
            (float)height(west + TEST_BED_SPACING * (i % TEST_BED_SIDE),
                          south + TEST_BED_SPACING * (i / TEST_BED_SIDE));
    }
    const struct pel_seabed *bed = NULL;
    assert_int_equal(pel_seabed_create(TEST_BED_SIDE, TEST_BED_SIDE, west,
                                       south, TEST_BED_SPACING, heights, &bed,
                                       NULL),
                     PEL_OK);
    return bed;
}

/* The environment in tropical water over sand, so deep beyond the field. */
static inline struct pel_environment test_over(struct pel_environment env,
                                               const struct pel_seabed *bed,
                                               double depth_m)
{
    const struct pel_water_desc water = { .kind = PEL_WATER_NAMED,
                                          .name = PEL_WATER_TROPICAL,
                                          .depth_m = depth_m,
                                          .bottom = PEL_BOTTOM_SAND };
    assert_int_equal(pel_water_resolve(&water, &env.water, NULL), PEL_OK);
    env.seabed = bed;
    return env;
}
