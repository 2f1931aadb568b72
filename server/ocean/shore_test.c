/* Waves over a plane beach by their queried heights, against Snell's law and
 * the flux of energy; far out the same bits; the surface is one. */
#include "ocean/shore.h"

#include <complex.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#define COLUMNS 201
#define ROWS 501
#define SPACING 20.0
#define PERIOD 10.0
#define OFFSHORE 10.0

static float heights[COLUMNS * ROWS];
static struct pel_sea sea;

/* From 10 m at x = 0 to 1 m above the level at x = 4 km. */
static struct pel_shore_bottom beach(double level_m)
{
    for (int j = 0; j < ROWS; j++) {
        for (int i = 0; i < COLUMNS; i++) {
            heights[j * COLUMNS + i] =
                (float)(-OFFSHORE + 11.0 * i / (COLUMNS - 1));
        }
    }
    return (struct pel_shore_bottom){ .columns = COLUMNS,
                                      .rows = ROWS,
                                      .west_m = 0,
                                      .south_m = -5000,
                                      .spacing_m = SPACING,
                                      .height_m = heights,
                                      .level_m = level_m,
                                      .beyond_m = OFFSHORE };
}

static struct pel_sea_desc swell(double height_m, double degrees)
{
    return (struct pel_sea_desc){
        .synthesiser = PEL_SYNTHESISER_TROCHOIDS,
        .kind = PEL_SPECTRUM_PIERSON_MOSKOWITZ,
        .fetch_m = 1e5,
        .gamma = 3.3,
        .wave_count = 60,
        .depth_m = OFFSHORE,
        .single_count = 1,
        .single[0] = { .height_m = height_m,
                       .period_s = PERIOD,
                       .direction_rad = degrees * PEL_DEG },
    };
}

static void build(const struct pel_sea_desc *desc, double level_m)
{
    const struct pel_shore_bottom bottom = beach(level_m);
    assert_int_equal(pel_sea_build(desc, &sea), PEL_OK);
    assert_int_equal(pel_sea_lay(&sea, &bottom), PEL_OK);
}

/* k of ω² = g k tanh kd, by halving. */
static double wavenumber(double depth)
{
    double omega = 2 * M_PI / PERIOD, lo = 1e-6, hi = 10;
    for (int i = 0; i < 200; i++) {
        double k = 0.5 * (lo + hi);
        *(9.81 * k * tanh(k * depth) < omega * omega ? &lo : &hi) = k;
    }
    return lo;
}

static double group(double depth)
{
    double k = wavenumber(depth), kd = k * depth;
    return 2 * M_PI / PERIOD / k * (0.5 + kd / sinh(2 * kd));
}

/* Amplitude and phase of the period in the heights over a place. */
static double complex at(double x, double y)
{
    enum { TIMES = 40 };
    double complex sum = 0;
    for (int i = 0; i < TIMES; i++) {
        struct pel_surface_sample s;
        double t = PERIOD * i / TIMES;
        pel_sea_sample(&sea, x, y, t, &s);
        sum += s.height_m * cexp(I * 2 * M_PI * t / PERIOD);
    }
    return sum * 2 / TIMES;
}

static void waves_bend_and_grow_by_snell_and_the_flux(void **state)
{
    (void)state;
    const struct pel_sea_desc desc = swell(0.1, 30);
    double worst_angle = 0, worst_height = 0;
    build(&desc, 0);
    assert_non_null(sea.shore);
    for (double depth = 9; depth >= 0.8; depth -= 0.4) {
        double x = 4000 * (OFFSHORE - depth) / 11;
        for (double y = -1000; y <= 3000; y += 1000) {
            const double step = 2;
            double complex here = at(x, y);
            double gx = carg(at(x + step, y) / at(x - step, y)) / (2 * step);
            double gy = carg(at(x, y + step) / at(x, y - step)) / (2 * step);
            double sine =
                sin(30 * PEL_DEG) * wavenumber(OFFSHORE) / wavenumber(depth);
            double angle = asin(sine) / PEL_DEG;
            double height = sqrt(group(OFFSHORE) * cos(30 * PEL_DEG) /
                                 (group(depth) * cos(angle * PEL_DEG)));
            double off_angle = atan2(gy, gx) / PEL_DEG - angle;
            double off_height = cabs(here) / 0.05 / height - 1;
            if (y == 0) {
                printf("%.1f m deep: %+.2f° of %.2f°, height %+.2f %% of "
                       "%.3f, k %.4f of %.4f\n",
                       depth, off_angle, angle, 100 * off_height, height,
                       hypot(gx, gy), wavenumber(depth));
            }
            worst_angle = fmax(worst_angle, fabs(off_angle));
            worst_height = fmax(worst_height, fabs(off_height));
        }
    }
    printf("worst %.2f°, %.2f %%\n", worst_angle, 100 * worst_height);
    assert_true(worst_angle <= 1);
    assert_true(worst_height <= 0.03);
    pel_sea_finish(&sea);
}

/* Berkhoff, Booy and Radder 1982: an elliptic shoal on a slope of 1:50 that
 * lies at 20° to the waves, 100 times as large (so 10 s). Behind it rays cross,
 * which this theory has no answer for. */
#define SCALE 100.0
static double shoal_depth(double x, double y)
{
    double c = cos(20 * PEL_DEG), s = sin(20 * PEL_DEG);
    double u = x * c - y * s, v = x * s + y * c;
    double depth = v < -5.82 ? 0.45 : 0.45 - 0.02 * (5.82 + v);
    if (u * u / 16 + v * v / 9 < 1) {
        depth += 0.3 - 0.5 * sqrt(1 - u * u / 25 - v * v / (3.75 * 3.75));
    }
    return fmax(depth, 0.07);
}

static void a_shoal_focuses(void **state)
{
    (void)state;
    enum { SIDE = 241 };
    static float shoal[SIDE * SIDE];
    for (int i = 0; i < SIDE * SIDE; i++) {
        shoal[i] =
            (float)(-SCALE * shoal_depth((i % SIDE - 120) * 0.1,
                                         (double)(i / SIDE - 120) * 0.1));
    }
    const struct pel_shore_bottom bottom = { .columns = SIDE,
                                             .rows = SIDE,
                                             .west_m = -12 * SCALE,
                                             .south_m = -12 * SCALE,
                                             .spacing_m = 0.1 * SCALE,
                                             .height_m = shoal,
                                             .beyond_m = 0.45 * SCALE };
    struct pel_sea_desc desc = swell(0.1, 90);
    desc.depth_m = 0.45 * SCALE;
    assert_int_equal(pel_sea_build(&desc, &sea), PEL_OK);
    assert_int_equal(pel_sea_lay(&sea, &bottom), PEL_OK);
    double highest = 0;
    for (int y = -3; y <= 9; y++) {
        struct pel_shored here;
        double across = 0;
        for (int x = -40; x <= 40; x++) {
            pel_shore_at(sea.shore, 0, 0.1 * x * SCALE, y * SCALE, &here);
            across = fmax(across, here.a);
        }
        pel_shore_at(sea.shore, 0, 0, y * SCALE, &here);
        printf("y %d m: %.2f times on the axis, %.2f at most\n", y, here.a,
               across);
        highest = fmax(highest, across);
    }
    /* Measured: 2.2. */
    assert_true(highest > 1.5 && highest < 3.01);
    pel_sea_finish(&sea);
}

/* The tide moves the waterline, and the waves with it: over a beach the sea at
 * a level is that at another, a step along. */
static void the_tide_moves_it(void **state)
{
    (void)state;
    const struct pel_sea_desc desc = swell(1.0, 0);
    double found[2];
    for (int high = 0; high < 2; high++) {
        struct pel_shored here;
        build(&desc, high * 1.1);
        /* 2.2 m deep. */
        pel_shore_at(sea.shore, 0, 4000 * (OFFSHORE - 2.2 + 1.1 * high) / 11, 0,
                     &here);
        found[high] = here.a;
        pel_sea_finish(&sea);
    }
    printf("2.2 m deep at two levels: %.3f, %.3f\n", found[0], found[1]);
    /* At the higher one the beach begins deeper, at 11.1 m. */
    assert_float_equal(found[0], found[1], 0.02 * found[0]);
}

/* No wave is higher than the depth allows. */
static void high_waves_break(void **state)
{
    (void)state;
    const struct pel_sea_desc desc = swell(3.0, 0);
    build(&desc, 0);
    for (double depth = 8; depth > 0.5; depth *= 0.7) {
        double x = 4000 * (OFFSHORE - depth) / 11, high = -9, low = 9;
        for (int i = 0; i < 80; i++) {
            struct pel_surface_sample s;
            pel_sea_sample(&sea, x, 0, PERIOD * i / 80, &s);
            high = fmax(high, s.height_m);
            low = fmin(low, s.height_m);
        }
        printf("%.2f m deep: %.2f m high, %.2f of it\n", depth, high - low,
               (high - low) / depth);
        /* At the water's edge the swash is higher. */
        assert_true(high - low < fmax(0.79 * depth, 0.036 * sqrt(3.0 * 156)));
    }
    pel_sea_finish(&sea);
}

/* A query is of its time alone; normals are the heights' gradient, by both
 * synthesisers. */
static void normals_are_the_gradient(void **state)
{
    (void)state;
    for (int fft = 0; fft < 2; fft++) {
        struct pel_sea_desc desc = swell(0.5, 20);
        desc.wind_mps = 7;
        desc.direction_rad = 0.5;
        desc.synthesiser =
            fft ? PEL_SYNTHESISER_FFT : PEL_SYNTHESISER_TROCHOIDS;
        build(&desc, 0);
        double square = 0;
        int count = 0;
        for (int i = 0; i < 200; i++) {
            /* Over a millimetre. */
            const double x = 3000 + 3.1 * i, y = 17.0 * (i % 13), h = 0.0005;
            struct pel_surface_sample s, beside[4];
            pel_sea_sample(&sea, x, y, 33, &s);
            pel_sea_sample(&sea, x - h, y, 33, &beside[0]);
            pel_sea_sample(&sea, x + h, y, 33, &beside[1]);
            pel_sea_sample(&sea, x, y - h, 33, &beside[2]);
            pel_sea_sample(&sea, x, y + h, 33, &beside[3]);
            double gx = (beside[1].height_m - beside[0].height_m) / (2 * h);
            double gy = (beside[3].height_m - beside[2].height_m) / (2 * h);
            double off = hypot(-s.normal.x / s.normal.z - gx,
                               -s.normal.y / s.normal.z - gy);
            square += off * off;
            count++;
        }
        printf("slopes off by %.4f rms\n", sqrt(square / count));
        /* Heights are answered to a micrometre. */
        assert_true(sqrt(square / count) < 0.004);
        pel_sea_finish(&sea);
    }
}

/* Where the field ends waves go over to those of the sea beyond without a step:
 * heights half a metre apart differ as slopes of these waves allow. */
static void it_ends_without_a_step(void **state)
{
    (void)state;
    const struct pel_sea_desc desc = swell(0.5, -40);
    static struct pel_sea level;
    const double k = wavenumber(1.0), h = 0.5;
    build(&desc, 0);
    assert_int_equal(pel_sea_build(&desc, &level), PEL_OK);
    double most = 0, before = NAN, beyond = 0;
    /* Along the beach, 2 m deep, and out over its southern side. */
    const double x = 4000 * (OFFSHORE - 2) / 11;
    for (double y = -4500; y > -5800; y -= h) {
        struct pel_surface_sample s, far;
        pel_sea_sample(&sea, x, y, 33, &s);
        pel_sea_sample(&level, x, y, 33, &far);
        most = isnan(before) ? most : fmax(most, fabs(s.height_m - before) / h);
        before = s.height_m;
        if (y < -5400) { /* twelve cells of 31 m */
            beyond = fmax(beyond, fabs(s.height_m - far.height_m));
        }
    }
    printf("steepest %.3f, of waves 0.5 m high on 1 m of water %.3f; "
           "beyond the rim %.1e m off\n",
           most, 0.25 * k, beyond);
    assert_true(most < 0.25 * k);
    /* Heights are answered to a micrometre. */
    assert_true(beyond < 2e-6);
    pel_sea_finish(&level);
    pel_sea_finish(&sea);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(waves_bend_and_grow_by_snell_and_the_flux),
        cmocka_unit_test(a_shoal_focuses),
        cmocka_unit_test(the_tide_moves_it),
        cmocka_unit_test(high_waves_break),
        cmocka_unit_test(normals_are_the_gradient),
        cmocka_unit_test(it_ends_without_a_step),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
