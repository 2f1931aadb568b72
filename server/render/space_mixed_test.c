/* Views with things near the eye, from 20 km up to where the form from high up
 * stands alone: the two forms' light is mixed, and nothing jumps. */
#include "render/render_testkit.h"

#include "models/builtin.h"
#include "render/spacemap.h"

#define WIDTH 96
#define HEIGHT 72
#define PIXELS (WIDTH * HEIGHT)

/* What stands at the origin is in the middle of pictures from here. */
#define SEEN_FROM 35e3

static struct pel_sea sea;

static struct pel_environment overcast(void)
{
    struct pel_environment env = test_environment(&sea, 20.0);
    const struct pel_cloud_kind *kind = pel_cloud_kind(PEL_CLOUD_CUMULUS);
    env.lights[PEL_LIGHT_SUN].direction = test_sun(40.0, 130.0);
    env.sparkle = false;
    env.clouds = (struct pel_clouds){ .cover = 0.5,
                                      .genus = PEL_CLOUD_CUMULUS,
                                      .base_m = kind->base_m,
                                      .thickness_m = kind->thickness_m,
                                      .seed = 5 };
    return env;
}

static struct pel_picture *draw(const struct pel_environment *env,
                                double height_m, unsigned layers)
{
    struct pel_camera c = test_camera(
        (struct test_look){ height_m, 40.0, -35.0, 0.0, 50.0, WIDTH, HEIGHT });
    return test_draw(renderer, env, &c, layers);
}

/* The mix is of light, by the share, and of nothing else. */
static void light_is_mixed(void **state)
{
    (void)state;
    const unsigned layers =
        PEL_LAYER_RADIANCE | PEL_LAYER_SKY | PEL_LAYER_DEPTH | PEL_LAYER_NORMAL;
    const double heights[] = { 20000, 21000, 24000, 26000, 30000 };
    for (size_t i = 0; i < sizeof heights / sizeof *heights; i++) {
        struct pel_environment env = overcast();
        double share = pel_space_share(&env, heights[i]), worst = 0;
        struct pel_picture *is = draw(&env, heights[i], layers);
        env.high = -1;
        struct pel_picture *low = draw(&env, heights[i], layers);
        env.high = 1;
        struct pel_picture *high = draw(&env, heights[i], layers);
        const struct pel_picture *form = share < 0.5 ? low : high;
        for (int k = 0; k < 4 * PIXELS; k++) {
            double wanted = (1 - share) * (double)low->radiance[k] +
                            share * (double)high->radiance[k];
            double sky = (1 - share) * (double)low->sky[k] +
                         share * (double)high->sky[k];
            if (k % 4 < 3) {
                worst = fmax(worst, fabs((double)is->radiance[k] / wanted - 1));
                worst = fmax(worst, fabs((double)is->sky[k] / sky - 1));
            }
        }
        print_message("%.0f m: share %.3f, off by %.1e at most\n", heights[i],
                      share, worst);
        assert_true(worst < 1e-5); /* rounding of floats */
        assert_memory_equal(is->depth, form->depth, PIXELS * sizeof(float));
        assert_memory_equal(is->normal, form->normal,
                            4 * PIXELS * sizeof(float));
        if (share <= 0 || share >= 1) {
            assert_memory_equal(is->radiance, form->radiance,
                                3 * sizeof(float));
        }
        pel_picture_release(is);
        pel_picture_release(low);
        pel_picture_release(high);
    }
}

static double mean(const struct pel_picture *p, int channel, int from, int to)
{
    double sum = 0;
    for (int k = from * WIDTH; k < to * WIDTH; k++) {
        sum += (double)p->radiance[4 * k + channel];
    }
    return sum / ((to - from) * WIDTH);
}

/* What is mixed is alike: clouds have one cover and light, shadows on the sea,
 * the same air before them. */
static void forms_are_alike(void **state)
{
    (void)state;
    const double pitches[] = { -90, -35, -20 };
    for (int i = 0; i < 3; i++) {
        struct pel_picture *form[2];
        struct pel_camera c = test_camera((struct test_look){
            20000, 40.0, pitches[i], 0.0, 15.0, WIDTH, HEIGHT });
        struct pel_environment env = overcast();
        for (int k = 0; k < 2; k++) {
            env.high = k ? 1 : -1;
            form[k] = test_draw(renderer, &env, &c, PEL_LAYER_RADIANCE);
        }
        double whole = 0, worst = 0;
        for (int k = 0; k < 3; k++) {
            whole = fmax(whole, fabs(mean(form[1], k, 0, HEIGHT) /
                                         mean(form[0], k, 0, HEIGHT) -
                                     1));
            for (int y = 0; y < HEIGHT; y += 24) {
                worst = fmax(worst, fabs(mean(form[1], k, y, y + 24) /
                                             mean(form[0], k, y, y + 24) -
                                         1));
            }
        }
        print_message("pitch %g: the forms' means differ by %.1f %%, of a "
                      "third of the picture by %.1f\n",
                      pitches[i], 100 * whole, 100 * worst);
        /* At a slant a slab has no lit walls; 30 % where the air before
         * clouds, their shadows or their sides are left out. */
        assert_true(whole < 0.2);
        pel_picture_release(form[0]);
        pel_picture_release(form[1]);
    }
}

/* Means of rows of 8 pixels each, of a picture as it is shown. */
static double shown(const struct pel_picture *p, int y)
{
    double sum = 0;
    for (int k = 8 * y * WIDTH; k < 8 * (y + 1) * WIDTH; k++) {
        sum += (p->rgba[4 * k] + p->rgba[4 * k + 1] + p->rgba[4 * k + 2]) /
               (3.0 * 8 * WIDTH);
    }
    return sum;
}

/* As above, from `behind_m` behind the origin. */
static struct pel_picture *draw_behind(const struct pel_environment *env,
                                       double height_m, double behind_m)
{
    struct pel_camera c = test_camera(
        (struct test_look){ height_m, 40.0, -35.0, 0.0, 50.0, WIDTH, HEIGHT });
    c.east_m = -behind_m * sin(40 * PEL_DEG);
    c.north_m = -behind_m * cos(40 * PEL_DEG);
    return test_draw(renderer, env, &c, PEL_LAYER_COLOR);
}

static void rise(const char *what, const struct pel_environment *env,
                 double behind_m)
{
    struct pel_picture *before = NULL;
    double worst = 0, ev = 0;
    for (double h = 19800; h < 31000; h *= 1.005) {
        struct pel_picture *now = draw_behind(env, h, behind_m);
        for (int y = 0; before && y < HEIGHT / 8; y++) {
            worst = fmax(worst, fabs(shown(now, y) - shown(before, y)));
        }
        if (before) {
            ev = fmax(ev, fabs(now->exposure_ev - before->exposure_ev));
            pel_picture_release(before);
        }
        before = now;
    }
    pel_picture_release(before);
    print_message("%s, each 1/200 of height from 20 to 30 km: bands of 8 "
                  "rows by %.2f of 255, EV by %.3f\n",
                  what, worst, ev);
    /* Clouds that come into a band and leave it: 2.1, and 3.3 by steps twice as
     * long, which would not change a jump. */
    assert_true(worst < 2.5 && ev < 0.02);
}

static void nothing_jumps(void **state)
{
    (void)state;
    struct pel_environment bare = overcast(), env = bare;
    const struct pel_builtin ship = { .name = "tanker" };
    const struct pel_seabed *bed = test_bed(test_island);
    struct pel_object object = {
        .id = 1, .world_from_model = { { 1, 0, 0 }, { 0, 1, 0 }, { 0, 0, 1 } }
    };
    struct pel_fault fault;
    assert_int_equal(pel_builtin_make(&ship, &object.model, &fault), PEL_OK);
    assert_int_equal(pel_model_shade(object.model, &fault), PEL_OK);
    bare.clouds.cover = 0;
    rise("clouds", &env, 0);
    env = bare;
    env.objects = &object;
    env.object_count = 1;
    rise("a ship", &env, SEEN_FROM);
    env = test_over(bare, bed, 400);
    rise("a height field", &env, SEEN_FROM);
    pel_model_unref(object.model);
    pel_seabed_unref(bed);
}

static int begin(void **state)
{
    (void)state;
    test_sea(8.0, 0.0, 3, &sea);
    renderer = test_renderer("fragments");
    return 0;
}

static int begin_compute(void **state)
{
    (void)state;
    test_sea(8.0, 0.0, 3, &sea);
    renderer = test_renderer("compute");
    return 0;
}

static int end(void **state)
{
    pel_sea_finish(&sea);
    return end_renderer(state);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(light_is_mixed),
        cmocka_unit_test(forms_are_alike),
        cmocka_unit_test(nothing_jumps),
    };
    const struct CMUnitTest compute[] = {
        cmocka_unit_test(light_is_mixed),
    };
    return cmocka_run_group_tests(tests, begin, end) +
           cmocka_run_group_tests(compute, begin_compute, end);
}
