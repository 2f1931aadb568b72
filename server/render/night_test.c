/* The night sky: where stars are and what light they bring, the luminance of a
 * moonless sky, and that nothing of it depends on what was drawn before. */
#include "optics/colour.h"
#include "optics/moon.h"
#include "optics/stars.h"
#include "render/render_testkit.h"
#include "scene/ephemeris.h"
#include "scene/sun.h"

static struct pel_sea sea;

/* From 50° N 0° E. */
static struct pel_environment night_of(const char *utc)
{
    struct pel_environment env = test_environment(&sea, 12.0);
    double unix_s;
    assert_int_equal(pel_utc_parse(utc, &unix_s), PEL_OK);
    env.lights[PEL_LIGHT_SUN].direction = test_sun(-55, 300);
    pel_ephemeris_night(unix_s, 50 * PEL_DEG, 0, &env.night);
    env.night.on = true;
    env.night.stars = 1.0;
    return env;
}

static struct pel_environment at_night(void)
{
    return night_of("2026-01-15T22:00:00Z");
}

static bool no_catalogue(void)
{
    size_t count;
    pel_stars(&count);
    return count == 0;
}

static float *radiance_of(struct pel_renderer *r,
                          const struct pel_environment *env,
                          const struct pel_camera *c)
{
    size_t size = sizeof(float) * 4 * c->width * c->height;
    struct pel_picture *p = test_draw(r, env, c, PEL_LAYER_RADIANCE);
    float *out = malloc(size);
    memcpy(out, p->radiance, size);
    pel_picture_release(p);
    return out;
}

/* Light of a picture's stars, over what the air lets through to each. */
static double light_of_stars(const struct pel_environment *env,
                             const struct pel_camera *c, struct pel_vec3 *mean)
{
    struct pel_environment dark = *env;
    dark.night.stars = 0.0;
    float *with = radiance_of(renderer, env, c),
          *without = radiance_of(renderer, &dark, c);
    double sum = 0;
    double px = (c->tan_right - c->tan_left) / c->width;
    *mean = (struct pel_vec3){ 0, 0, 0 };
    for (uint32_t i = 0; i < c->width * c->height; i++) {
        double x = c->tan_left + px * (i % c->width + 0.5),
               y = c->tan_top - px * ((double)(i / c->width) + 0.5);
        double light = (double)with[4 * i + 1] - (double)without[4 * i + 1];
        light *= px * px * pow(1 + x * x + y * y, -1.5);
        sum += light;
        *mean = pel_vec3_add(
            *mean, pel_vec3_scale(test_ray(c, i % c->width + 0.5,
                                           (double)(i / c->width) + 0.5),
                                  light));
    }
    free(with);
    free(without);
    return sum;
}

static double through_air(const struct pel_environment *env, double elevation)
{
    struct pel_atmosphere *air = malloc(sizeof *air);
    const struct pel_atmosphere_desc desc = { env->visibility_m };
    pel_atmosphere_init(&desc, air);
    double t = pel_atmosphere_transmittance(air, 6, sin(elevation * PEL_DEG)).g;
    pel_atmosphere_finish(air);
    free(air);
    return t;
}

/* By XEphem's code and catalogue (Debian's python3-ephem 4.1.4), without
 * refraction: azimuth, elevation; magnitudes of the Bright Star Catalogue. */
static void stars_are_where_others_say(void **state)
{
    (void)state;
    static const struct {
        const char *name;
        double azimuth, elevation, magnitude;
    } rows[] = {
        { "Sirius", 163.2702, 21.7286, -1.46 },
        { "Rigel", 187.4530, 31.5596, 0.12 },
        { "Procyon", 140.6696, 38.6339, 0.38 },
        { "Betelgeuse", 174.4578, 47.2936, 0.50 },
        { "Aldebaran", 206.8268, 54.1548, 0.85 },
        { "Regulus", 100.0720, 23.7125, 1.35 },
        { "Polaris", 359.3890, 50.4828, 2.02 },
        { "Adhara", 162.7553, 9.1049, 1.50 },
    };
    if (no_catalogue()) {
        skip();
    }
    struct pel_environment env = at_night();
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        struct pel_camera c = test_camera(
            (struct test_look){ 6, rows[i].azimuth + 0.13,
                                rows[i].elevation - 0.07, 0, 1.2, 48, 48 });
        struct pel_vec3 mean;
        double sum = light_of_stars(&env, &c, &mean);
        struct pel_vec3 off = pel_vec3_add(
            pel_vec3_normalize(mean),
            pel_vec3_scale(test_sun(rows[i].elevation, rows[i].azimuth), -1));
        double degrees = sqrt(pel_vec3_dot(off, off)) / PEL_DEG;
        double want = pel_star_irradiance(rows[i].magnitude, 0.65).g *
                      through_air(&env, rows[i].elevation);
        print_message("%-10s %.4f° off, light %.4f\n", rows[i].name, degrees,
                      sum / want);
        /* Aberration is left out, 0.006°; a faint neighbour may be there. */
        assert_true(degrees < 0.015);
        assert_true(fabs(sum / want - 1) < 0.02);
    }
}

/* Of all of a wide picture, as the catalogue says. */
static void stars_add_up(void **state)
{
    (void)state;
    if (no_catalogue()) {
        skip();
    }
    struct pel_environment env = at_night();
    struct pel_camera c =
        test_camera((struct test_look){ 6, 150, 45, 10, 50, 240, 240 });
    struct pel_vec3 mean;
    double sum = light_of_stars(&env, &c, &mean), want = 0;
    size_t count, seen = 0;
    const struct pel_star *stars = pel_stars(&count);
    struct pel_atmosphere *air = malloc(sizeof *air);
    const struct pel_atmosphere_desc desc = { env.visibility_m };
    pel_atmosphere_init(&desc, air);
    for (size_t i = 0; i < count + PEL_PLANETS; i++) {
        bool star = i < count;
        struct pel_vec3 to = pel_mat3_apply(
            &env.night.local,
            star ? stars[i].to : env.night.planets[i - count].to);
        const struct pel_mat3 *m = &c.world_from_camera;
        double ahead = -pel_vec3_dot(to, m->z);
        double x = pel_vec3_dot(to, m->x) / ahead,
               y = pel_vec3_dot(to, m->y) / ahead;
        if (ahead > 0 && fabs(x) < c.tan_right && fabs(y) < c.tan_top) {
            double e = star ? stars[i].irradiance.g
                            : pel_star_irradiance(
                                  env.night.planets[i - count].magnitude, 0.8)
                                  .g;
            want += e * pel_atmosphere_transmittance(air, 6, to.z).g;
            seen++;
        }
    }
    pel_atmosphere_finish(air);
    free(air);
    print_message("%zu stars: %.4f of their light\n", seen, sum / want);
    assert_true(seen > 300);
    assert_true(fabs(sum / want - 1) < 0.02);
}

/* Halves of a picture are it, and so is it by a renderer that drew others
 * before. */
static void pictures_are_functions(void **state)
{
    (void)state;
    static const char *const wrappers[] = { "fragment", "compute" };
    struct pel_environment env = at_night();
    env.lights[PEL_LIGHT_MOON] =
        pel_light_moon(test_sun(30, 150), env.lights[PEL_LIGHT_SUN].direction,
                       0.2, PEL_MOON_DISTANCE);
    struct pel_environment day = test_environment(&sea, 3.0);
    for (size_t k = 0; k < 2; k++) {
        struct pel_camera whole =
            test_camera((struct test_look){ 6, 150, 12, 3, 60, 192, 128 });
        struct pel_camera half[2] = { whole, whole };
        half[0].width = half[1].width = 96;
        half[0].tan_right = half[1].tan_left = 0;
        struct pel_renderer *r = test_renderer(wrappers[k]);
        float *all = radiance_of(r, &env, &whole), *part[2];
        pel_renderer_destroy(r);
        r = test_renderer(wrappers[k]);
        for (size_t i = 2; i-- > 0;) {
            free(radiance_of(r, &day, &whole));
            part[i] = radiance_of(r, &env, &half[i]);
        }
        pel_renderer_destroy(r);
        for (size_t y = 0; y < 128; y++) {
            for (size_t i = 0; i < 2; i++) {
                assert_memory_equal(all + 4 * (192 * y + 96 * i),
                                    part[i] + 4 * 96 * y, 4 * 96 * sizeof *all);
            }
        }
        free(all);
        free(part[0]);
        free(part[1]);
    }
}

static double luminance(struct pel_rgb c)
{
    double m[9];
    pel_colour_matrix(0.7, m);
    return (0.2126 * m[0] + 0.7152 * m[3] + 0.0722 * m[6]) * c.r +
           (0.2126 * m[1] + 0.7152 * m[4] + 0.0722 * m[7]) * c.g +
           (0.2126 * m[2] + 0.7152 * m[5] + 0.0722 * m[8]) * c.b;
}

/* Some 22 magnitudes an arcsecond² (1.7e-4 cd/m²) at the zenith, brighter
 * towards the horizon, and the sea shows some of it. */
static void moonless_sky(void **state)
{
    (void)state;
    /* With the Milky Way around the horizon. */
    struct pel_environment env = night_of("2026-04-15T00:00:00Z");
    env.night.stars = 0.0;
    double at[3];
    static const double pitches[] = { 89, 15, -30 };
    for (size_t i = 0; i < 3; i++) {
        struct pel_camera c =
            test_camera((struct test_look){ 6, 0, pitches[i], 0, 10, 32, 32 });
        float *seen = radiance_of(renderer, &env, &c);
        double sum = 0;
        for (size_t k = 0; k < 1024; k++) {
            const float *p = seen + 4 * k;
            sum += luminance(
                (struct pel_rgb){ (double)p[0], (double)p[1], (double)p[2] });
        }
        free(seen);
        at[i] = sum / 1024;
        print_message("%3.0f°: %.3g cd/m²\n", pitches[i], at[i]);
    }
    assert_true(at[0] > 1.4e-4 && at[0] < 2.1e-4);
    assert_true(at[1] > 1.1 * at[0]);
    assert_true(at[2] > 1e-6 && at[2] < 0.2 * at[0]);
}

static int begin_sea(void **state)
{
    (void)state;
    test_sea(6.0, 0.0, 3, &sea);
    return 0;
}

static int end_sea(void **state)
{
    (void)state;
    pel_sea_finish(&sea);
    return 0;
}

static int begin(void **state)
{
    return begin_sea(state) || begin_renderer(state);
}

static int end(void **state)
{
    return end_sea(state) || end_renderer(state);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(stars_are_where_others_say),
        cmocka_unit_test(stars_add_up),
        cmocka_unit_test(moonless_sky),
    };
    /* Renderers of its own. */
    const struct CMUnitTest apart[] = {
        cmocka_unit_test(pictures_are_functions),
    };
    return cmocka_run_group_tests(tests, begin, end) +
           cmocka_run_group_tests(apart, begin_sea, end_sea);
}
