/* What an eye in the water sees: the window of a level sea, Beer's law, the
 * light by depth and direction against a Monte Carlo that shares nothing with
 * the program (tests/validate/undertrace), shafts that keep the mean, a lens
 * that a wave crosses, layers. */
#include "render/render_testkit.h"

#include <unistd.h>

#include "optics/airkept.h"
#include "optics/atmosphere.h"

static struct pel_sea calm;
static const char *tracer;

/* Straight to a point `zenith` degrees from the vertical, so many degrees
 * clockwise of north. */
static struct pel_camera towards(double depth_m, double zenith, double heading,
                                 double fov, uint32_t side)
{
    struct pel_camera c = test_camera((struct test_look){
        -depth_m, heading, 90.0 - zenith, 0.0, fov, side, side });
    c.auto_exposure = false;
    c.exposure_ev = 13.0;
    return c;
}

static struct pel_environment water(double absorption, double scattering)
{
    struct pel_environment env = test_environment(&calm, 5.0);
    for (int i = 0; i < PEL_WATER_WAVELENGTHS; i++) {
        env.water.absorption[i] = absorption;
        env.water.scattering[i] = scattering;
        env.water.molecular[i] = 0.02;
        env.water.back[i] = 0.0183;
        env.water.albedo[i] = 0.0;
        env.water.index[i] = PEL_WATER_INDEX;
    }
    return env;
}

/* Mean of the middle of a small picture, green. */
static double seen(const struct pel_environment *env,
                   const struct pel_camera *c)
{
    struct pel_picture *p = test_draw(renderer, env, c, PEL_LAYER_RADIANCE);
    double sum = 0;
    for (uint32_t i = 0; i < p->width * p->height; i++) {
        sum += (double)p->radiance[4 * i + 1];
    }
    double mean = sum / (p->width * p->height);
    pel_picture_release(p);
    return mean;
}

/* The share that the surface mirrors rises to all of it at the critical angle:
 * of sea water, and of fresh water 48.6°. */
static void window(void **state)
{
    (void)state;
    const double index[] = { PEL_WATER_INDEX, 1.3336 };
    for (int k = 0; k < 2; k++) {
        struct pel_environment env = water(0.001, 0.0);
        for (int i = 0; i < PEL_WATER_WAVELENGTHS; i++) {
            env.water.index[i] = index[k];
        }
        /* 10 degrees by 400 pixels, upwards in the picture to the zenith. */
        struct pel_camera c = towards(1.0, 48.0, 20.0, 10.0, 400);
        struct pel_picture *p = test_draw(
            renderer, &env, &c, PEL_LAYER_RADIANCE | PEL_LAYER_FRESNEL);
        double edge = 0, want = asin(1 / index[k]) / PEL_DEG;
        for (int y = 0; y < 400; y++) {
            struct pel_vec3 to = test_ray(&c, 200.5, y + 0.5);
            if ((double)p->fresnel[y * 400 + 200] < 0.999) {
                edge = acos(to.z) / PEL_DEG;
            }
        }
        print_message("n %.4f: all is mirrored from %.2f deg on, of %.2f\n",
                      index[k], edge, want);
        /* Facets have a deviation of 0.001 at least, of which 2.8 count. */
        assert_true(fabs(edge - want) < 0.2);
        assert_true(k == 0 || fabs(edge - 48.6) < 0.2);
        pel_picture_release(p);
    }
}

static void beers_law(void **state)
{
    (void)state;
    struct pel_environment env = water(0.05, 0.0);
    const struct pel_camera high = towards(1.0, 20.0, 220.0, 1.0, 8),
                            low = towards(21.0, 20.0, 220.0, 1.0, 8);
    double way = 20.0 / cos(20.0 * PEL_DEG);
    double left = seen(&env, &low) / seen(&env, &high);
    print_message("of the sky, 20 m deeper, %.5f is left, e^(-a s) %.5f\n",
                  left, exp(-0.05 * way));
    assert_true(fabs(left / exp(-0.05 * way) - 1) < 0.01);
}

struct traced {
    double scattered, sky;
};

static void write_sky(FILE *f, const struct pel_environment *env)
{
    const struct pel_atmosphere *air = NULL;
    assert_int_equal(pel_air_take(env->visibility_m, NULL, NULL, &air), PEL_OK);
    fprintf(f, "zenith,azimuth,radiance\n");
    for (int i = 0; i <= 30; i++) {
        for (int k = 0; k <= 24; k++) {
            double z = fmin(3.0 * i, 89.9) * PEL_DEG, a = 7.5 * k * PEL_DEG;
            struct pel_vec3 sun = env->lights[0].direction;
            double level = hypot(sun.x, sun.y);
            const struct pel_vec3 east = { sun.x / level, sun.y / level, 0 };
            const struct pel_vec3 dir = {
                sin(z) * (east.x * cos(a) - east.y * sin(a)),
                sin(z) * (east.y * cos(a) + east.x * sin(a)), cos(z)
            };
            struct pel_rgb sky = pel_atmosphere_sky(air, 2.0, dir, sun);
            fprintf(f, "%g,%g,%.6g\n", 3.0 * i, 7.5 * k, sky.g);
        }
    }
    pel_air_give(air);
}

static double sun_on_sea(const struct pel_environment *env)
{
    const struct pel_atmosphere *air = NULL;
    assert_int_equal(pel_air_take(env->visibility_m, NULL, NULL, &air), PEL_OK);
    struct pel_rgb sun =
        pel_atmosphere_sun_irradiance(air, 2.0, env->lights[0].direction);
    pel_air_give(air);
    return sun.g;
}

/* By depth and direction: the bar is 6 %. Directions within 8° of the Sun's and
 * 4° of the window's edge are left out: the peak that the water scatters
 * forward and the least slopes of the sea blur them. */
static void against_the_tracer(void **state)
{
    (void)state;
    if (access(tracer, X_OK) != 0) {
        print_message("undertrace is not built\n");
        skip();
    }
    static const double zeniths[] = {
        0, 25, 40, 56, 70, 85, 95, 120, 150, 180
    };
    static const double azimuths[] = { 0, 90, 180 };
    enum { Z = 10, A = 3, D = 3 };
    struct pel_environment env = water(0.05, 0.1);
    env.water.depth_m = 1000.0;
    const double sun_zenith = 60.0; /* test_sun(30, 40) */
    char sky[] = "/tmp/under-sky-XXXXXX", sights[] = "/tmp/under-way-XXXXXX";
    FILE *f = fdopen(mkstemp(sky), "w");
    assert_non_null(f);
    write_sky(f, &env);
    fclose(f);
    f = fdopen(mkstemp(sights), "w");
    assert_non_null(f);
    for (int i = 0; i < Z * A; i++) {
        fprintf(f, "%g %g\n", zeniths[i / A], azimuths[i % A]);
    }
    fclose(f);
    char command[1024];
    snprintf(command, sizeof command,
             "%s --depths 1,10,40 --absorption 0.05 --scattering 0.1 --phase "
             "ff:0.0183 --molecules 0.02 --sun %g --irradiance %.6g "
             "--sky-file %s --error 0.02 < %s",
             tracer, sun_zenith, sun_on_sea(&env), sky, sights);
    FILE *run = popen(command, "r");
    assert_non_null(run);
    char line[512];
    assert_non_null(fgets(line, sizeof line, run));
    double worst = 0, worst_mean = 0;
    int known = 0;
    while (fgets(line, sizeof line, run)) {
        double depth, zenith, azimuth, scattered, error, window_sky;
        assert_int_equal(sscanf(line, "%lf,%lf,%lf,%lf,%lf,%lf", &depth,
                                &zenith, &azimuth, &scattered, &error,
                                &window_sky),
                         6);
        double sun = asin(sin(sun_zenith * PEL_DEG) / PEL_WATER_INDEX);
        double z = zenith * PEL_DEG;
        double apart = acos(cos(z) * cos(sun) +
                            sin(z) * sin(sun) * cos(azimuth * PEL_DEG));
        if (apart < 8 * PEL_DEG) {
            continue;
        }
        const struct pel_camera c =
            towards(depth, zenith, 40.0 + azimuth, 1.0, 8);
        double sum = scattered + window_sky, got = seen(&env, &c);
        double off = got / sum - 1;
        print_message("%4.0f m, %3.0f deg, %3.0f: %.5f traced (+- %.1f %%), "
                      "%.5f drawn, %+.1f %%\n",
                      depth, zenith, azimuth, sum, 100 * error / sum, got,
                      100 * off);
        worst = fmax(worst, fabs(off) - 2 * error / sum);
        worst_mean += fabs(off);
        known++;
    }
    assert_int_equal(pclose(run), 0);
    unlink(sky);
    unlink(sights);
    assert_int_equal(known, (Z * A - 1) * D);
    print_message(
        "worst %.1f %% beyond twice the tracer's error, mean %.1f %%\n",
        100 * worst, 100 * worst_mean / known);
    assert_true(worst < 0.06);
}

/* What waves focus is taken from beside. */
static void shafts_keep_the_mean(void **state)
{
    (void)state;
    struct pel_sea sea;
    test_fft_sea(5.0, 3, &sea);
    struct pel_environment env = water(0.06, 0.12);
    env.sea = &sea;
    env.lights[0].direction = test_sun(60.0, 40.0);
    struct pel_camera c = towards(6.0, 70.0, 40.0, 70.0, 96);
    double even = seen(&env, &c);
    env.caustics = true;
    double shafts = seen(&env, &c);
    struct pel_picture *p = test_draw(renderer, &env, &c, PEL_LAYER_RADIANCE);
    print_message("with shafts %.4f of the light without\n", shafts / even);
    pel_picture_release(p);
    /* A picture of 6 m sees few of the waves that focus. */
    assert_true(shafts != even && fabs(shafts / even - 1) < 0.03);
    pel_sea_finish(&sea);
}

/* A lens that goes down through the surface: no step is larger than the others,
 * and half of a level picture is wet at the surface. */
static void crossed(void **state)
{
    (void)state;
    struct pel_sea sea;
    test_fft_sea(6.0, 4, &sea);
    struct pel_environment env = water(0.06, 0.12);
    env.sea = &sea;
    struct pel_surface_sample at;
    pel_sea_sample(&sea, 0.0, 0.0, env.time_s, &at);
    enum { STEPS = 33, SIDE = 64 };
    double before = 0, most = 0, first = 0, last = 0;
    for (int i = 0; i < STEPS; i++) {
        double up = 0.16 - 0.32 * i / (STEPS - 1);
        struct pel_camera c = towards(-(at.height_m + up), 90, 40, 60, SIDE);
        double now = seen(&env, &c);
        if (i > 0) {
            most = fmax(most, fabs(now - before));
        }
        first = i == 0 ? now : first;
        last = now;
        before = now;
    }
    print_message("from %.4f in the air to %.4f in the water, by steps of %.4f "
                  "at most\n",
                  first, last, most);
    /* The line crosses the picture in eleven steps, the sky's half faster. */
    assert_true(first > 2 * last);
    assert_true(most < 0.25 * (first - last));
    pel_sea_finish(&sea);
}

/* The bottom's place, and the layers of light are all the light. */
static void layers(void **state)
{
    (void)state;
    struct pel_environment env = water(0.05, 0.05);
    env.water.depth_m = 12.0;
    for (int i = 0; i < PEL_WATER_WAVELENGTHS; i++) {
        env.water.albedo[i] = 0.3;
    }
    struct pel_camera c = towards(4.0, 110.0, 10.0, 60.0, 64);
    const unsigned all = TEST_ALL_LAYERS | PEL_LAYER_SUN | PEL_LAYER_SKY |
                         PEL_LAYER_WATER | PEL_LAYER_AIR |
                         PEL_LAYER_WATER_SINGLE | PEL_LAYER_WATER_SECOND |
                         PEL_LAYER_WATER_HIGHER | PEL_LAYER_BOTTOM;
    struct pel_picture *p = test_draw(renderer, &env, &c, all);
    double off = 0, parts = 0, deep = 0;
    for (uint32_t i = 0; i < p->width * p->height; i++) {
        double light = (double)p->radiance[4 * i + 1];
        double sum = 0, of_water = 0;
        sum += (double)p->sun[4 * i + 1] + (double)p->sky[4 * i + 1];
        sum += (double)p->water[4 * i + 1] + (double)p->air[4 * i + 1];
        of_water += (double)p->water_single[4 * i + 1];
        of_water += (double)p->water_second[4 * i + 1];
        of_water += (double)p->water_higher[4 * i + 1];
        of_water += (double)p->bottom[4 * i + 1];
        off = fmax(off, fabs(sum / light - 1));
        parts = fmax(parts, fabs(of_water / (double)p->water[4 * i + 1] - 1));
        struct pel_vec3 to = test_ray(&c, i % 64 + 0.5, i / 64 + 0.5);
        if (to.z < -0.1) {
            double z = 4.0 - (double)p->depth[i] * to.z;
            deep = fmax(deep, fabs(z - 12.0));
        }
    }
    print_message("layers add up to %.1e, parts of the water to %.1e; the "
                  "bottom is %.1e m off\n",
                  off, parts, deep);
    assert_true(off < 1e-5 && parts < 1e-5); /* floats */
    assert_true(deep < 1e-3);
    pel_picture_release(p);
}

/* A picture is a function of its scene: the same bits whatever was drawn
 * before, by a new renderer, and by either wrapper. The last test: its
 * renderer takes the place of the others'. */
static void nothing_is_remembered(void **state)
{
    (void)state;
    struct pel_environment env = water(0.05, 0.05), other = water(0.2, 0.3);
    struct pel_camera c = towards(4.0, 60.0, 10.0, 60.0, 64);
    struct pel_camera away = towards(9.0, 30.0, 80.0, 90.0, 32);
    other.water.depth_m = 20.0;
    other.caustics = true;
    other.lights[0].direction = test_sun(50.0, 10.0);
    const size_t bytes = sizeof(float) * 4 * 64 * 64;
    float *before = malloc(bytes);
    assert_non_null(before);
    for (int i = 0; i < 4; i++) {
        if (i >= 2) {
            pel_renderer_destroy(renderer);
            renderer = test_renderer(i == 2 ? "fragment" : "compute");
        } else if (i == 1) {
            (void)seen(&other, &away);
        }
        struct pel_picture *p =
            test_draw(renderer, &env, &c, PEL_LAYER_RADIANCE);
        if (i == 0) {
            memcpy(before, p->radiance, bytes);
        }
        double off = 0;
        for (int k = 0; k < 4 * 64 * 64; k++) {
            off = fmax(off, fabs((double)(p->radiance[k] - before[k])));
        }
        print_message("turn %d: %.3g off\n", i, off);
        assert_memory_equal(before, p->radiance, bytes);
        pel_picture_release(p);
    }
    free(before);
}

int main(int argc, char **argv)
{
    (void)argc;
    static char path[4096];
    const char *slash = strrchr(argv[0], '/');
    snprintf(path, sizeof path, "%.*sundertrace",
             slash ? (int)(slash + 1 - argv[0]) : 0, argv[0]);
    tracer = path;
    test_sea(0.0, 0.0, 3, &calm);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(window),
        cmocka_unit_test(beers_law),
        cmocka_unit_test(against_the_tracer),
        cmocka_unit_test(shafts_keep_the_mean),
        cmocka_unit_test(crossed),
        cmocka_unit_test(layers),
        cmocka_unit_test(nothing_is_remembered),
    };
    int failed = cmocka_run_group_tests(tests, begin_renderer, end_renderer);
    pel_sea_finish(&calm);
    return failed;
}
