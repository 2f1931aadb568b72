/* The drawn light against the reference in C: the sky against
 * optics/atmosphere.c, the sea against optics/brdf.c and optics/watertable.c.
 */
#include "optics/atmosphere.h"
#include "optics/brdf.h"
#include "optics/watertable.h"
#include "render/render_testkit.h"
#include "render/sky.h"

/* MIN_VARIANCE of shaders/lib/shade.glsl. */
#define FLAT_VARIANCE 2e-6

static struct pel_sea sea;
static struct pel_atmosphere air;

static void breathe(double visibility_m)
{
    const struct pel_atmosphere_desc desc = { visibility_m };
    pel_atmosphere_finish(&air);
    pel_atmosphere_init(&desc, &air);
    assert_int_equal(pel_atmosphere_tabulate(&air, NULL, NULL), PEL_OK);
}

struct error {
    double sum, worst;
    int count;
};

static void note(struct error *e, double got, double want, double scale)
{
    double off = fabs(got - want) / scale;
    e->sum += off;
    e->worst = fmax(e->worst, off);
    e->count++;
}

static void note_rgb(struct error *e, const float got[3], struct pel_rgb want)
{
    note(e, got[0], want.r, want.r);
    note(e, got[1], want.g, want.g);
    note(e, got[2], want.b, want.b);
}

/* A picture of the sky from 2 m, elevations 0 to 62°, sparse pixels. */
static struct error look_at_sky(double visibility_m, double elevation,
                                double heading)
{
    struct pel_environment env = test_environment(&sea, 0.0);
    env.lights[PEL_LIGHT_SUN].direction = test_sun(elevation, 90.0);
    env.visibility_m = visibility_m;
    struct pel_vec3 sun = pel_sky_quantize(env.lights[PEL_LIGHT_SUN].direction);
    struct pel_camera c = test_camera((struct test_look){
        PEL_SKY_SEA_HEIGHT, heading, 31.0, 0.0, 62.0, 96, 96 });
    struct pel_picture *p = test_draw(renderer, &env, &c, PEL_LAYER_RADIANCE);
    struct error e = { 0 };
    /* Some 140 places all over the picture. */
    for (uint32_t i = 0; i < c.width * c.height; i += 67) {
        struct pel_vec3 dir =
            test_ray(&c, i % c.width + 0.5, (double)(i / c.width) + 0.5);
        if (dir.z < 0.0 || pel_vec3_dot(dir, sun) > cos(1.0 * PEL_DEG)) {
            continue;
        }
        note_rgb(&e, p->radiance + 4 * (size_t)i,
                 pel_atmosphere_sky(&air, PEL_SKY_SEA_HEIGHT, dir, sun));
    }
    pel_picture_release(p);
    return e;
}

static void sky_is_the_reference(void **state)
{
    (void)state;
    static const double visibilities[] = { 10e3, 40e3, 200e3 };
    static const double suns[] = { 45.0, 10.0, 2.0, -4.0 };
    static const double headings[] = { 92.0, 180.0, 270.0 };
    double mean_ratio = 0.0, ratio = 0.0;
    test_sea(0.0, 0.0, 1, &sea);
    for (size_t v = 0; v < 3; v++) {
        breathe(visibilities[v]);
        for (size_t s = 0; s < 4; s++) {
            struct error all = { 0 };
            for (size_t h = 0; h < 3; h++) {
                struct error e =
                    look_at_sky(visibilities[v], suns[s], headings[h]);
                all.sum += e.sum;
                all.count += e.count;
                all.worst = fmax(all.worst, e.worst);
            }
            double mean = all.sum / all.count;
            printf("visibility %3.0f km, Sun %3.0f°: mean error %.2f %%, worst "
                   "%.2f %%\n",
                   1e-3 * visibilities[v], suns[s], 100.0 * mean,
                   100.0 * all.worst);
            /* The table is bilinear over 96 × 64 directions and marches 32
             * steps: enough but for the last degrees above the horizon in
             * haze, which darkens within a step. In twilight light comes
             * through the air's grazing shells, which both sides sample
             * coarsely. */
            double most = suns[s] < 0.0 ? 0.20 : v == 0 ? 0.12 : 0.04;
            double mean_most = suns[s] < 0.0 ? 0.10 : v == 0 ? 0.015 : 0.006;
            mean_ratio = fmax(mean_ratio, mean / mean_most);
            ratio = fmax(ratio, all.worst / most);
        }
    }
    assert_true(mean_ratio <= 1.0);
    assert_true(ratio <= 1.0);
}

static struct pel_rgb scale_rgb(struct pel_rgb c, double f)
{
    return (struct pel_rgb){ c.r * f, c.g * f, c.b * f };
}

static struct pel_rgb add_rgb(struct pel_rgb a, struct pel_rgb b)
{
    return (struct pel_rgb){ a.r + b.r, a.g + b.g, a.b + b.b };
}

static struct pel_rgb mul_rgb(struct pel_rgb a, struct pel_rgb b)
{
    return (struct pel_rgb){ a.r * b.r, a.g * b.g, a.b * b.b };
}

/* Light of the water towards `view` through a level facet. */
static struct pel_water_table leaving;
static struct pel_rgb sun_on_sea, sky_on_sea;

static void light_water(const struct pel_environment *env, struct pel_vec3 sun)
{
    assert_int_equal(
        pel_water_table_build(&env->water, acos(sun.z), NULL, &leaving), 0);
    sky_on_sea = pel_atmosphere_sky_irradiance(&air, sun);
    sun_on_sea = pel_atmosphere_sun_irradiance(&air, 0.0, sun);
}

static struct pel_rgb water_light(struct pel_vec3 view, struct pel_vec3 sun)
{
    const struct pel_vec3 level = { 0.0, 0.0, 1.0 };
    return pel_water_table_leaving(&leaving, view, level, sun, sun_on_sea,
                                   sky_on_sea);
}

/* At the wavelengths, by Fresnel's equations. */
static struct pel_rgb reflectance(const struct pel_water_body *water,
                                  double cosine)
{
    return (struct pel_rgb){ pel_fresnel_exact(cosine, water->index[0]),
                             pel_fresnel_exact(cosine, water->index[1]),
                             pel_fresnel_exact(cosine, water->index[2]) };
}

static struct pel_rgb reflected(struct pel_rgb sky, struct pel_rgb f,
                                struct pel_rgb water)
{
    const struct pel_rgb through = { 1.0 - f.r, 1.0 - f.g, 1.0 - f.b };
    return add_rgb(mul_rgb(sky, f), mul_rgb(water, through));
}

/* A flat sea mirrors: F sky + (1 − F) water. */
static void flat_sea_mirrors(void **state)
{
    (void)state;
    static const double suns[] = { 45.0, 12.0 };
    test_sea(0.0, 0.0, 1, &sea);
    breathe(200e3);
    for (size_t s = 0; s < 2; s++) {
        struct pel_environment env = test_environment(&sea, 0.0);
        env.lights[PEL_LIGHT_SUN].direction = test_sun(suns[s], 0.0);
        env.visibility_m = 200e3;
        struct pel_vec3 sun =
            pel_sky_quantize(env.lights[PEL_LIGHT_SUN].direction);
        struct pel_camera c = test_camera(
            (struct test_look){ 2.0, 180.0, -36.0, 0.0, 52.0, 24, 24 });
        struct pel_picture *p =
            test_draw(renderer, &env, &c, PEL_LAYER_RADIANCE);
        light_water(&env, sun);
        struct error e = { 0 };
        for (uint32_t i = 0; i < c.width * c.height; i += 7) {
            struct pel_vec3 dir =
                test_ray(&c, i % c.width + 0.5, (double)(i / c.width) + 0.5);
            struct pel_vec3 view = pel_vec3_scale(dir, -1.0);
            struct pel_rgb water = water_light(view, sun);
            struct pel_vec3 up = { dir.x, dir.y, -dir.z };
            struct pel_rgb f = reflectance(&env.water, view.z);
            struct pel_rgb sky =
                pel_atmosphere_sky(&air, PEL_SKY_SEA_HEIGHT, up, sun);
            struct pel_rgb want = reflected(sky, f, water);
            note_rgb(&e, p->radiance + 4 * (size_t)i, want);
        }
        pel_picture_release(p);
        printf("flat sea, Sun %g°: mean error %.2f %%, worst %.2f %%\n",
               suns[s], 100.0 * e.sum / e.count, 100.0 * e.worst);
        /* Sky table, map of 128 × 128 and the integral over the hemisphere,
         * each within a percent or so. */
        assert_true(e.sum / e.count <= 0.015);
        assert_true(e.worst <= 0.04);
    }
}

/* From high above nothing is resolved: the variance is the sea's total, and the
 * glitter follows eq. 15, with Fresnel's equations in it. */
static void glitter_is_eq_15(void **state)
{
    (void)state;
    static const struct {
        double height_m, wind, fov;
    } cases[] = { { 8192.0, 6.0, 60.0 },
                  { 1024.0, 6.0, 120.0 },
                  { 16384.0, 10.0, 60.0 } };
    breathe(300e3);
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        test_sea(cases[k].wind, 0.0, 1, &sea);
        struct pel_environment env = test_environment(&sea, 0.0);
        env.lights[PEL_LIGHT_SUN].direction = test_sun(62.0, 130.0);
        env.visibility_m = 300e3;
        struct pel_vec3 sun =
            pel_sky_quantize(env.lights[PEL_LIGHT_SUN].direction);
        double h = cases[k].height_m;
        struct pel_camera c = test_camera(
            (struct test_look){ h, 0.0, -90.0, 0.0, cases[k].fov, 16, 16 });
        struct pel_picture *p =
            test_draw(renderer, &env, &c, PEL_LAYER_RADIANCE);
        light_water(&env, sun);
        struct pel_rgb sun_light =
            pel_atmosphere_sun_irradiance(&air, 0.0, sun);
        struct pel_vec3 wind = { cos(env.wind_to_rad), sin(env.wind_to_rad),
                                 0 };
        struct pel_vec3 side = { -wind.y, wind.x, 0 };
        struct error all = { 0 }, glitter = { 0 };
        for (uint32_t i = 0; i < 16 * 16; i++) {
            if (i % 16 < 4 || i % 16 > 11 || i / 16 < 4 || i / 16 > 11) {
                continue;
            }
            struct pel_vec3 dir =
                test_ray(&c, i % 16 + 0.5, (double)(i / 16) + 0.5);
            struct pel_vec3 v = pel_vec3_scale(dir, -1.0);
            struct pel_rgb water = water_light(v, sun);
            struct pel_vec3 view = { pel_vec3_dot(v, wind),
                                     pel_vec3_dot(v, side), v.z };
            struct pel_vec3 light = { pel_vec3_dot(sun, wind),
                                      pel_vec3_dot(sun, side), sun.z };
            double along = sea.slope_variance_along;
            double cross = sea.slope_variance_cross;
            struct pel_vec3 half =
                pel_vec3_normalize(pel_vec3_add(view, light));
            double facing = pel_vec3_dot(view, half);
            double schlick = pel_fresnel_schlick(facing, PEL_WATER_INDEX);
            struct pel_folding fold = pel_sea_folding(&sea);
            struct pel_vec2 facet = { half.x / half.z, half.y / half.z };
            double crests = pel_sharpened(
                facet, facet, along, cross, 0,
                0.75 * (fold.finest + fold.more * (along + cross)));
            struct pel_rgb glint = scale_rgb(
                mul_rgb(sun_light, reflectance(&env.water, facing)),
                pel_ross_sun(view, light, along, cross, FLAT_VARIANCE) /
                    schlick * crests);
            double f = pel_mean_fresnel(view, along, cross, env.water.index[1]);
            struct pel_vec3 up = { dir.x, dir.y, -dir.z };
            struct pel_rgb rest = add_rgb(
                scale_rgb(pel_atmosphere_sky(&air, PEL_SKY_SEA_HEIGHT, up, sun),
                          f),
                scale_rgb(water, 1.0 - f));
            struct pel_rgb whole = pel_atmosphere_transmittance(&air, 0.0, v.z);
            struct pel_rgb above = pel_atmosphere_transmittance(&air, h, v.z);
            struct pel_rgb through = { whole.r / above.r, whole.g / above.g,
                                       whole.b / above.b };
            rest = add_rgb(mul_rgb(rest, through),
                           pel_atmosphere_sky(&air, h, dir, sun));
            glint = mul_rgb(glint, through);
            const float *got = p->radiance + 4 * (size_t)i;
            note_rgb(&all, got, add_rgb(glint, rest));
            /* Red: least air and water in the way. */
            if (glint.r > 0.5 * (glint.r + rest.r)) {
                note(&glitter, got[0] - rest.r, glint.r, glint.r);
            }
        }
        pel_picture_release(p);
        printf("from %5g m, wind %g m/s: mean error %.2f %%, worst %.2f %%; "
               "glitter in red, %d px: %.2f %%, %.2f %%\n",
               h, cases[k].wind, 100.0 * all.sum / all.count, 100.0 * all.worst,
               glitter.count, 100.0 * glitter.sum / fmax(glitter.count, 1.0),
               100.0 * glitter.worst);
        assert_true(glitter.count > 4);
        assert_true(glitter.sum / glitter.count <= 0.02);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sky_is_the_reference),
        cmocka_unit_test(flat_sea_mirrors),
        cmocka_unit_test(glitter_is_eq_15),
    };
    return cmocka_run_group_tests(tests, begin_renderer, end_renderer);
}
