/* Level water's light made that of a slope: against the reference where the
 * bottom is level, against the Monte Carlo where it is not. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "base/vec.h"
#include "optics/watermontecarlo.h"
#include "optics/waterslope.h"

#define LEVELS 12

static struct pel_water_kernel levels[LEVELS];

static struct pel_water_depths make(const struct pel_water_body *body)
{
    const struct pel_water_depths depths = { LEVELS, 0.25,
                                             pel_water_visible_m(body) };
    assert_int_equal(
        pel_water_kernel_build(body, &depths, PEL_ORDERS_ALL, levels), PEL_OK);
    return depths;
}

static struct pel_water_body tropical(void)
{
    const struct pel_water_desc desc = { .kind = PEL_WATER_NAMED,
                                         .name = PEL_WATER_TROPICAL,
                                         .depth_m = 10,
                                         .bottom = PEL_BOTTOM_SAND };
    struct pel_water_body body;
    assert_int_equal(pel_water_resolve(&desc, &body, NULL), PEL_OK);
    return body;
}

/* Between the levels too: 1/255 of the brightest depth. */
static void a_level_place_is_level_water(void **state)
{
    (void)state;
    struct pel_water_body body = tropical();
    struct pel_water_depths depths = make(&body);
    const struct pel_geometry at = { 0.6, 0.7, 2.0 };
    double most = 0.0, worst = 0.0;
    for (double z = 0.3; z < 0.95 * depths.last_m; z *= 1.17) {
        const struct pel_slope_place place = { z, z, 0.0, 1.0, 1.0 };
        struct pel_slope_light light[PEL_WATER_WAVELENGTHS];
        pel_slope_light(&body, &depths, levels, &at, &place, light);
        for (int c = 0; c < PEL_WATER_WAVELENGTHS; c++) {
            struct pel_medium m = pel_water_medium(&body, c);
            struct pel_leaving want;
            m.depth_m = z;
            assert_int_equal(
                pel_transport_leaving(&m, &at, PEL_ORDERS_ALL, &want), PEL_OK);
            double bottom = want.bottom_direct + want.bottom_scattered;
            most = fmax(most, want.total);
            worst = fmax(worst, fabs(light[c].bottom - bottom));
            worst = fmax(worst, fabs(light[c].volume - want.total + bottom));
        }
    }
    print_message("1/%.0f of the brightest\n", most / worst);
    assert_true(worst <= most / 255.0);
}

/* Planes of 20° that fall to the Sun and from it, seen from both sides: within
 * 6 % and three standard errors, where level water is tens of percent off. */
static void slopes_are_the_monte_carlos(void **state)
{
    (void)state;
    struct pel_water_body body = tropical();
    struct pel_water_depths depths = make(&body);
    const struct pel_montecarlo_sun suns[2] = { { 1.0, 0.0 }, { 1.0, PEL_PI } };
    const double view = 0.6, depth = 5.0, slope = tan(20 * PEL_DEG);
    double level_off = 0.0;
    for (int k = 0; k < 2; k++) {
        struct pel_section bed;
        struct pel_geometry at = { 1.0, view, 0.0 };
        struct pel_interface f = pel_interface_at(&at);
        assert_int_equal(
            pel_section_plane(slope, k * PEL_PI, f.view_mu, depth, 500, &bed),
            PEL_OK);
        for (int c = 1; c < PEL_WATER_WAVELENGTHS; c++) {
            struct pel_medium m = pel_water_medium(&body, c);
            struct pel_montecarlo_result r[2];
            pel_montecarlo_leaving(&m, &bed, view, suns, 2, 30000, 3, r, NULL);
            for (int i = 0; i < 2; i++) {
                at.azimuth_rad = suns[i].azimuth_rad;
                double sunward = cos(bed.azimuth_rad + at.azimuth_rad) *
                                 sqrt(1.0 - f.sun_mu * f.sun_mu) / f.sun_mu;
                struct pel_slope_place place = {
                    .depth_m = depth,
                    .under_m = pel_section_depth(&bed, 0.0),
                    .slope = slope,
                    .gain = (1.0 + slope * sunward) / hypot(1.0, slope),
                    .lit = 1.0,
                };
                const struct pel_slope_place level = { depth, depth, 0, 1, 1 };
                struct pel_slope_light got[PEL_WATER_WAVELENGTHS];
                struct pel_slope_light flat[PEL_WATER_WAVELENGTHS];
                pel_slope_light(&body, &depths, levels, &at, &place, got);
                pel_slope_light(&body, &depths, levels, &at, &level, flat);
                double want = r[i].total.mean;
                double off = (got[c].volume + got[c].bottom) / want - 1.0;
                if (!(fabs(off) < 0.06 + 3.0 * r[i].total.error / want)) {
                    fail_msg("%d, %d, %d: %.3f off", k, i, c, off);
                }
                level_off =
                    fmax(level_off,
                         fabs((flat[c].volume + flat[c].bottom) / want - 1.0));
            }
        }
    }
    assert_true(level_off > 0.2);
}

static double random_in(uint64_t *state, double low, double high)
{
    *state = *state * 6364136223846793005u + 1442695040888963407u;
    return low + (high - low) * (double)(*state >> 11) * 0x1p-53;
}

/* Any legal water, any place: nothing negative, nothing more than a white
 * bottom turned to the Sun would send back. */
static void light_is_kept(void **state)
{
    (void)state;
    uint64_t random = 3;
    for (int k = 0; k < 6; k++) {
        struct pel_water_body body = { .depth_m = 10 };
        for (int c = 0; c < PEL_WATER_WAVELENGTHS; c++) {
            body.absorption[c] = exp(random_in(&random, log(0.001), log(5)));
            body.scattering[c] = exp(random_in(&random, log(1e-3), log(10)));
            body.asymmetry[c] = random_in(&random, 0, PEL_ASYMMETRY_MAX);
            body.albedo[c] = random_in(&random, 0, 1);
        }
        struct pel_water_depths depths = make(&body);
        for (int i = 0; i < 300; i++) {
            struct pel_geometry at = { random_in(&random, 0, 1.5),
                                       random_in(&random, 0, 1.5),
                                       random_in(&random, 0, PEL_PI) };
            struct pel_interface f = pel_interface_at(&at);
            struct pel_slope_place place = {
                .depth_m = exp(random_in(&random, log(0.01), log(1e4))),
                .under_m = exp(random_in(&random, log(0.01), log(1e4))),
                .slope = i % 5 ? random_in(&random, 0, 3) : 1e6,
                .gain = random_in(&random, 0, 1.0 / f.sun_mu),
                .lit = i % 3 ? 1.0 : 0.0,
            };
            struct pel_slope_light got[PEL_WATER_WAVELENGTHS];
            pel_slope_light(&body, &depths, levels, &at, &place, got);
            for (int c = 0; c < PEL_WATER_WAVELENGTHS; c++) {
                assert_true(got[c].volume >= 0.0 && got[c].bottom >= 0.0);
                double turned = fmax(place.gain, 1.0);
                assert_true(got[c].volume + got[c].bottom <=
                            1.06 * turned * f.beam * f.sun_mu / PEL_PI + 1e-9);
            }
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_level_place_is_level_water),
        cmocka_unit_test(slopes_are_the_monte_carlos),
        cmocka_unit_test(light_is_kept),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
