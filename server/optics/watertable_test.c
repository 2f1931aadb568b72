#include "optics/watertable.h"

#include <math.h>
#include <stdlib.h>
#include <time.h>

#include "base/near.h"
#include "base/vec.h"
#include "optics/brdf.h"
#include "optics/ordinates.h"

static double channel(struct pel_rgb c, int i)
{
    return i == 0 ? c.r : i == 1 ? c.g : c.b;
}

/* Waters from the clearest to the harbour, shallow and deep. */
static struct pel_water_body water(int k)
{
    static const struct pel_water_desc descs[] = {
        { .kind = PEL_WATER_JERLOV, .jerlov = PEL_JERLOV_I, .depth_m = 1000 },
        { .chlorophyll_mg_m3 = 0.2, .depth_m = 5, .bottom = PEL_BOTTOM_SAND },
        { .kind = PEL_WATER_NAMED, .name = PEL_WATER_BALTIC, .depth_m = 40 },
        { .kind = PEL_WATER_NAMED, .name = PEL_WATER_HARBOUR, .depth_m = 1 },
        { .kind = PEL_WATER_COEFFICIENTS,
          .absorption = { 0.02, 0.02, 0.05 },
          .scattering = { 0.5, 1.0, 0.2 },
          .asymmetry = { 0.924, 0.924, 0.924 },
          .depth_m = 1000 },
    };
    struct pel_water_body body;
    assert_int_equal(pel_water_resolve(&descs[k], &body, NULL), PEL_OK);
    return body;
}
#define WATERS 5
#define VIEWS 48

/* The reference at a view and azimuth, from its series. */
static double reference(struct pel_ordinates *o, const struct pel_medium *m,
                        double sun_zenith, double view_mu, double cosine,
                        const double *series, int modes, int view)
{
    struct pel_geometry at = { .sun_zenith_rad = sun_zenith };
    struct pel_interface f = pel_interface_at(&at);
    double total = 0.0, azimuth = acos(cosine);
    for (int i = 0; i < modes; i++) {
        total += series[i * VIEWS + view] * cos(i * azimuth);
    }
    double nu = sin(sun_zenith) / PEL_WATER_INDEX *
                    sqrt(1.0 - view_mu * view_mu) * cosine -
                f.sun_mu * view_mu;
    return (total + pel_ordinates_single(o, m, f.beam, f.sun_mu, view_mu, nu)) /
           (PEL_WATER_INDEX * PEL_WATER_INDEX);
}

struct worst {
    double error, maximum;
};

static void compare(struct worst *w, double fetched, double wanted)
{
    w->error = fmax(w->error, fabs(fetched - wanted));
    w->maximum = fmax(w->maximum, wanted);
}

/* Fetches between texels against twice as many nodes: ≤ 1/255 of the maximum,
 * which an 8-bit picture shows. Sun 0 to 88°. */
static void test_against_reference(void **state)
{
    (void)state;
    double mu[VIEWS], series[2 * 24 * VIEWS], sky[24], most[2] = { 0.0, 0.0 };
    struct pel_ordinates *o = pel_ordinates_create(24, 1e-7);
    for (int i = 0; i < VIEWS; i++) {
        double sine = (i + 0.5) / VIEWS / PEL_WATER_INDEX;
        mu[i] = sqrt(1.0 - sine * sine);
    }
    for (int i = 0; i < 24; i++) {
        sky[i] = 1.0 / PEL_PI;
    }
    for (int k = 0; k < WATERS * 3 * 3; k++) {
        struct pel_water_body body = water(k / 9);
        double sun = (const double[]){ 0.0, 50.0, 88.0 }[k % 3] * PEL_DEG;
        int c = k / 3 % 3, modes = 0;
        struct pel_medium m = pel_water_medium(&body, c);
        struct pel_water_table table;
        assert_int_equal(pel_water_table_build(&body, sun, NULL, &table), 0);
        struct pel_ordinates_light light = { sun, 1.0, NULL, 0 };
        struct worst by_sun = { 0 }, by_sky = { 0 };
        pel_ordinates_solve(o, &m, &light, mu, VIEWS, series, &modes, NULL);
        for (int i = 0; i < VIEWS * 41; i++) {
            double cosine = (i % 41) / 20.0 - 1.0,
                   sine = (i / 41 + 0.5) / VIEWS;
            compare(&by_sun,
                    channel(pel_water_table_fetch(table.sun, sine, cosine), c),
                    reference(o, &m, sun, mu[i / 41], cosine, series, modes,
                              i / 41));
        }
        struct pel_ordinates_light above = { 0.0, 0.0, sky, 1 };
        pel_ordinates_solve(o, &m, &above, mu, VIEWS, series, &modes, NULL);
        for (int i = 0; i < VIEWS; i++) {
            double sine = (i + 0.5) / VIEWS;
            compare(&by_sky,
                    channel(pel_water_table_fetch(table.sky, sine, 0.3), c),
                    series[i] / (PEL_WATER_INDEX * PEL_WATER_INDEX));
        }
        most[0] = fmax(most[0], by_sun.error / by_sun.maximum);
        most[1] = fmax(most[1], by_sky.error / by_sky.maximum);
    }
    print_message("worst of the maximum: Sun 1/%.0f, sky 1/%.0f\n",
                  1.0 / most[0], 1.0 / most[1]);
    assert_true(most[0] <= 1.0 / 255.0);
    assert_true(most[1] <= 1.0 / 255.0);
    pel_ordinates_destroy(o);
}

/* The table and the numbers on demand are one water: what pelagosctl prints
 * is the table times the surface's transmittance. */
static void test_against_numbers(void **state)
{
    (void)state;
    struct pel_water_body body = water(1);
    struct pel_water_table table;
    struct pel_geometry at = { 40 * PEL_DEG, 55 * PEL_DEG, 70 * PEL_DEG };
    assert_int_equal(
        pel_water_table_build(&body, at.sun_zenith_rad, NULL, &table), 0);
    struct pel_rgb texel = pel_water_table_fetch(
        table.sun, sin(at.view_zenith_rad), cos(at.azimuth_rad));
    double through =
        1.0 - pel_fresnel_exact(cos(at.view_zenith_rad), PEL_WATER_INDEX);
    for (int i = 0; i < 3; i++) {
        struct pel_medium m = pel_water_medium(&body, i);
        struct pel_leaving all;
        assert_int_equal(pel_transport_leaving(&m, &at, PEL_ORDERS_ALL, &all),
                         0);
        assert_near(channel(texel, i) * through, all.total, 0.004 * all.total);
    }
}

/* A sky that is dark but around the Sun lights the water as the Sun does,
 * from the right side; an even one given as a picture is the NULL sky. */
static void test_skies(void **state)
{
    (void)state;
    struct pel_water_body body = water(4);
    static struct pel_water_table table, even;
    static struct pel_water_sky sky;
    const int row = 12;
    double sun = 0.5 * PEL_PI * row / (PEL_WATER_SKY_ZENITHS - 1);
    for (int i = 0; i < PEL_WATER_SKY_ZENITHS; i++) {
        for (int j = 0; j < PEL_WATER_SKY_AZIMUTHS; j++) {
            sky.radiance[i][j] = (struct pel_rgb){ 2.0, 2.0, 2.0 };
        }
    }
    assert_int_equal(pel_water_table_build(&body, sun, &sky, &table), 0);
    assert_int_equal(pel_water_table_build(&body, sun, NULL, &even), 0);
    for (int i = 0; i < PEL_WATER_TABLE_SIZE; i++) {
        assert_near(table.sky[i][3][0], even.sky[i][3][0], 1e-6);
    }
    for (int i = 0; i < PEL_WATER_SKY_ZENITHS; i++) {
        for (int j = 0; j < PEL_WATER_SKY_AZIMUTHS; j++) {
            double there = exp(-0.5 * (i - row) * (i - row) - 0.5 * j * j);
            sky.radiance[i][j] = (struct pel_rgb){ there, there, there };
        }
    }
    assert_int_equal(pel_water_table_build(&body, sun, &sky, &table), 0);
    for (int i = 8; i < PEL_WATER_TABLE_SIZE; i += 7) {
        for (int j = 0; j < PEL_WATER_TABLE_SIZE; j += 31) {
            /* Per unit of horizontal irradiance; the patch is 10° wide. */
            double beam = table.sun[i][j][1] / cos(sun);
            assert_near(table.sky[i][j][1], beam, 0.06 * beam);
        }
    }
    assert_true(table.sky[31][31][1] > 1.05 * table.sky[31][0][1]);
}

/* The clear sky's shape, and that it matters little beside an even one. */
static void test_clear_sky(void **state)
{
    (void)state;
    struct pel_atmosphere *air = malloc(sizeof *air);
    assert_non_null(air);
    const struct pel_atmosphere_desc desc = { 40000.0 };
    pel_atmosphere_init(&desc, air);
    assert_int_equal(pel_atmosphere_tabulate(air, NULL, NULL), PEL_OK);
    static struct pel_water_sky sky;
    static struct pel_water_table clear, even;
    pel_water_sky_clear(air, 60 * PEL_DEG, &sky);
    pel_atmosphere_finish(air);
    struct pel_water_body body = water(0);
    assert_int_equal(pel_water_table_build(&body, 60 * PEL_DEG, &sky, &clear),
                     0);
    assert_int_equal(pel_water_table_build(&body, 60 * PEL_DEG, NULL, &even),
                     0);
    for (int i = 0; i < PEL_WATER_TABLE_SIZE; i++) {
        double ratio = clear.sky[i][16][2] / even.sky[i][16][2];
        assert_true(ratio > 0.8 && ratio < 1.25);
    }
    free(air);
}

/* Every legal Sun: finite, not negative, and no more leaves than came. */
static void test_bounds(void **state)
{
    (void)state;
    static struct pel_water_table table;
    for (int k = 0; k < WATERS * 6; k++) {
        const double suns[] = { 0.0, 1.0, 1.56, 1.6, PEL_PI, NAN };
        struct pel_water_body body = water(k / 6);
        assert_int_equal(
            pel_water_table_build(&body, suns[k % 6], NULL, &table), 0);
        const float *all = &table.sun[0][0][0];
        size_t count = sizeof table / sizeof *all;
        for (size_t i = 0; i < count; i++) {
            assert_true(all[i] >= 0.0F && all[i] < 0.2F);
        }
        if (k % 6 >= 3) {
            assert_true(table.sun[4][4][1] < 1e-12F);
        }
    }
}

/* Straight up, by quasi-single scattering (Gordon 1973): what is scattered
 * forward is taken as not scattered at all, so the light falls off by
 * a + b_b on its slanting way down and its way up, and is turned once. For a
 * unit of sunlight normal to its beam, before the surface's factor. */
static double quasi_single(const struct pel_medium *m, double sun_zenith)
{
    const struct pel_geometry at = { sun_zenith, 0.0, 0.0 };
    struct pel_interface f = pel_interface_at(&at);
    double back = 1.0 - pel_medium_forward(m);
    struct pel_phase turns = pel_medium_phase(m);
    double phase = pel_phase_at(&turns, -f.sun_mu);
    double fall = m->absorption + back * m->scattering;
    return f.beam * m->scattering * phase / (fall * (1.0 + 1.0 / f.sun_mu)) /
           (PEL_WATER_INDEX * PEL_WATER_INDEX);
}

/* The corners of what the schema allows: finite, not negative, at most what a
 * white Lambertian surface sends back (and 6 % where the flat surface lets
 * through better than on average). */
static void test_corners(void **state)
{
    (void)state;
    static struct pel_water_table table;
    const double a[] = { PEL_ABSORPTION_MIN, PEL_COEFFICIENT_MAX };
    const double b[] = { 0.0, 1e-3, PEL_COEFFICIENT_MAX };
    const double g[] = { 0.0, 0.5, PEL_ASYMMETRY_MAX };
    const double d[] = { PEL_DEPTH_MIN, PEL_DEPTH_MAX };
    for (int k = 0; k < 2 * 3 * 3 * 2 * 2; k++) {
        struct pel_water_body body = { .depth_m = d[k / 18 % 2] };
        for (int i = 0; i < 3; i++) {
            body.absorption[i] = a[k % 2];
            body.scattering[i] = b[k / 2 % 3];
            body.asymmetry[i] = g[k / 6 % 3];
            body.albedo[i] = k / 36;
        }
        double sun = (const double[]){ 0.0, 0.7, 1.5 }[k % 3];
        assert_int_equal(pel_water_table_build(&body, sun, NULL, &table), 0);
        const float *all = &table.sun[0][0][0];
        for (size_t i = 0; i < sizeof table / sizeof *all; i++) {
            assert_true(all[i] >= 0.0F && all[i] <= 1.06F / 3.14159F);
        }
    }
}

/* Against an approximation that shares no code with the solver. What it leaves
 * out, light that was turned by wide angles more than once, is there in
 * proportion to b/a. */
static void test_against_quasi_single_scattering(void **state)
{
    (void)state;
    static struct pel_water_table table;
    double least = HUGE_VAL, most = 0.0;
    for (double c = 0.03; c < 10.0; c *= 3.0) {
        for (double sun = 0.1; sun < 1.1; sun += 0.4) {
            struct pel_water_body body = pel_water_deep(c);
            assert_int_equal(pel_water_table_build(&body, sun, NULL, &table),
                             0);
            struct pel_rgb mine = pel_water_table_fetch(table.sun, 0.0, 0.0);
            for (int i = 0; i < 3; i++) {
                struct pel_medium m = pel_water_medium(&body, i);
                double ratio = channel(mine, i) / quasi_single(&m, sun);
                double more = (ratio - 1.0) * m.absorption / m.scattering;
                least = fmin(least, more);
                most = fmax(most, more);
            }
        }
    }
    print_message("light of more turns: %.3f to %.3f of b/a\n", least, most);
    assert_true(least > 0.0 && most < 0.05);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_against_reference),
        cmocka_unit_test(test_against_numbers),
        cmocka_unit_test(test_skies),
        cmocka_unit_test(test_clear_sky),
        cmocka_unit_test(test_bounds),
        cmocka_unit_test(test_corners),
        cmocka_unit_test(test_against_quasi_single_scattering),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
