/* Optical depths in closed form against the extinction summed up step by step
 * along the way over a round Earth, visibility against Koschmieder, the light
 * in a slab against its limits. */
#include "optics/fog.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include <cmocka.h>

#include "optics/atmosphere.h"
#include "optics/clouds.h"

static const struct pel_fog fogs[] = {
    /* A sea fog, one with a thin edge, haze, a lifted layer. */
    { .extinction = 3.912 / 200, .top_m = 80, .soft_m = 30 },
    { .extinction = 3.912 / 1000, .top_m = 30, .soft_m = 2 },
    { .extinction = 3.912 / 15000, .top_m = 900, .soft_m = 500 },
    { .extinction = 3.912 / 600, .base_m = 60, .top_m = 150, .soft_m = 25 },
    /* Banks: on the sea, off to a side, lifted, a wide one. */
    { .extinction = 3.912 / 150,
      .top_m = 60,
      .radius_m = 800,
      .north_m = 1500 },
    { .extinction = 3.912 / 80,
      .top_m = 25,
      .radius_m = 300,
      .east_m = -90,
      .north_m = 200 },
    { .extinction = 3.912 / 400,
      .base_m = 40,
      .top_m = 120,
      .radius_m = 1500,
      .east_m = 700,
      .north_m = 900 },
    { .extinction = 3.912 / 1000,
      .top_m = 300,
      .radius_m = 9000,
      .north_m = 14000 },
};
#define FOGS ((int)(sizeof fogs / sizeof *fogs))

/* What the header says that it is, not how it is computed. */
static double extinction_at(const struct pel_fog *f, double x, double y,
                            double z)
{
    if (f->radius_m > 0) {
        double half = f->base_m > 0 ? (f->top_m - f->base_m) / 2 : f->top_m;
        double r = hypot(x - f->east_m, y - f->north_m) / f->radius_m;
        double q = r * r + pow((z - (f->top_m - half)) / half, 2);
        return q >= 1    ? 0
               : q < 0.5 ? f->extinction
                         : f->extinction * (1 - q) / 0.5;
    }
    double top = (f->top_m + f->soft_m / 2 - z) / f->soft_m;
    double base = (z - f->base_m + f->soft_m / 2) / f->soft_m;
    base = f->base_m > 0 ? base : 1;
    return f->extinction * fmax(0, fmin(1, top)) * fmax(0, fmin(1, base));
}

/* Around the Earth's middle; places on the sea by the arc from under the eye.
 */
static double summed(const struct pel_fog *f, double h, struct pel_vec3 dir,
                     double range)
{
    enum { STEPS = 10000 };
    const double earth = 6360000, step = range / STEPS;
    double level = hypot(dir.x, dir.y), sum = 0;
    for (int i = 0; i < STEPS; i++) {
        double s = (i + 0.5) * step;
        double up = earth + h + s * dir.z, across = s * level;
        double z = hypot(up, across) - earth;
        double arc = earth * atan2(across, up);
        double x = level > 0 ? arc * dir.x / level : 0;
        double y = level > 0 ? arc * dir.y / level : 0;
        sum += step * extinction_at(f, x, y, z);
    }
    return sum;
}

static double until_sea(double h, double sine)
{
    double b = (6360000 + h) * sine, c = h * (2 * 6360000 + h);
    return b < 0 && b * b > c ? c / (-b + sqrt(b * b - c)) : 60000;
}

/* Within 2 % or 0.01 of what comes through: heights between the ends of a piece
 * are taken as linear, which the Earth's curve bends by 8 m over 20 km. Where a
 * way grazes a layer's edge from above, 0.05. */
static void depth_is_that_of_steps(void **state)
{
    (void)state;
    static const double heights[] = { 2, 20, 75, 110, 400, 2000 };
    double worst = 0;
    int counted = 0, off = 0;
    for (int k = 0; k < FOGS; k++) {
        for (int i = 0; i < 6; i++) {
            for (int j = -60; j <= 60; j++) {
                double h = heights[i], e = 1e-5 * j * j * j * 0.4 * M_PI / 180;
                double azimuth = 0.35 * (j % 7);
                const struct pel_vec3 dir = { cos(e) * sin(azimuth),
                                              cos(e) * cos(azimuth), sin(e) };
                double range = until_sea(h, sin(e));
                struct pel_shader_fog f = pel_fog_seen(&fogs[k], 0, 0, 0);
                double mean;
                double ours = pel_fog_way(&f, (struct pel_vec3){ 0, 0, h }, dir,
                                          range, &mean);
                double theirs = summed(&fogs[k], h, dir, range);
                double t = fabs(exp(-ours) - exp(-theirs));
                counted += theirs > 1e-3 && theirs < 5;
                worst = fmax(worst, t);
                assert_true(mean >= 0 && mean <= range * 1.000001);
                assert_true(t < 0.05 || fabs(ours / theirs - 1) < 0.02);
                off += t > 0.01;
            }
        }
    }
    printf("transmittance differs by %.4f at most, by more than 0.01 in %d; %d "
           "ways between thin and opaque\n",
           worst, off, counted);
    assert_true(counted > 250 && off <= 3);
}

/* A black thing at the visibility before fog without end: what comes from it is
 * the fog's own light, 98 % of the horizon's. */
static void contrast_at_the_visibility(void **state)
{
    (void)state;
    for (double v = 50; v < 40000; v *= 2) {
        const struct pel_fog fog = { .extinction = pel_fog_extinction(v),
                                     .top_m = 5000,
                                     .soft_m = 100 };
        struct pel_shader_fog f = pel_fog_seen(&fog, 0, 0, 0);
        const struct pel_vec3 eye = { 0, 0, 10 }, level = { 0, 1, 0 };
        double before = exp(-pel_fog_way(&f, eye, level, v, NULL));
        double behind = exp(-pel_fog_way(&f, eye, level, 1e7, NULL));
        /* (horizon - thing) / horizon */
        double contrast = ((1 - behind) - (1 - before)) / (1 - behind);
        assert_float_equal(contrast, 0.02, 0.0005);
    }
}

static void columns_are_ways_upward(void **state)
{
    (void)state;
    for (int k = 0; k < FOGS; k++) {
        struct pel_shader_fog f = pel_fog_seen(&fogs[k], 0, 0, 0);
        for (double z = 0; z < 300; z += 17) {
            const struct pel_vec3 at = {
                fogs[k].east_m + 0.3 * fogs[k].radius_m, fogs[k].north_m, z
            };
            double above, below, scale = fogs[k].extinction;
            pel_fog_column(&f, at, &above, &below);
            double up = 0, down = 0;
            for (double s = 0.05; s < 2000; s += 0.1) {
                up += 0.1 * extinction_at(&fogs[k], at.x, at.y, z + s);
                down += s < z ? 0.1 * extinction_at(&fogs[k], at.x, at.y, z - s)
                              : 0;
            }
            assert_float_equal(above, up, 0.2 * scale + 0.002 * up);
            assert_float_equal(below, down, 0.2 * scale + 0.002 * down);
        }
    }
}

/* Where nothing is but fog, its light is that of the sky above: a white room
 * stays white. With a thick layer's upper side lit by a beam alone, what leaves
 * it upward is what does not come through. */
static void light_is_kept(void **state)
{
    (void)state;
    double once;
    const struct pel_fog_light deep = {
        .above = 5000, .below = 1e6, .way = 1e6, .mu = 0.5, .sky = M_PI
    };
    assert_float_equal(pel_fog_source(&deep, &once), 1, 0.01);
    /* Twice the flux upward at its top, over pi, is what Eddington's J is
     * there. */
    for (double tau = 2; tau < 100; tau *= 2) {
        double mu = 0.5, b = (1 - PEL_CLOUD_ASYMMETRY) * tau;
        const struct pel_fog_light top = {
            .below = tau, .mu = mu, .beam = 1, .cosine = -0.5
        };
        double source = pel_fog_source(&top, &once);
        double up = mu * (1 - pel_cloud_through(b, mu));
        double sea = 0.06 * mu * (4.0 / 3) / (b + 4.0 / 3) / M_PI * (2.0 / 3) /
                     (b + 4.0 / 3);
        printf("optical depth %3.0f: %.4f, flux %.4f\n", tau, source - once,
               up / (2 * M_PI));
        assert_float_equal(source - once - sea, up / (2 * M_PI), 0.001);
    }
}

static void banks_drift(void **state)
{
    (void)state;
    struct pel_fog f = fogs[4];
    f.east_mps = 3;
    f.north_mps = -2;
    struct pel_shader_fog s = pel_fog_seen(&f, 100, 50, 60);
    assert_float_equal((double)s.place.x, 250, 1e-3);
    assert_float_equal((double)s.place.y, 1500 - 200 - 60, 1e-3);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(depth_is_that_of_steps),
        cmocka_unit_test(contrast_at_the_visibility),
        cmocka_unit_test(columns_are_ways_upward),
        cmocka_unit_test(light_is_kept),
        cmocka_unit_test(banks_drift),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
