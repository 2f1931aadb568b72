/* Lamps in pictures: how much light of one arrives, by Allard's law, wherever
 * in a pixel it stands; what hides it; that its path on the sea is that of a
 * light of the sky as bright in the same direction; seams and wrappers. */
#include "optics/lamp.h"
#include "optics/light.h"
#include "render/lampglow.h"
#include "render/render_testkit.h"
#include "scene/globe.h"

enum { SIDE = 128 };
#define NAUTICAL_MILE_M 1852.0
static struct pel_sea sea;

static struct pel_lamp white(double east_m, double north_m, double altitude_m)
{
    return (struct pel_lamp){
        .entity = PEL_NO_ENTITY,
        .east_m = east_m,
        .north_m = north_m,
        .altitude_m = altitude_m,
        .intensity_cd = { 94, 94, 94 },
        .ahead = { 0, -1, 0 },
        .up = { 0, 0, 1 },
        .arc_rad = 2 * PEL_PI,
        .spread_rad = 0.5 * PEL_PI,
    };
}

static struct pel_environment dark(double visibility_m)
{
    struct pel_environment env = test_environment(&sea, 20.0);
    env.lights[PEL_LIGHT_SUN].direction = test_sun(-30, 200);
    env.visibility_m = visibility_m;
    return env;
}

/* lx at the eye: what the picture has more with the lamps than without, over
 * the angles of its pixels. */
static double illuminance(struct pel_environment *env,
                          const struct pel_camera *c)
{
    size_t count = env->lamp_count;
    double m[9], sum = 0;
    pel_lights_colours(env->lights, 1, false, m);
    env->lamp_count = 0;
    struct pel_picture *without =
        test_draw(renderer, env, c, PEL_LAYER_RADIANCE);
    env->lamp_count = count;
    struct pel_picture *with = test_draw(renderer, env, c, PEL_LAYER_RADIANCE);
    double px = (c->tan_right - c->tan_left) / c->width,
           py = (c->tan_top - c->tan_bottom) / c->height;
    for (uint32_t i = 0; i < c->width * c->height; i++) {
        double x = c->tan_left + px * (i % c->width + 0.5),
               y = c->tan_top - py * (i / c->width + 0.5);
        double angle = px * py / pow(1 + x * x + y * y, 1.5);
        for (int k = 0; k < 9; k++) {
            static const double weight[3] = { 0.2126, 0.7152, 0.0722 };
            sum += weight[k / 3] * m[k] * angle *
                   ((double)with->radiance[4 * i + k % 3] -
                    (double)without->radiance[4 * i + k % 3]);
        }
    }
    pel_picture_release(with);
    pel_picture_release(without);
    return sum;
}

/* I K^d / d², wherever in a pixel it stands; the transmittance K is that of the
 * visibility (Koschmieder, 2 %), for grey air. Bar 2 %. */
static void energy_by_allard(void **state)
{
    (void)state;
    static const double miles[] = { 0.05, 0.3, 1, 3, 6, 12 };
    test_sea(3.0, 0.0, 3, &sea);
    for (size_t i = 0; i < sizeof miles / sizeof *miles; i++) {
        double away_m = miles[i] * NAUTICAL_MILE_M, worst = 0;
        for (int k = 0; k < 6; k++) {
            struct pel_environment env = dark(150000);
            struct pel_camera c = test_camera(
                (struct test_look){ 30, 0, 5, 0, k % 2 ? 3 : 9, SIDE, SIDE });
            c.glare = 0;
            double pixel_m = away_m * (c.tan_right - c.tan_left) / SIDE;
            /* The sea is not in sight. */
            const struct pel_lamp lamp =
                white(pixel_m * (0.13 + 0.21 * k), away_m,
                      30 + away_m * tan(5 * PEL_DEG));
            env.lamps = &lamp;
            env.lamp_count = 1;
            double seen = illuminance(&env, &c);
            double d2 = away_m * away_m + pow(lamp.altitude_m - 30, 2);
            double rule = 94 / d2 * exp(-3.912 / 150000 * sqrt(d2));
            worst = fmax(worst, fabs(seen / rule - 1));
        }
        print_message("%.2f nm: %.4f off\n", miles[i], worst);
        assert_true(worst < 0.02);
    }
    pel_sea_finish(&sea);
}

/* The horizon, and a ship's side. */
static void hidden(void **state)
{
    (void)state;
    test_sea(3.0, 0.0, 3, &sea);
    struct pel_environment env = dark(300000);
    struct pel_camera c =
        test_camera((struct test_look){ 3, 0, 0, 0, 20, SIDE, SIDE });
    c.glare = 0;
    struct pel_lamp lamp = white(5, 9 * NAUTICAL_MILE_M, 4);
    env.lamps = &lamp;
    env.lamp_count = 1;
    assert_true(illuminance(&env, &c) < 1e-12);
    lamp.altitude_m = 60; /* is above it */
    assert_true(illuminance(&env, &c) > 1e-9);
    pel_sea_finish(&sea);
}

/* A lamp far away at the Sun's place, as bright: the same path on the sea but
 * for what the Sun's has besides, light that a second wave hides or mirrors: 3
 * % of it high up, 9 % at 12 degrees. */
static void path_of_a_light(void **state)
{
    (void)state;
    static const double elevations[] = { 12, 25, 50 };
    enum { FAR_M = 40000 };
    struct pel_atmosphere *air = malloc(sizeof *air);
    assert_non_null(air);
    test_sea(7.0, 0.0, 3, &sea);
    for (size_t i = 0; i < 3; i++) {
        struct pel_environment env = dark(300000);
        struct pel_camera c =
            test_camera((struct test_look){ 12, 30, -18, 0, 34, SIDE, SIDE });
        struct pel_vec3 to = test_sun(elevations[i], 30);
        pel_atmosphere_init(
            &(struct pel_atmosphere_desc){ .visibility_m = 300000 }, air);
        double beam = pel_light_bodies[PEL_LIGHT_SUN].irradiance.g *
                      pel_atmosphere_transmittance(air, 0.0, to.z).g;
        env.lights[PEL_LIGHT_SUN].direction = to;
        struct pel_picture *p =
            test_draw(renderer, &env, &c, PEL_LAYER_RADIANCE | PEL_LAYER_SUN);
        double sun = 0, lamp_ = 0;
        for (size_t k = 0; k < (size_t)SIDE * SIDE; k++) {
            sun += (double)p->sun[4 * k + 1];
        }
        pel_picture_release(p);
        env = dark(300000);
        double m[9], inverse[9], light[3];
        pel_lights_colours(env.lights, 1, false, m);
        pel_lamp_inverse(m, inverse);
        struct pel_vec3 at = pel_globe_at((struct pel_vec3){ 0, 0, 12 },
                                          pel_vec3_scale(to, FAR_M));
        struct pel_lamp lamp = white(at.x, at.y, at.z);
        for (int k = 0; k < 3; k++) {
            lamp.intensity_cd[k] *= 1e6;
        }
        pel_lamp_spectral(m, inverse, lamp.intensity_cd, light);
        env.lamps = &lamp;
        env.lamp_count = 1;
        p = test_draw(renderer, &env, &c, PEL_LAYER_RADIANCE | PEL_LAYER_SUN);
        for (size_t k = 0; k < (size_t)SIDE * SIDE; k++) {
            lamp_ += (double)p->sun[4 * k + 1];
        }
        pel_picture_release(p);
        double lamp_falls =
            light[1] / FAR_M / FAR_M * exp(-3.912 / 300000 * FAR_M);
        double ratio = (lamp_ / lamp_falls) / (sun / beam);
        print_message("%g deg: the lamp's path by the Sun's %.4f\n",
                      elevations[i], ratio);
        assert_true(ratio > 0.88 && ratio < 1.02);
    }
    pel_sea_finish(&sea);
    free(air);
}

/* A harbour of them. */
static void harbour(struct pel_environment *env, struct pel_lamp lamps[40])
{
    for (int i = 0; i < 40; i++) {
        double turn = 0.5 * remainder(i * 0.618034, 1), away = 120 + 70 * i;
        lamps[i] =
            white(away * sin(turn), away * cos(turn), 2 + 20 * (i % 7) / 6.0);
        lamps[i].intensity_cd[i % 3] *= 0.2;
        lamps[i].arc_rad = i % 4 ? 2 * PEL_PI : 2;
        lamps[i].from_rad = -1;
        lamps[i].cutoff_rad = 0.05;
    }
    env->lamps = lamps;
    env->lamp_count = 40;
}

/* Halves of a picture are the picture, and both wrappers draw it. */
static void no_seam(void **state)
{
    (void)state;
    static const char *const shadings[] = { "fragment", "compute" };
    static uint8_t first[256 * 192 * 4];
    struct pel_lamp lamps[40];
    test_sea(7.0, 0.0, 3, &sea);
    struct pel_environment env = dark(30000);
    harbour(&env, lamps);
    struct pel_camera whole =
        test_camera((struct test_look){ 11, 3, -4, 7, 50, 256, 192 });
    whole.auto_exposure = false;
    whole.exposure_ev = -4;
    for (int s = 0; s < 2; s++) {
        struct pel_renderer *r = test_renderer(shadings[s]);
        struct pel_picture *p =
            test_draw(r, &env, &whole, PEL_LAYER_COLOR | PEL_LAYER_RADIANCE);
        if (s == 0) {
            memcpy(first, p->rgba, sizeof first);
        } else if (pel_renderer_is_software(r)) {
            assert_memory_equal(first, p->rgba, sizeof first);
        }
        for (int half = 0; half < 2; half++) {
            struct pel_camera part = whole;
            double middle = 0.5 * (whole.tan_left + whole.tan_right);
            part.width = 128;
            *(half ? &part.tan_left : &part.tan_right) = middle;
            struct pel_picture *q =
                test_draw(r, &env, &part, PEL_LAYER_COLOR | PEL_LAYER_RADIANCE);
            for (uint32_t y = 0; y < 192; y++) {
                size_t at = 128 * (size_t)half + 256 * (size_t)y;
                assert_memory_equal(q->radiance + (size_t)4 * 128 * y,
                                    p->radiance + 4 * at,
                                    128 * 4 * sizeof(float));
            }
            pel_picture_release(q);
        }
        pel_picture_release(p);
        pel_renderer_destroy(r);
    }
    pel_sea_finish(&sea);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(energy_by_allard),
        cmocka_unit_test(hidden),
        cmocka_unit_test(path_of_a_light),
        cmocka_unit_test(no_seam),
    };
    return cmocka_run_group_tests(tests, begin_renderer, end_renderer);
}
