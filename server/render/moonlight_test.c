/* Sun and Moon in one picture: what each gives, added. */
#include "optics/moon.h"
#include "render/render_testkit.h"
#include "render/sky.h"

enum { SIDE = 96 };
static struct pel_sea sea;

static void put_moon(struct pel_environment *env, double elevation,
                     double azimuth, double lit)
{
    env->lights[PEL_LIGHT_MOON] = pel_light_moon(
        pel_sky_quantize(test_sun(elevation, azimuth)),
        env->lights[PEL_LIGHT_SUN].direction, lit, PEL_MOON_DISTANCE);
}

static struct pel_camera looking(double height_m, double pitch)
{
    return test_camera(
        (struct test_look){ height_m, 40, pitch, 0, 60, SIDE, SIDE });
}

static void radiance_of(struct pel_environment *env, const char *shading,
                        const struct pel_camera *c, float *out)
{
    struct pel_renderer *r = test_renderer(shading);
    struct pel_picture *p = test_draw(r, env, c, PEL_LAYER_RADIANCE);
    memcpy(out, p->radiance, sizeof(float) * 4 * SIDE * SIDE);
    pel_picture_release(p);
    pel_renderer_destroy(r);
}

/* A picture by both is the sum of theirs, in either order and wrapper. */
static void lights_add_up(void **state)
{
    (void)state;
    static float sun[4 * SIDE * SIDE], moon[4 * SIDE * SIDE],
        both[4 * SIDE * SIDE];
    static const struct {
        const char *shading;
        double sun, moon;
        bool bed;
    } rows[] = { { "fragment", -4, 25, false },
                 { "fragment", -0.2, 80, true },
                 { "fragment", -9, 12, false },
                 { "compute", -7, 25, false } };
    test_sea(6.0, 0.0, 3, &sea);
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        struct pel_environment env = test_environment(&sea, 12.0);
        const struct pel_seabed *bed =
            rows[i].bed ? test_bed(test_island) : NULL;
        if (bed) {
            env = test_over(env, bed, 400);
        }
        env.lights[PEL_LIGHT_SUN].direction = test_sun(rows[i].sun, 300);
        struct pel_camera c = looking(12, -8);
        radiance_of(&env, rows[i].shading, &c, sun);
        put_moon(&env, rows[i].moon, 45, 1.0);
        radiance_of(&env, rows[i].shading, &c, both);
        env.lights[PEL_LIGHT_SUN].strength = 0.0;
        radiance_of(&env, rows[i].shading, &c, moon);
        double worst = 0, share = 0, total = 0;
        for (size_t k = 0; k < 4 * SIDE * SIDE; k++) {
            double sum = (double)sun[k] + (double)moon[k];
            if (k % 4 < 3) {
                worst = fmax(worst, fabs(both[k] - sum) / sum);
                share += moon[k];
                total += sum;
            }
        }
        print_message("%s, Sun %g: worst %.2g, the Moon gives %.3f\n",
                      rows[i].shading, rows[i].sun, worst, share / total);
        /* Sums of floats in another order. The Sun mirrored twice is drawn of
         * the first light alone: some 1e-3 of the sky of a set Sun has none,
         * of a Moon behind a rising one it is missing. */
        assert_true(worst < (rows[i].sun > -0.3 ? 0.02 : 2e-4));
        pel_seabed_unref(bed);
    }
    pel_sea_finish(&sea);
}

/* The sum over the disc is the irradiance, by any phase. */
static void disc_holds_its_light(void **state)
{
    (void)state;
    static float seen[4 * SIDE * SIDE];
    static const double lit[] = { 1.0, 0.7, 0.25 };
    test_sea(3.0, 0.0, 3, &sea);
    for (size_t i = 0; i < 3; i++) {
        struct pel_environment env = test_environment(&sea, 12.0);
        env.lights[PEL_LIGHT_SUN].direction = test_sun(-40, 300);
        put_moon(&env, 50, 40, lit[i]);
        struct pel_camera c =
            test_camera((struct test_look){ 12, 40, 50, 0, 1.0, SIDE, SIDE });
        radiance_of(&env, "fragment", &c, seen);
        /* Around the disc the sky alone. */
        double sky = 0, sum = 0;
        for (size_t k = 0; k < SIDE; k++) {
            sky += (double)seen[4 * k + 1] / SIDE;
        }
        for (size_t k = 0; k < SIDE * SIDE; k++) {
            sum += (double)seen[4 * k + 1] - sky;
        }
        double pixel = (c.tan_right - c.tan_left) / SIDE;
        struct pel_atmosphere *air = malloc(sizeof *air);
        const struct pel_atmosphere_desc desc = { env.visibility_m };
        pel_atmosphere_init(&desc, air);
        double through =
            pel_atmosphere_transmittance(air, 12, sin(50 * PEL_DEG)).g;
        double want =
            pel_light_bodies[PEL_LIGHT_MOON].irradiance.g * through *
            pel_moon_strength(pel_moon_alpha(lit[i]), PEL_MOON_DISTANCE);
        print_message("lit %.2f: %.4f of its light\n", lit[i],
                      sum * pixel * pixel / want);
        /* 46 pixels across: the soft edge of the terminator (2 % of a
         * crescent), and the aureole that is brighter before the disc than at
         * the picture's edge. */
        assert_true(fabs(sum * pixel * pixel / want - 1.0) < 0.03);
        pel_atmosphere_finish(air);
        free(air);
    }
    pel_sea_finish(&sea);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(lights_add_up),
        cmocka_unit_test(disc_holds_its_light),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
