/* Fog as it is drawn: what comes through of the sea's light is optics/fog.c's,
 * a black thing at the visibility keeps 2 % of its contrast, fog is light by
 * day and not by night, and what is not there changes no bit. */
#include "optics/fog.h"
#include "render/render_testkit.h"

enum { SIDE = 128 };
static struct pel_sea sea;

static struct pel_picture *draw(const struct pel_environment *env,
                                const struct pel_camera *c)
{
    return test_draw(renderer, env, c,
                     PEL_LAYER_RADIANCE | PEL_LAYER_SKY | PEL_LAYER_AIR |
                         PEL_LAYER_DEPTH);
}

static struct pel_camera looking(double height_m, double pitch, double fov)
{
    return test_camera(
        (struct test_look){ height_m, 0, pitch, 0, fov, SIDE, SIDE });
}

/* A bank that stands between the eye and the sea. What the sea mirrors is seen
 * from own ship, which is far away, and its shadow falls aside. */
static void bank_takes_what_its_twin_says(void **state)
{
    (void)state;
    struct pel_environment env = test_environment(&sea, 5.0);
    struct pel_camera c = looking(8, 0, 12);
    env.lights[PEL_LIGHT_SUN].direction = test_sun(50, 90);
    env.own_north_m = -1e6;
    env.fog_count = 1;
    env.fog[0] = (struct pel_fog){
        .extinction = 0.004, .top_m = 15, .radius_m = 250, .north_m = 400
    };
    /* The same program without any of it. */
    struct pel_environment clear = env;
    clear.fog[0].extinction = 0;
    float *with = malloc(sizeof(float) * 4 * SIDE * SIDE);
    struct pel_picture *p = draw(&env, &c);
    memcpy(with, p->sky, sizeof(float) * 4 * SIDE * SIDE);
    pel_picture_release(p);
    p = draw(&clear, &c);
    struct pel_shader_fog f =
        pel_fog_seen(&env.fog[0], env.time_s, c.east_m, c.north_m);
    double worst = 0, thickest = 0;
    int counted = 0;
    for (int i = 0; i < SIDE * SIDE; i++) {
        double range = (double)p->depth[i];
        if (!isfinite(range) || range < 800 || range > 5000) {
            continue; /* of the bank's own shadow and its sky below */
        }
        struct pel_vec3 dir = test_ray(&c, i % SIDE + 0.5, i / SIDE + 0.5);
        double tau = pel_fog_way(&f, (struct pel_vec3){ 0, 0, c.altitude_m },
                                 dir, range, NULL);
        double drawn = (double)with[4 * i + 1] / (double)p->sky[4 * i + 1];
        worst = fmax(worst, fabs(drawn - exp(-tau)));
        thickest = fmax(thickest, tau);
        counted += tau > 0.1;
    }
    print_message("%d pixels, optical depth up to %.2f: what comes through "
                  "differs by %.5f\n",
                  counted, thickest, worst);
    /* The same form in single precision. */
    assert_true(counted > 300 && thickest > 0.8);
    assert_true(worst < 1e-4);
    pel_picture_release(p);
    free(with);
}

/* What stands before a black thing is `air`; before the horizon it is all. */
static void contrast_at_the_visibility(void **state)
{
    (void)state;
    static const double visible[] = { 200, 1000, 2500 };
    for (int k = 0; k < 3; k++) {
        struct pel_environment env = test_environment(&sea, 5.0);
        struct pel_camera c = looking(0.02 * visible[k], -1, 8);
        /* Twilight: by day fog is brighter towards the Sun, some percent a
         * degree, and the thing stands lower than the horizon. */
        env.lights[PEL_LIGHT_SUN].direction = test_sun(-3, 40);
        env.visibility_m = 300000;
        env.fog_count = 1;
        env.fog[0] =
            (struct pel_fog){ .extinction = pel_fog_extinction(visible[k]),
                              .top_m = 0.5 * visible[k],
                              .soft_m = 20 };
        struct pel_picture *p = draw(&env, &c);
        double sum = 0, law = 0;
        int count = 0;
        for (int x = 0; x < SIDE; x++) {
            double horizon = 0;
            for (int y = 0; y < SIDE; y++) {
                const int i = y * SIDE + x;
                double range = (double)p->depth[i];
                if (isfinite(range) && range > 3 * visible[k] && horizon <= 0) {
                    horizon = (double)p->radiance[4 * i + 1];
                }
                if (isfinite(range) && fabs(range / visible[k] - 1) < 0.1) {
                    sum += 1 - (double)p->air[4 * i + 1] / horizon;
                    law += exp(-3.912 * range / visible[k]);
                    count++;
                }
            }
        }
        print_message("visibility %g m: contrast %.4f, of %d pixels; law "
                      "%.4f\n",
                      visible[k], sum / count, count, law / count);
        assert_true(count > 100 && isfinite(sum));
        assert_float_equal(sum / count, law / count, 0.005);
        assert_float_equal(sum / count, 0.02, 0.005);
        pel_picture_release(p);
    }
}

static double luminance(const float *radiance)
{
    return 683 * 0.1 * (double)radiance[1]; /* in proportion */
}

/* By day fog is near as bright as a sheet in its light, by night it is dark. */
static void bright_by_day_dark_by_night(void **state)
{
    (void)state;
    static const double suns[] = { 40, 10, -4, -20 };
    double last = 1e9;
    for (int k = 0; k < 4; k++) {
        struct pel_environment env = test_environment(&sea, 5.0);
        struct pel_camera c = looking(10, 0, 40);
        env.lights[PEL_LIGHT_SUN].direction = test_sun(suns[k], 120);
        struct pel_picture *p = draw(&env, &c);
        double clear = luminance(p->radiance + 4 * (SIDE * 40 + 64));
        pel_picture_release(p);
        env.fog_count = 1;
        env.fog[0] = (struct pel_fog){ .extinction = pel_fog_extinction(100),
                                       .top_m = 100,
                                       .soft_m = 20 };
        p = draw(&env, &c);
        double fog = luminance(p->radiance + 4 * (SIDE * 64 + 64));
        print_message("Sun at %g deg: fog %.3g, clear sky 13 deg up %.3g\n",
                      suns[k], fog, clear);
        assert_true(fog < last && fog > 0);
        if (suns[k] > 0) {
            assert_true(fog > 0.2 * clear && fog < 3 * clear);
        }
        last = fog;
        pel_picture_release(p);
    }
}

/* Once it is gone, pictures are those of before. */
static void what_is_gone_leaves_nothing(void **state)
{
    (void)state;
    struct pel_environment env = test_environment(&sea, 5.0);
    struct pel_camera c = looking(10, -3, 50);
    float *before = malloc(sizeof(float) * 4 * SIDE * SIDE);
    struct pel_picture *p = draw(&env, &c);
    memcpy(before, p->radiance, sizeof(float) * 4 * SIDE * SIDE);
    pel_picture_release(p);
    env.fog_count = 1;
    env.fog[0] =
        (struct pel_fog){ .extinction = 0.01, .top_m = 50, .soft_m = 10 };
    p = draw(&env, &c);
    assert_memory_not_equal(p->radiance, before,
                            sizeof(float) * 4 * SIDE * SIDE);
    pel_picture_release(p);
    env.fog_count = 0;
    p = draw(&env, &c);
    assert_memory_equal(p->radiance, before, sizeof(float) * 4 * SIDE * SIDE);
    pel_picture_release(p);
    free(before);
}

static int begin(void **state)
{
    test_sea(3.0, 0.0, 3, &sea);
    return begin_renderer(state);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bank_takes_what_its_twin_says),
        cmocka_unit_test(contrast_at_the_visibility),
        cmocka_unit_test(bright_by_day_dark_by_night),
        cmocka_unit_test(what_is_gone_leaves_nothing),
    };
    return cmocka_run_group_tests(tests, begin, end_renderer);
}
