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

/* By places drawn in the tile and on the waves, on a sphere: whether a lamp's
 * path may be seen there. */
static bool is_mirrored(const struct pel_environment *env,
                        const struct pel_camera *c, const struct pel_lamp *lamp,
                        double x, double y, double crest_m)
{
    struct pel_vec3 ray = pel_vec3_normalize(pel_mat3_apply(
        &c->world_from_camera,
        (struct pel_vec3){
            c->tan_left + (c->tan_right - c->tan_left) * x / c->width,
            c->tan_top - (c->tan_top - c->tan_bottom) * y / c->height, -1 }));
    struct pel_vec3 eye = { 0, 0, PEL_EARTH_RADIUS + c->altitude_m };
    double half = pel_vec3_dot(eye, ray), ground = PEL_EARTH_RADIUS + crest_m;
    double root = half * half - pel_vec3_dot(eye, eye) + ground * ground;
    if (half >= 0 || root < 0) {
        return false;
    }
    struct pel_vec3 place =
        pel_vec3_add(eye, pel_vec3_scale(ray, -half - sqrt(root)));
    struct pel_vec3 lamp_at = pel_vec3_add(
        eye, pel_globe_offset((struct pel_vec3){ 0, 0, c->altitude_m },
                              (struct pel_vec3){ lamp->east_m, lamp->north_m,
                                                 lamp->altitude_m }));
    struct pel_vec3 way = pel_vec3_add(lamp_at, pel_vec3_scale(place, -1));
    struct pel_vec3 up = pel_vec3_normalize(place);
    double away2 = pel_vec3_dot(way, way);
    struct pel_vec3 to = pel_vec3_normalize(way);
    struct pel_vec3 normal =
        pel_vec3_normalize(pel_vec3_add(to, pel_vec3_scale(ray, -1)));
    double level = pel_vec3_dot(normal, up), cosine = pel_vec3_dot(normal, to);
    double slope2 = 1 / (level * level) - 1;
    double along = env->sea->slope_variance_along,
           cross = env->sea->slope_variance_cross;
    double candela = 0.2126 * lamp->intensity_cd[0] +
                     0.7152 * lamp->intensity_cd[1] +
                     0.0722 * lamp->intensity_cd[2];
    double times = candela / away2 * PEL_LAMP_MEAN / sqrt(along * cross) *
                   (PEL_LAMP_DULLEST + pow(1 - cosine, 5));
    double most = fmin(2 * log(times), PEL_LAMP_SLOPES * PEL_LAMP_SLOPES);
    return level > 0 && pel_vec3_dot(to, up) > 0 &&
           slope2 < most * fmax(along, cross);
}

/* Nor do tiles have many lamps more than some of their pixels do. */
static void tiles_leave_nothing_out(void **state)
{
    (void)state;
    enum { WIDTH = 256, HEIGHT = 192, TRIES = 200 };
    static const struct test_look looks[] = {
        { 11, 3, -4, 7, 50, WIDTH, HEIGHT },
        { 3, -20, -2, 0, 20, WIDTH, HEIGHT },
        { 60, 10, -50, 30, 70, WIDTH, HEIGHT },
        { 25, 0, -88, 0, 60, WIDTH, HEIGHT },
    };
    struct pel_lamp lamps[40];
    test_sea(7.0, 0.0, 3, &sea);
    struct pel_environment env = dark(30000);
    harbour(&env, lamps);
    /* As many as a tile has bits. */
    env.lamp_count = PEL_GLOWS;
    uint64_t seed = 1;
    for (size_t l = 0; l < sizeof looks / sizeof *looks; l++) {
        struct pel_camera c = test_camera(looks[l]);
        struct pel_lamp_glow glow = { 0 };
        pel_lamp_glow_bind(&glow, &env, &c, 0, 0);
        const uint32_t *masks =
            glow.words + 4 * (1 + PEL_GLOW_TEXELS * PEL_GLOWS);
        int missed = 0, known = 0, true_ = 0;
        for (int tile = 0;
             tile < (WIDTH / PEL_GLOW_TILE) * (HEIGHT / PEL_GLOW_TILE);
             tile++) {
            for (int i = 0; i < PEL_GLOWS; i++) {
                bool shown = false;
                for (int k = 0; k < TRIES && !shown; k++) {
                    double at[3];
                    for (int a = 0; a < 3; a++) {
                        seed =
                            seed * 6364136223846793005U + 1442695040888963407U;
                        at[a] = (double)(seed >> 11) / 9007199254740992.0;
                    }
                    int across = WIDTH / PEL_GLOW_TILE;
                    shown = is_mirrored(&env, &c, &lamps[i],
                                        PEL_GLOW_TILE * (tile % across + at[0]),
                                        PEL_GLOW_TILE *
                                            ((double)(tile / across) + at[1]),
                                        (2 * at[2] - 1) * sqrt(sea.m0));
                }
                bool has = masks[tile] >> i & 1;
                missed += shown && !has;
                known += has;
                true_ += shown;
            }
        }
        print_message("from %g m: %d lamps in tiles, %d in pixels, %d left "
                      "out\n",
                      looks[l].height_m, known, true_, missed);
        assert_int_equal(missed, 0);
        assert_true(known < 1.8 * true_ + 20);
        pel_lamp_glow_finish(&glow);
    }
    pel_sea_finish(&sea);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(energy_by_allard),        cmocka_unit_test(hidden),
        cmocka_unit_test(path_of_a_light),         cmocka_unit_test(no_seam),
        cmocka_unit_test(tiles_leave_nothing_out),
    };
    return cmocka_run_group_tests(tests, begin_renderer, end_renderer);
}
