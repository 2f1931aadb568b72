/* A low Sun over the sea at default exposure and tone: how much of a picture is
 * clipped, looking into it and abeam, in clear air and in haze; and that its
 * disc is seen through haze where the air lets it through, by arithmetic of
 * this file. */
#include "render/render_testkit.h"
#include "render/sky.h"

static struct pel_sea sea;
static const double suns[] = { 2.0, 5.0, 10.0 };

static struct pel_environment sun_at(double elevation, double visibility_m)
{
    struct pel_environment env = test_environment(&sea, 10.0);
    env.lights[PEL_LIGHT_SUN].direction = test_sun(elevation, 0.0);
    env.visibility_m = visibility_m;
    return env;
}

/* --- what is clipped ------------------------------------------------------ */

static double clipped(double elevation, double visibility_m, double heading)
{
    enum { WIDE = 320, HIGH = 240 };
    struct pel_environment env = sun_at(elevation, visibility_m);
    struct pel_camera c = test_camera(
        (struct test_look){ 6.0, heading, -4.0, 0.0, 60.0, WIDE, HIGH });
    struct pel_picture *p = test_draw(renderer, &env, &c, PEL_LAYER_COLOR);
    int count = 0;
    for (int i = 0; i < WIDE * HIGH; i++) {
        const uint8_t *v = p->rgba + (ptrdiff_t)4 * i;
        count += v[0] >= 254 || v[1] >= 254 || v[2] >= 254;
    }
    pel_picture_release(p);
    return count / (double)(WIDE * HIGH);
}

static void little_is_clipped(void **state)
{
    (void)state;
    static const double winds[] = { 4.0, 10.0, 18.0 };
    static const double airs[] = { 300000.0, 40000.0, 5000.0 };
    double worst = 0.0;
    printf("any channel at 254 or above, Sun 2, 5, 10°:\n");
    for (int w = 0; w < 3; w++) {
        test_fft_sea(winds[w], 1, &sea);
        for (int a = 0; a < 3; a++) {
            for (double heading = 0.0; heading <= 90.0; heading += 90.0) {
                printf("%3g m/s, %3g km, %2g° off:", winds[w], airs[a] / 1000,
                       heading);
                for (int s = 0; s < 3; s++) {
                    double share = clipped(suns[s], airs[a], heading);
                    printf(" %.2f %%", 100.0 * share);
                    worst = fmax(worst, share);
                }
                printf("\n");
            }
        }
        pel_sea_finish(&sea);
    }
    assert_true(worst <= 0.02);
}

/* --- the disc in haze ----------------------------------------------------- */

/* Optical depth at 550 nm of a straight ray from 6 m to the Sun: haze of
 * 3.912 / visibility, molecules included, whose density falls by 1.2 km, the
 * molecules' by 8 km, ozone of 300 Dobson units as a sheet at 22 km: by its own
 * sum in steps of 20 m up to 80 km. */
static double depth_to_sun(double elevation, double visibility_m)
{
    const double earth = 6.36e6, molecules = 1.3558e-5;
    double haze = 3.912 / visibility_m - molecules, sum = 0.0;
    double sine = sin(elevation * PEL_DEG), r0 = earth + 6.0;
    for (double t = 10.0; t < 1.6e6; t += 20.0) {
        double h = sqrt(r0 * r0 + t * t + 2.0 * r0 * t * sine) - earth;
        sum += 20.0 * (haze * exp(-h / 1200.0) + molecules * exp(-h / 8000.0));
        if (h > 80000.0) {
            break;
        }
    }
    double cosine = cos(elevation * PEL_DEG) * r0 / (earth + 22000.0);
    return sum + 0.027 / sqrt(1.0 - cosine * cosine);
}

static double decoded(uint8_t code)
{
    double v = code / 255.0;
    return v <= 0.04045 ? v / 12.92 : pow((v + 0.055) / 1.055, 2.4);
}

struct disc {
    double sky;   /* radiance at 550 nm about it */
    double light; /* its own, in the radiance of the picture */
    double shown; /* luminance of its middle over that of its surroundings */
};

/* Of its inner nine tenths against a ring from 1.2 to 2 radii, above the sea's
 * horizon, 40 pixels a degree. */
static struct disc look_at_disc(double elevation, double visibility_m)
{
    enum { SIDE = 160 };
    struct pel_environment env = sun_at(elevation, visibility_m);
    struct pel_camera c = test_camera(
        (struct test_look){ 6.0, 0.0, elevation, 0.0, 4.0, SIDE, SIDE });
    /* Exposed as one that looks ahead. */
    struct pel_camera ahead =
        test_camera((struct test_look){ 6.0, 0.0, -4.0, 0.0, 60.0, 320, 240 });
    c.sight_count = 1;
    c.sights[0] =
        (struct pel_sight){ ahead.world_from_camera, ahead.altitude_m,
                            ahead.tan_left,          ahead.tan_right,
                            ahead.tan_top,           ahead.tan_bottom };
    struct pel_picture *p =
        test_draw(renderer, &env, &c, PEL_LAYER_COLOR | PEL_LAYER_RADIANCE);
    struct pel_vec3 sun = pel_sky_quantize(env.lights[PEL_LIGHT_SUN].direction);
    double radius = pel_light_bodies[PEL_LIGHT_SUN].angular_radius_rad;
    double shown[2] = { 0.0 }, light[2] = { 0.0 }, count[2] = { 0.0 };
    for (uint32_t i = 0; i < SIDE * SIDE; i++) {
        struct pel_vec3 dir =
            test_ray(&c, i % SIDE + 0.5, (double)(i / SIDE) + 0.5);
        double off =
            sqrt(fmax(2.0 - 2.0 * pel_vec3_dot(dir, sun), 0.0)) / radius;
        if (off < 0.9 || (off > 1.2 && off < 2.0 && dir.z > 0.0)) {
            int around = off > 1.0;
            const uint8_t *v = p->rgba + 4 * (size_t)i;
            shown[around] += 0.2126 * decoded(v[0]) + 0.7152 * decoded(v[1]) +
                             0.0722 * decoded(v[2]);
            light[around] += (double)p->radiance[4 * i + 1];
            count[around] += 1.0;
        }
    }
    pel_picture_release(p);
    double inside = light[0] / count[0], around = light[1] / count[1];
    return (struct disc){ around, inside - around,
                          shown[0] / count[0] / (shown[1] / count[1]) };
}

/* Its light is that of the reference, and it is brighter than its surroundings
 * by a tenth at least wherever it is so in the air; lost where it is less than
 * a hundredth. */
static void haze_lets_it_through(void **state)
{
    (void)state;
    const double solar = 1.850 / 6.8e-5; /* W/m²/nm/sr */
    static const double airs[] = { 40000.0, 5000.0 };
    test_sea(8.0, 0.0, 1, &sea);
    for (int a = 0; a < 2; a++) {
        for (int s = 0; s < 3; s++) {
            double depth = depth_to_sun(suns[s], airs[a]);
            double want = solar * exp(-depth);
            struct disc d = look_at_disc(suns[s], airs[a]);
            printf("%2g km, Sun %2g°: depth %.2f, disc %.3g of the sky about "
                   "it (drawn %.3g), shown %.3f times as bright\n",
                   airs[a] / 1000, suns[s], depth, want / d.sky,
                   d.light / d.sky, d.shown);
            if (want > 0.1 * d.sky) {
                assert_true(d.shown >= 1.1);
                /* A path 1 % off is that times its depth. */
                assert_true(fabs(log(d.light / want)) < 0.1 + 0.02 * depth);
            } else {
                assert_true(want < 0.01 * d.sky && d.shown < 1.1);
            }
        }
    }
    pel_sea_finish(&sea);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(little_is_clipped),
        cmocka_unit_test(haze_lets_it_through),
    };
    return cmocka_run_group_tests(tests, begin_renderer, end_renderer);
}
