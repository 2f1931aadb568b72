/* Foam from below: the same patches as from above, and no light made or lost:
 * what it sends up, what it lets down and what it takes are all that falls on
 * it. */
#include "ocean/foam.h"
#include "optics/airkept.h"
#include "optics/atmosphere.h"
#include "render/render_testkit.h"

enum { SIDE = 160, SQUARES = 8, OF = SIDE / SQUARES };
#define FAR_M 30.0
#define SQUARE_M 40.0

static struct pel_sea foamy;

static struct pel_environment water(double albedo)
{
    struct pel_environment env = test_environment(&foamy, 16.0);
    env.lights[0].direction = test_sun(70.0, 40.0);
    for (int i = 0; i < PEL_WATER_WAVELENGTHS; i++) {
        env.water.absorption[i] = 0.001;
        env.water.scattering[i] = env.water.molecular[i] = 0.0;
        env.water.albedo[i] = albedo;
    }
    env.water.depth_m = 40.0;
    return env;
}

/* The same square from above and from below, first row north. */
static struct pel_picture *seen(const struct pel_environment *env, bool below)
{
    double fov = 2 * atan(0.5 * SQUARE_M / FAR_M) / PEL_DEG;
    struct pel_camera c = test_camera((struct test_look){
        below ? -FAR_M : FAR_M, 0, below ? 90 : -90, 0, fov, SIDE, SIDE });
    c.auto_exposure = false;
    c.exposure_ev = 13.0;
    return test_draw(renderer, env, &c, PEL_LAYER_FOAM | PEL_LAYER_RADIANCE);
}

/* Seen from below north is at the bottom. */
static size_t place(bool below, int x, int y)
{
    return (size_t)(below ? SIDE - 1 - y : y) * SIDE + (size_t)x;
}

static void squares_of(const struct pel_picture *p, bool below,
                       double mean[SQUARES * SQUARES])
{
    memset(mean, 0, sizeof *mean * SQUARES * SQUARES);
    for (int y = 0; y < SIDE; y++) {
        for (int x = 0; x < SIDE; x++) {
            mean[y / OF * SQUARES + x / OF] +=
                (double)p->layer[PEL_AT_FOAM][place(below, x, y)] / (OF * OF);
        }
    }
}

static void the_same_patches(void **state)
{
    (void)state;
    struct pel_environment env = water(0.0);
    struct pel_picture *from[2] = { seen(&env, false), seen(&env, true) };
    double mean[2][SQUARES * SQUARES], sum[2] = { 0 }, both = 0,
                                       square[2] = { 0 };
    for (int k = 0; k < 2; k++) {
        squares_of(from[k], k, mean[k]);
        for (int i = 0; i < SQUARES * SQUARES; i++) {
            sum[k] += mean[k][i] / (SQUARES * SQUARES);
        }
        pel_picture_release(from[k]);
    }
    for (int i = 0; i < SQUARES * SQUARES; i++) {
        double a = mean[0][i] - sum[0], b = mean[1][i] - sum[1];
        both += a * b;
        square[0] += a * a;
        square[1] += b * b;
    }
    double alike = both / sqrt(square[0] * square[1]);
    print_message("foam %.4f from above, %.4f from below; squares of 5 m "
                  "correlate by %.3f\n",
                  sum[0], sum[1], alike);
    /* Crests and troughs of a metre are nearer to one of the two: 4 % of the
     * picture's scale, at whose edges other water is seen. */
    assert_true(sum[0] > 0.01 && fabs(sum[1] / sum[0] - 1) < 0.1);
    assert_true(alike > 0.9);
}

/* What falls on the level sea, green, by the reference of the sky. */
static double falling(const struct pel_environment *env)
{
    const struct pel_atmosphere *air = NULL;
    assert_int_equal(pel_air_take(env->visibility_m, NULL, NULL, &air), PEL_OK);
    struct pel_vec3 sun = env->lights[0].direction;
    double sum = pel_atmosphere_sun_irradiance(air, 2.0, sun).g * sun.z;
    const double step = 3.0 * PEL_DEG;
    for (double z = 0.5 * step; z < 0.5 * PEL_PI; z += step) {
        for (double a = 0.5 * step; a < 2 * PEL_PI; a += step) {
            const struct pel_vec3 dir = { sin(z) * cos(a), sin(z) * sin(a),
                                          cos(z) };
            sum += pel_atmosphere_sky(air, 2.0, dir, sun).g * cos(z) * sin(z) *
                   step * step;
        }
    }
    pel_air_give(air);
    return sum;
}

/* Mean radiance of what is nearly all foam, green and red, over its share. */
static void of_foam(const struct pel_environment *env, bool below,
                    double mean[2])
{
    struct pel_picture *p = seen(env, below);
    int count = 0;
    double share = 0;
    mean[0] = mean[1] = 0;
    for (int i = 0; i < SIDE * SIDE; i++) {
        double foam = (double)p->layer[PEL_AT_FOAM][i];
        if (foam > 0.9) {
            share += foam;
            mean[0] += (double)p->radiance[4 * i + 1];
            mean[1] += (double)p->radiance[4 * i];
            count++;
        }
    }
    pel_picture_release(p);
    assert_true(count > 50);
    mean[0] /= share;
    mean[1] /= share;
}

static void nothing_is_lost(void **state)
{
    (void)state;
    struct pel_environment env = water(0.0);
    double above[2], below[2], all = falling(&env);
    of_foam(&env, false, above);
    of_foam(&env, true, below);
    double up = PEL_PI * above[0] / all,
           down = PEL_PI * below[0] / all * exp(0.001 * FAR_M);
    print_message("green: %.3f goes up, %.3f down, together %.3f\n", up, down,
                  up + down);
    /* A tenth of a pixel may be open sea; faces of waves turn to the Sun. What
     * goes up is Koepke's, more in the thick middles that these pixels are. */
    assert_true(fabs(up + down - 1) < 0.05);
    double red = (below[1] / above[1]) / (below[0] / above[0]);
    print_message("red: %.3f times as much down by up as green\n", red);
    /* A twentieth less goes up, and that is taken. */
    assert_true(fabs(red * PEL_FOAM_RED - 1) < 0.02);
}

/* Radiance straight down, close below the surface. */
static double from_below(const struct pel_environment *env)
{
    struct pel_camera c =
        test_camera((struct test_look){ -8.0, 0, -90, 0, 30, SIDE, SIDE });
    struct pel_picture *p = test_draw(renderer, env, &c, PEL_LAYER_RADIANCE);
    double sum = 0;
    for (int i = 0; i < SIDE * SIDE; i++) {
        sum += (double)p->radiance[4 * i + 1] / (SIDE * SIDE);
    }
    pel_picture_release(p);
    return sum;
}

/* Light from below: what foam sends back of a bright bottom's. */
static void sends_back(void **state)
{
    (void)state;
    struct pel_environment dark = water(0.0), bright = water(0.6);
    double without[2], with[2];
    of_foam(&dark, true, without);
    of_foam(&bright, true, with);
    double more = from_below(&bright) - from_below(&dark);
    double back = (with[0] - without[0]) / more;
    double want =
        1 - (1 - PEL_FOAM_ALBEDO) / (PEL_WATER_INDEX * PEL_WATER_INDEX);
    print_message("of light from below %.3f, by reciprocity %.3f\n", back,
                  want);
    /* Light comes from below by ways of 30 to 100 m: 3 to 10 % are taken. */
    assert_true(fabs(back / want - 1) < 0.1);
}

int main(void)
{
    struct pel_sea_desc desc = test_wind(16.0, 3);
    desc.synthesiser = PEL_SYNTHESISER_FFT;
    desc.whitecaps = 4.0;
    if (pel_sea_build(&desc, &foamy) != PEL_OK) {
        return 1;
    }
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_same_patches),
        cmocka_unit_test(nothing_is_lost),
        cmocka_unit_test(sends_back),
    };
    int failed = cmocka_run_group_tests(tests, begin_renderer, end_renderer);
    pel_sea_finish(&foamy);
    return failed;
}
