/* The shading functions on the device against their reference in C. */
#include "render/probe.h"

#include "render/render_testkit.h"

#include "base/near.h"
#include "render/sky.h"

static struct pel_sea sea;

static double off(double got, double want)
{
    return fabs(got - want) / fmax(fabs(want), 1e-9);
}

static struct pel_vec3 in_wind(struct pel_vec3 v, double to_rad)
{
    double c = cos(to_rad), s = sin(to_rad);
    return (struct pel_vec3){ c * v.x + s * v.y, c * v.y - s * v.x, v.z };
}

static struct pel_probe_answer ask(const struct pel_environment *env,
                                   const struct pel_probe *probe)
{
    struct pel_probe_answer answer;
    struct pel_fault fault;
    if (pel_renderer_probe(renderer, env, probe, &answer, &fault)) {
        fail_msg("%s", fault.message);
    }
    return answer;
}

static void sea_terms(void **state)
{
    (void)state;
    static const double slopes[][2] = { { 0.004, 0.003 },
                                        { 0.03, 0.02 },
                                        { 0.05, 0.06 } };
    double worst[4] = { 0 };
    int glints = 0, grazing = 0;
    for (int i = 0; i < 3 * 9 * 4; i++) {
        struct pel_environment env = test_environment(&sea, 0.0);
        env.lights[PEL_LIGHT_SUN].direction =
            test_sun(20.0 + 15.0 * (i % 4), 60.0 * (i % 7));
        struct pel_vec3 sun =
            pel_sky_quantize(env.lights[PEL_LIGHT_SUN].direction);
        const double *v = slopes[i % 3];
        int ring = i / 12; /* up to 2° above the level, all round */
        const struct pel_probe probe = {
            /* All round, and every other one towards the glitter. */
            .dir = test_sun(90.0 - 11.0 * ring,
                            i % 2 ? 60.0 * (i % 7) + 180.0 : 40.0 * i),
            .slope_along = v[0],
            .slope_cross = v[1],
            .height_m = 2.0,
        };
        struct pel_brdf_terms got = ask(&env, &probe).sea, want;
        pel_brdf_terms(in_wind(probe.dir, env.wind_to_rad),
                       in_wind(sun, env.wind_to_rad), v[0], v[1],
                       env.water.index[1], &want);
        worst[0] = fmax(worst[0], fabs(got.lambda_view - want.lambda_view) /
                                      (1.0 + want.lambda_view));
        worst[1] = fmax(worst[1], off(got.mean_fresnel, want.mean_fresnel));
        worst[2] = fmax(worst[2], off(got.seen_fresnel, want.seen_fresnel));
        /* Of itself, where a glint is to be seen: above 1e-4 of the brightest
         * there is, p(0) R / 4. */
        double bright = 0.0211 / (8.0 * PEL_PI * sqrt(v[0] * v[1]));
        double error = fabs(got.reflected_sun - want.reflected_sun);
        glints += want.reflected_sun > 1e-4 * bright;
        grazing += want.reflected_sun > 1e-4 * bright && probe.dir.z < 0.25;
        worst[3] =
            fmax(worst[3], error / fmax(want.reflected_sun, 1e-4 * bright));
        assert_near(got.half_cosine, want.half_cosine, 1e-4);
        assert_near(got.fresnel, want.fresnel, 1e-5);
        assert_near(got.slope_density, want.slope_density,
                    2e-4 * want.slope_density + 1e-12);
        assert_near(got.brdf * sun.z, got.reflected_sun,
                    1e-4 * got.reflected_sun);
    }
    print_message("%d glints, %d of them below 15 degrees; ", glints, grazing);
    print_message("lambda %.1e, F by eq. 24 %.1e, over facets %.1e, reflected "
                  "Sun %.1e\n",
                  worst[0], worst[1], worst[2], worst[3]);
    assert_true(worst[0] < 1e-4); /* erfc to 1.5e-7, single precision */
    assert_true(worst[1] < 1e-3);
    assert_true(worst[2] < 5e-3); /* a table of 64 steps */
    /* Single precision: slopes to 1e-6 of some standard deviations. */
    assert_true(worst[3] < 1e-4);
    assert_true(glints > 60 && grazing > 10);
}

static void sky_terms(void **state)
{
    (void)state;
    double radiance = 0.0, through = 0.0;
    for (int i = 0; i < 24; i++) {
        struct pel_environment env = test_environment(&sea, 0.0);
        env.lights[PEL_LIGHT_SUN].direction =
            test_sun(5.0 + 15.0 * (i % 5), 70.0);
        env.visibility_m = i % 2 ? 40e3 : 200e3;
        struct pel_vec3 sun =
            pel_sky_quantize(env.lights[PEL_LIGHT_SUN].direction);
        const struct pel_probe probe = {
            .dir = test_sun(4.0 + 3.5 * i, 110.0 + 31.0 * i),
            .slope_along = 0.02,
            .slope_cross = 0.02,
            .height_m = i % 3 ? 2.0 : 1024.0,
        };
        struct pel_sky_terms got = ask(&env, &probe).sky, want;
        assert_int_equal(pel_sky_terms(env.visibility_m, probe.height_m,
                                       probe.dir, sun, &want),
                         PEL_OK);
        radiance = fmax(radiance, off(got.radiance.r, want.radiance.r));
        radiance = fmax(radiance, off(got.radiance.b, want.radiance.b));
        through = fmax(through, off(got.transmittance.g, want.transmittance.g));
        through = fmax(through,
                       off(got.sun_transmittance.b, want.sun_transmittance.b));
    }
    print_message("sky %.1e, transmittance %.1e\n", radiance, through);
    assert_true(radiance < 0.04); /* light_test: sky_is_the_reference */
    assert_true(through < 0.02);  /* a table of 256 × 64 */
}

static int set_up(void **state)
{
    test_sea(7.0, 0.0, 1, &sea);
    return begin_renderer(state);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sea_terms),
        cmocka_unit_test(sky_terms),
    };
    return cmocka_run_group_tests(tests, set_up, end_renderer);
}
