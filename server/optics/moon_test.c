/* The Moon's brightness, its disc, and which lights a picture shows. */
#include "optics/moon.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "optics/colour.h"
#include "optics/light.h"

static void near(double got, double want, double off)
{
    if (!(fabs(got - want) <= off)) {
        fail_msg("%.9g is not %.9g ± %.2g", got, want, off);
    }
}

/* Krisciunas and Schaefer 1991, eq. 9, in magnitudes less those of full Moon;
 * their eq. 20 makes 0.029 foot-candles of it above the air. */
static void brightness_by_phase(void **state)
{
    (void)state;
    static const double at[][2] = { { 0, 0 },
                                    { 30, 0.78324 },
                                    { 60, 1.61184 },
                                    { 90, 2.60244 },
                                    { 120, 3.94944 } };
    for (size_t i = 0; i < sizeof at / sizeof *at; i++) {
        double s = pel_moon_strength(at[i][0] * PEL_DEG, PEL_MOON_DISTANCE);
        near(-2.5 * log10(s), at[i][1], 1e-9);
    }
    near(pel_moon_strength(0, 2 * PEL_MOON_DISTANCE), 0.25, 1e-12);
    near(pel_moon_alpha(0.5), 0.5 * PEL_PI, 1e-12);
    near(pel_moon_alpha(1.0), 0.0, 1e-12);
    double lx = pel_colour_illuminance(
        pel_light_bodies[PEL_LIGHT_MOON].irradiance, sin(40 * PEL_DEG));
    near(lx, 10.764 * pow(10.0, -0.4 * (PEL_MOON_MAGNITUDE + 16.57)), 0.03);
}

/* By quadrature over the disc. */
static void disc_by_phase(void **state)
{
    (void)state;
    enum { N = 600 };
    for (int k = 0; k < 6; k++) {
        double alpha = 28.0 * k * PEL_DEG, sum = 0, area = 0;
        for (int i = 0; i < N * N; i++) {
            double x = 2.0 * (i % N + 0.5) / N - 1,
                   y = 2.0 * (i / N + 0.5) / N - 1;
            double z2 = 1 - x * x - y * y;
            if (z2 > 0) {
                double mu = sqrt(z2), mu0 = mu * cos(alpha) + x * sin(alpha);
                sum += mu0 > 0 ? 2 * mu0 / (mu0 + mu) : 0;
                area++;
            }
        }
        near(pel_moon_disc(alpha), sum / area, 2e-3);
    }
    near(pel_moon_disc(PEL_PI), 0.0, 1e-6);
    /* The new Moon sees a full Earth. */
    near(pel_moon_earthlight(PEL_PI), 0.5 * 0.367 * pow(6371.0 / 384400, 2),
         1e-8);
    near(pel_moon_earthlight(0.0), 0.0, 1e-12);
}

static struct pel_vec3 at(double elevation)
{
    return (struct pel_vec3){ cos(elevation * PEL_DEG), 0,
                              sin(elevation * PEL_DEG) };
}

static void the_bright_limb_faces_the_sun(void **state)
{
    (void)state;
    struct pel_vec3 sun = at(-20), to = { 0, cos(0.5), sin(0.5) };
    struct pel_light m = pel_light_moon(to, sun, 0.3, PEL_MOON_DISTANCE);
    near(pel_vec3_dot(m.source, m.source), 1.0, 1e-12);
    near(0.5 - 0.5 * pel_vec3_dot(m.source, to), 0.3, 1e-12);
    struct pel_vec3 side = pel_vec3_cross(to, sun);
    near(pel_vec3_dot(m.source, side), 0.0, 1e-12);
    assert_true(pel_vec3_dot(m.source, sun) > 0);
}

static struct pel_lights_shown shown(double sun, double moon, double lit,
                                     struct pel_light out[PEL_LIGHTS])
{
    pel_lights_of_sun(at(sun), out);
    out[PEL_LIGHT_MOON] =
        pel_light_moon(at(moon), at(sun), lit, PEL_MOON_DISTANCE);
    return pel_lights_order(out);
}

static void who_gives_light(void **state)
{
    (void)state;
    struct pel_light l[PEL_LIGHTS];
    pel_lights_of_sun(at(30), l);
    struct pel_lights_shown s = pel_lights_order(l);
    assert_true(s.lit == 1 && s.discs == 1 && l[0].body == PEL_LIGHT_SUN);
    s = shown(30, 40, 1, l); /* a Moon by day */
    assert_true(s.lit == 1 && s.discs == 2 && l[0].body == PEL_LIGHT_SUN);
    s = shown(-6, 40, 1, l);
    assert_true(s.lit == 2 && l[0].body == PEL_LIGHT_MOON);
    s = shown(-0.2, 85, 1, l); /* its disc still casts shadows */
    assert_true(s.lit == 2 && l[0].body == PEL_LIGHT_SUN);
    s = shown(-30, 40, 1, l);
    assert_true(s.lit == 1 && l[0].body == PEL_LIGHT_MOON);
    for (double e = -89; e < 89; e += 0.5) { /* falls with the Sun */
        assert_true(pel_light_level(sin(e * PEL_DEG)) <
                    pel_light_level(sin((e + 0.5) * PEL_DEG)));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(brightness_by_phase),
        cmocka_unit_test(disc_by_phase),
        cmocka_unit_test(the_bright_limb_faces_the_sun),
        cmocka_unit_test(who_gives_light),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
