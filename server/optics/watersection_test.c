/* Bottoms that are not level, and the Monte Carlo over them. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "base/vec.h"
#include "optics/brdf.h"
#include "optics/watermontecarlo.h"
#include "optics/watersection.h"

static void near(double value, double wanted, double tolerance)
{
    if (!(fabs(value - wanted) <= tolerance)) {
        fail_msg("%.9g, not %.9g", value, wanted);
    }
}

static const struct pel_section cliff = {
    .azimuth_rad = 0.7,
    .knots = 6,
    .along_m = { -9, -4, 2, 2, 5, 9 },
    .depth_m = { 0, 3, 4, 11, 7, 14 },
};

/* Where a line meets the bottom: on it, and nowhere before in small steps. */
static void lines_end_on_the_bottom(void **state)
{
    (void)state;
    for (int i = 0; i < 400; i++) {
        double along = -12 + 0.06 * i, angle = 0.1 + 1.618 * i;
        double depth = 0.6 * pel_section_depth(&cliff, along);
        double a = cos(angle), up = sin(angle);
        struct pel_section_hit hit = { 30, 0, 0 };
        bool met = pel_section_meet(&cliff, along, depth, a, up, &hit);
        assert_true(met || up > 0.0);
        for (double t = 0; t < hit.length - 0.01; t += 0.01) {
            double d = pel_section_depth(&cliff, along + t * a);
            assert_true(depth - t * up <= d + 1e-9);
        }
        if (!met) {
            continue;
        }
        assert_true(hit.along * a + hit.up * up < 0.0);
        near(hypot(hit.along, hit.up), 1.0, 1e-12);
        double at = along + hit.length * a;
        if (fabs(at - 2) > 1e-6) { /* but for the cliff's face */
            near(depth - hit.length * up, pel_section_depth(&cliff, at), 1e-6);
        }
    }
}

/* Nothing is lost between lossless water and a white bottom of any shape: what
 * leaves a sea under an even sky is what a mirror would not have sent. */
static void an_even_sky_sees_itself(void **state)
{
    (void)state;
    const struct pel_medium m = { .absorption = 0.0,
                                  .scattering = 0.3,
                                  .asymmetry = 0.8,
                                  .depth_m = 4.0,
                                  .albedo = 1.0 };
    const struct pel_montecarlo_sun sun = { 0.5, 0.0 };
    for (int i = 0; i < 3; i++) {
        double view = 0.6 * i;
        struct pel_montecarlo_result r;
        struct pel_estimate sky;
        struct pel_section bed = cliff;
        bed.azimuth_rad = 1.3 * i;
        pel_montecarlo_leaving(&m, &bed, view, &sun, 1, 20000, 11, &r, &sky);
        double through = 1.0 - pel_fresnel_exact(cos(view), PEL_WATER_INDEX);
        near(sky.mean * PEL_PI, through, 4.0 * sky.error * PEL_PI);
        assert_true(sky.error < 0.02 * sky.mean);
    }
}

/* I section 5.4: eq. 5 with the depth of Q, eq. 9 with it and cos γ. */
static void slopes_follow_eq_5_and_9(void **state)
{
    (void)state;
    struct pel_medium m = { .absorption = 0.1,
                            .scattering = 0.3,
                            .asymmetry = 0.85,
                            .depth_m = 4.0,
                            .albedo = 0.3 };
    const struct pel_montecarlo_sun suns[] = { { 0.3, 0.0 }, { 1.0, 2.0 } };
    const double view = 0.8;
    for (int k = 0; k < 8; k++) {
        double slope = tan((k < 4 ? 15 : 40) * PEL_DEG);
        struct pel_section bed;
        struct pel_geometry at = { 0.0, view, 0.0 };
        assert_int_equal(pel_section_plane(slope, 0.5 * PEL_PI * k,
                                           pel_interface_at(&at).view_mu,
                                           m.depth_m, 100.0, &bed),
                         PEL_OK);
        struct pel_montecarlo_result r[2];
        pel_montecarlo_leaving(&m, &bed, view, suns, 2, 40000, 5, r, NULL);
        for (int i = 0; i < 2; i++) {
            at.sun_zenith_rad = suns[i].zenith_rad;
            at.azimuth_rad = suns[i].azimuth_rad;
            struct pel_interface f = pel_interface_at(&at);
            /* The normal leans to where the bottom falls; the Sun is at
             * −azimuth from the line of sight. */
            double lean = cos(bed.azimuth_rad + at.azimuth_rad);
            double gamma =
                (f.sun_mu + slope * lean * sqrt(1.0 - f.sun_mu * f.sun_mu)) /
                sqrt(1.0 + slope * slope);
            near(r[i].single.mean,
                 pel_transport_single(&m, &at, PEL_EXTINCTION_FULL),
                 4.0 * r[i].single.error);
            near(r[i].bottom_direct.mean,
                 pel_transport_bottom(&m, &at) * fmax(gamma, 0.0) / f.sun_mu,
                 4.0 * r[i].bottom_direct.error);
        }
    }
}

/* A ridge between the Sun and what is looked at takes its beam away. */
static void ridges_shade(void **state)
{
    (void)state;
    const struct pel_medium m = { .absorption = 0.1,
                                  .scattering = 0.1,
                                  .asymmetry = 0.8,
                                  .depth_m = 4.0,
                                  .albedo = 0.3 };
    const struct pel_section ridge = { .knots = 3,
                                       .along_m = { 0.5, 1.5, 2.5 },
                                       .depth_m = { 6, 0.5, 6 } };
    const struct pel_montecarlo_sun suns[] = { { 1.2, 0.0 }, { 1.2, PEL_PI } };
    struct pel_montecarlo_result r[2];
    pel_montecarlo_leaving(&m, &ridge, 0.0, suns, 2, 20000, 5, r, NULL);
    assert_true(r[0].bottom_direct.mean == 0.0);
    assert_true(r[1].bottom_direct.mean > 0.0);
    assert_true(r[0].single.mean < 0.9 * r[1].single.mean);
}

/* A plane of no slope is the level bottom to the bit; one that would be land
 * at the eye's place is refused. */
static void planes(void **state)
{
    (void)state;
    const struct pel_medium m = { .absorption = 0.1,
                                  .scattering = 0.3,
                                  .asymmetry = 0.8,
                                  .depth_m = 4.0,
                                  .albedo = 0.3 };
    const struct pel_montecarlo_sun sun = { 0.5, 1.0 };
    struct pel_montecarlo_result a, b;
    struct pel_section bed;
    assert_int_equal(pel_section_plane(0.0, 0.0, 0.8, 4.0, 50.0, &bed), PEL_OK);
    pel_montecarlo_leaving(&m, NULL, 0.7, &sun, 1, 1000, 3, &a, NULL);
    pel_montecarlo_leaving(&m, &bed, 0.7, &sun, 1, 1000, 3, &b, NULL);
    assert_memory_equal(&a, &b, sizeof a);
    assert_int_equal(pel_section_plane(2.0, 0.0, 0.7, 4.0, 50.0, &bed),
                     PEL_ERR_INVALID);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(lines_end_on_the_bottom),
        cmocka_unit_test(an_even_sky_sees_itself),
        cmocka_unit_test(slopes_follow_eq_5_and_9),
        cmocka_unit_test(ridges_shade),
        cmocka_unit_test(planes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
