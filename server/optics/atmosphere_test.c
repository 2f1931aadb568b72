#include "optics/airlight.h"

#include "base/near.h"
#include "optics/airkept.h"
#include "optics/atmosphere.h"
#include "optics/clearair.h"
#include "optics/colour.h"

#define HAZE_M 10000.0
#define FOG_M 200.0

static struct pel_atmosphere clear_air, haze, fog, scratch;

static int set_up(void **state)
{
    (void)state;
    struct pel_atmosphere_desc d = { PEL_CLEAR_VISIBILITY_M };
    pel_atmosphere_init(&d, &clear_air);
    assert_int_equal(pel_atmosphere_tabulate(&clear_air, NULL, NULL), PEL_OK);
    d.visibility_m = HAZE_M;
    pel_atmosphere_init(&d, &haze);
    assert_int_equal(pel_atmosphere_tabulate(&haze, NULL, NULL), PEL_OK);
    d.visibility_m = FOG_M;
    pel_atmosphere_init(&d, &fog);
    assert_int_equal(pel_atmosphere_tabulate(&fog, NULL, NULL), PEL_OK);
    return 0;
}

static int tear_down(void **state)
{
    (void)state;
    pel_atmosphere_finish(&clear_air);
    pel_atmosphere_finish(&haze);
    pel_atmosphere_finish(&fog);
    return 0;
}

static struct pel_vec3 at_elevation(double degrees)
{
    return (struct pel_vec3){ cos(degrees * PEL_DEG), 0,
                              sin(degrees * PEL_DEG) };
}

static void assert_rgb(struct pel_rgb a, struct pel_rgb b, double relative)
{
    assert_near(a.r, b.r, relative * b.r);
    assert_near(a.g, b.g, relative * b.g);
    assert_near(a.b, b.b, relative * b.b);
}

/* The constants of docs/physics/atmosphere.md; ozone as published for this
 * model. */
static void test_constants(void **state)
{
    (void)state;
    const struct pel_atmosphere *a = &clear_air;
    assert_rgb(a->rayleigh, (struct pel_rgb){ 5.802e-6, 13.558e-6, 33.1e-6 },
               1e-3);
    assert_rgb(a->ozone, (struct pel_rgb){ 0.650e-6, 1.881e-6, 0.085e-6 },
               2e-3);
    assert_near(a->mie_extinction, 4.44e-6, 1e-9);
    assert_near(a->mie_scattering, 0.9 * a->mie_extinction, 1e-18);
}

/* Koschmieder: extinction at 550 nm at sea level is 3.912 / visibility. */
static void test_visibility(void **state)
{
    (void)state;
    for (double v = 200; v < 288000; v *= 2) {
        struct pel_atmosphere_desc d = { v };
        pel_atmosphere_init(&d, &scratch);
        assert_near(scratch.mie_extinction + scratch.rayleigh.g, 3.912 / v,
                    1e-15);
        double depth = scratch.mie_extinction * scratch.mie_height_m;
        assert_true(depth <= PEL_FOG_DEPTH * (1 + 1e-12));
        assert_true(scratch.mie_height_m == 1200 || v < 4000);
    }
    const double odd[] = { 300000, 1e9, INFINITY, -1, 0, NAN };
    for (int i = 0; i < 6; i++) {
        struct pel_atmosphere_desc d = { odd[i] };
        pel_atmosphere_init(&d, &scratch);
        assert_true(scratch.mie_extinction >= 0);
        assert_true(isfinite(scratch.mie_extinction));
    }
}

static void test_phases(void **state)
{
    (void)state;
    /* ∫ over the sphere is 1; the mean cosine of Cornette–Shanks is
     * g (3 (4 + g²)) / (5 (2 + g²)). */
    const int n = 20000;
    double rayleigh = 0, mie = 0, cosine = 0, g = 0.8;
    for (int i = 0; i < n; i++) {
        double nu = 2 * (i + 0.5) / n - 1;
        rayleigh += pel_phase_rayleigh(nu) * 4 * PEL_PI / n;
        mie += pel_phase_mie(nu, g) * 4 * PEL_PI / n;
        cosine += nu * pel_phase_mie(nu, g) * 4 * PEL_PI / n;
    }
    assert_near(rayleigh, 1, 1e-8);
    assert_near(mie, 1, 1e-6);
    assert_near(cosine, g * 3 * (4 + g * g) / (5 * (2 + g * g)), 1e-6);
}

/* Straight up, the columns are H (1 − exp(−60 km / H)), and ozone's area. */
static void test_vertical(void **state)
{
    (void)state;
    const struct pel_atmosphere *a = &clear_air;
    struct pel_columns c = pel_atmosphere_columns(a, 0, 1);
    assert_near(c.rayleigh, 8000 * (1 - exp(-7.5)), 0.1);
    assert_near(c.mie, 1200, 0.1);
    assert_near(c.ozone, 15000, 0.15);
    struct pel_rgb t = pel_atmosphere_transmittance(a, 0, 1);
    double depth = a->rayleigh.b * c.rayleigh + a->mie_extinction * c.mie +
                   a->ozone.b * c.ozone;
    assert_near(t.b, exp(-depth), 1e-12);
    t = pel_atmosphere_transmittance(a, 60000, 1);
    assert_rgb(t, (struct pel_rgb){ 1, 1, 1 }, 1e-12);
}

/* Columns along slant and falling rays against a plain midpoint sum. */
static void test_slant(void **state)
{
    (void)state;
    const struct pel_atmosphere *a = &clear_air;
    const double rays[][2] = { { 0, 0 },          { 0, 0.05 },
                               { 0, 0.5 },        { 5000, -0.03 },
                               { 20000, -0.075 }, { 40000, 0.001 } };
    for (int i = 0; i < 6; i++) {
        double r = PEL_EARTH_RADIUS + rays[i][0], mu = rays[i][1];
        double way =
            -r * mu + sqrt(PEL_ATMOSPHERE_RADIUS * PEL_ATMOSPHERE_RADIUS -
                           r * r * (1 - mu * mu));
        const int n = 400000;
        struct pel_columns sum = { 0, 0, 0 };
        for (int j = 0; j < n; j++) {
            double t = way * (j + 0.5) / n;
            double h = sqrt(r * r + t * t + 2 * r * t * mu) - PEL_EARTH_RADIUS;
            sum.rayleigh += exp(-h / 8000) * way / n;
            sum.mie += exp(-h / 1200) * way / n;
            sum.ozone += fmax(0, 1 - fabs(h - 25000) / 15000) * way / n;
        }
        struct pel_columns c = pel_atmosphere_columns(a, rays[i][0], mu);
        assert_near(c.rayleigh, sum.rayleigh, 1e-5 * sum.rayleigh);
        assert_near(c.mie, sum.mie, 1e-5 * sum.mie + 1e-9);
        assert_near(c.ozone, sum.ozone, 1e-5 * sum.ozone);
    }
}

static void test_ground_hides(void **state)
{
    (void)state;
    struct pel_rgb t = pel_atmosphere_transmittance(&clear_air, 10, -0.01);
    assert_true(t.r == 0 && t.g == 0 && t.b == 0);
    t = pel_atmosphere_transmittance(&clear_air, 500e3, -1);
    assert_true(t.r == 0);
    t = pel_atmosphere_transmittance(&clear_air, 500e3, 0.1);
    assert_true(t.r == 1);
    t = pel_atmosphere_transmittance(&clear_air, 500e3, -0.36);
    assert_true(t.r > 0 && t.r < 1); /* through the limb */
}

static void test_sun_disc(void **state)
{
    (void)state;
    double worst = 0;
    for (double x = -1.2; x <= 1.2; x += 0.01) {
        double c = pel_clamp(x, -1, 1);
        double segment = 0.5 + (c * sqrt(1 - c * c) + asin(c)) / PEL_PI;
        double seen = pel_atmosphere_sun_visible(0, x * PEL_SUN_ANGULAR_RADIUS);
        worst = fmax(worst, fabs(seen - segment));
    }
    assert_true(worst < 0.04); /* as the header says */
    double before = INFINITY;
    for (double e = 5; e > -2; e -= 0.02) {
        struct pel_rgb s =
            pel_atmosphere_sun_irradiance(&clear_air, 0, at_elevation(e));
        assert_true(s.r <= before); /* falls without a jump upward */
        assert_true(e > -0.3 || s.r == 0);
        before = s.r;
    }
}

/* --- single scattering against a plain sum ------------------------------- */

struct rgb3 {
    double c[3];
};

/* Transmittance between a point and the Sun, nothing shared with the code
 * under test but the constants. */
static struct rgb3 plain_sun(const struct pel_atmosphere *a, double r,
                             double mu)
{
    struct rgb3 t = { { 0, 0, 0 } };
    double least = r * sqrt(1 - mu * mu);
    if (mu < 0 && least < PEL_EARTH_RADIUS) {
        return t;
    }
    double way = -r * mu + sqrt(PEL_ATMOSPHERE_RADIUS * PEL_ATMOSPHERE_RADIUS -
                                r * r * (1 - mu * mu));
    const double beta_r[3] = { a->rayleigh.r, a->rayleigh.g, a->rayleigh.b };
    const double beta_o[3] = { a->ozone.r, a->ozone.g, a->ozone.b };
    const int n = 500;
    double ray = 0, mie = 0, ozone = 0;
    for (int i = 0; i < n; i++) {
        double s = way * (i + 0.5) / n;
        double h = sqrt(r * r + s * s + 2 * r * s * mu) - PEL_EARTH_RADIUS;
        ray += exp(-h / a->rayleigh_height_m) * way / n;
        mie += exp(-h / a->mie_height_m) * way / n;
        ozone += fmax(0, 1 - fabs(h - 25000) / 15000) * way / n;
    }
    for (int c = 0; c < 3; c++) {
        t.c[c] =
            exp(-beta_r[c] * ray - a->mie_extinction * mie - beta_o[c] * ozone);
    }
    return t;
}

static struct rgb3 plain_single(const struct pel_atmosphere *a, double h0,
                                struct pel_vec3 dir, struct pel_vec3 sun)
{
    double r0 = PEL_EARTH_RADIUS + h0, mu = dir.z;
    double way = -r0 * mu + sqrt(PEL_ATMOSPHERE_RADIUS * PEL_ATMOSPHERE_RADIUS -
                                 r0 * r0 * (1 - mu * mu));
    double nu = pel_vec3_dot(dir, sun), g = a->mie_g;
    double phase_r = 3 / (16 * PEL_PI) * (1 + nu * nu);
    double phase_m = 3 / (8 * PEL_PI) * (1 - g * g) * (1 + nu * nu) /
                     ((2 + g * g) * pow(1 + g * g - 2 * g * nu, 1.5));
    const double beta_r[3] = { a->rayleigh.r, a->rayleigh.g, a->rayleigh.b };
    const double beta_o[3] = { a->ozone.r, a->ozone.g, a->ozone.b };
    const double e[3] = { a->solar_irradiance.r, a->solar_irradiance.g,
                          a->solar_irradiance.b };
    struct rgb3 sum = { { 0, 0, 0 } };
    double depth[3] = { 0, 0, 0 };
    const int n = 2000;
    for (int i = 0; i < n; i++) {
        double t0 = way * i * i / ((double)n * n);
        double t1 = way * (i + 1) * (i + 1) / ((double)n * n);
        double t = 0.5 * (t0 + t1), dt = t1 - t0;
        struct pel_vec3 p = { dir.x * t, dir.y * t, r0 + dir.z * t };
        double r = sqrt(pel_vec3_dot(p, p)), h = r - PEL_EARTH_RADIUS;
        struct rgb3 s = plain_sun(a, r, pel_vec3_dot(p, sun) / r);
        double ray = exp(-h / a->rayleigh_height_m);
        double mie = exp(-h / a->mie_height_m);
        double ozone = fmax(0, 1 - fabs(h - 25000) / 15000);
        for (int c = 0; c < 3; c++) {
            double sigma =
                beta_r[c] * ray + a->mie_extinction * mie + beta_o[c] * ozone;
            depth[c] += 0.5 * sigma * dt;
            sum.c[c] +=
                e[c] * s.c[c] * exp(-depth[c]) * dt *
                (beta_r[c] * ray * phase_r + a->mie_scattering * mie * phase_m);
            depth[c] += 0.5 * sigma * dt;
        }
    }
    return sum;
}

/* 0.2 % of the brightest channel and 0.3 % of each: what 64 steps of a ray and
 * the table of columns cost. 4 % in haze, where the table's error stands in
 * an exponent of ten and more near a setting Sun. */
static void test_single_scattering(void **state)
{
    (void)state;
    static const double cases[][3] = {
        /* Sun's elevation, view's elevation, view's azimuth; degrees */
        { 90, 90, 0 },  { 60, 30, 40 }, { 30, 5, 120 }, { 30, 1, 180 },
        { 10, 20, 10 }, { 5, 90, 0 },   { 2, 2, 0 },    { 2, 60, 180 },
        { -2, 10, 0 },  { -5, 5, 30 },
    };
    const struct pel_atmosphere *airs[] = { &clear_air, &haze };
    double worst = 0;
    for (int k = 0; k < 20; k++) {
        const struct pel_atmosphere *a = airs[k / 10];
        const double *q = cases[k % 10];
        double height = k % 3 == 2 ? 3000 : 10;
        static struct pel_airlight none;
        for (size_t i = 0; i < sizeof none / sizeof(float); i++) {
            (&none.log2[0][0][0][0][0])[i] = -1000.0f;
        }
        scratch = *a;
        scratch.airlight = &none;
        struct pel_vec3 sun = at_elevation(q[0]), dir = at_elevation(q[1]);
        dir.y = dir.x * sin(q[2] * PEL_DEG);
        dir.x = dir.x * cos(q[2] * PEL_DEG);
        struct pel_rgb s = pel_atmosphere_sky(&scratch, height, dir, sun);
        struct rgb3 p = plain_single(a, height, dir, sun);
        double most = fmax(p.c[0], fmax(p.c[1], p.c[2]));
        const double got[3] = { s.r, s.g, s.b };
        for (int c = 0; c < 3; c++) {
            worst = fmax(worst, fabs(got[c] - p.c[c]) / most);
            assert_near(got[c], p.c[c],
                        0.002 * most + (k < 10 ? 0.003 : 0.04) * p.c[c]);
        }
    }
    print_message("single scattering within %.4f of the brightest channel\n",
                  worst);
}

/* --- all orders ---------------------------------------------------------- */

/* The table that tests/validate/airtrace makes by random paths, with a sea
 * below: visibility, the Sun's zenith angle, the line of sight's, its azimuth,
 * radiance at 680, 550, 440 nm, each within 1 %. 4 % beside that: the
 * program's bar is 1.5 % in the median, 10 % at most. */
static void test_all_orders(void **state)
{
    (void)state;
    static const double rows[][7] = {
        { 15, 30, 62.035, 78.509, 0.03566, 0.06073, 0.1035 },
        { 15, 60, 50.278, 27.111, 0.2064, 0.2412, 0.2427 },
        { 15, 75, 33.736, 103.236, 0.01081, 0.02004, 0.03814 },
        { 15, 85, 66.72, 176.514, 0.01498, 0.02433, 0.03593 },
        { 15, 90, 40.692, 106.398, 0.002279, 0.002876, 0.005043 },
        { 15, 93, 62.035, 78.509, 0.0006539, 0.000589, 0.001171 },
        { 15, 95, 31.357, 178.165, 4.67e-05, 3.526e-05, 9.449e-05 },
        { 40, 30, 62.035, 78.509, 0.01935, 0.04186, 0.08828 },
        { 40, 60, 50.278, 27.111, 0.08742, 0.1137, 0.1423 },
        { 40, 75, 33.736, 103.236, 0.007304, 0.01608, 0.03476 },
        { 40, 85, 66.72, 176.514, 0.01587, 0.02675, 0.04021 },
        { 40, 90, 40.692, 106.398, 0.002286, 0.002877, 0.004973 },
        { 40, 93, 62.035, 78.509, 0.0006966, 0.0006202, 0.001198 },
        { 40, 95, 31.357, 178.165, 4.925e-05, 3.593e-05, 9.45e-05 },
        { 300, 30, 62.035, 78.509, 0.01111, 0.03207, 0.0802 },
        { 300, 60, 50.278, 27.111, 0.01199, 0.03272, 0.07656 },
        { 300, 75, 33.736, 103.236, 0.005547, 0.01415, 0.0329 },
        { 300, 85, 66.72, 176.514, 0.01523, 0.0272, 0.04174 },
        { 300, 90, 40.692, 106.398, 0.00254, 0.002963, 0.004932 },
        { 300, 93, 62.035, 78.509, 0.000803, 0.0006232, 0.00121 },
        { 300, 95, 31.357, 178.165, 5.779e-05, 3.679e-05, 9.431e-05 },
    };
    double worst = 0, before = 0, sum = 0;
    static struct pel_atmosphere air;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        const double *q = rows[i];
        if (q[0] != before) {
            const struct pel_atmosphere_desc d = { 1e3 * q[0] };
            pel_atmosphere_finish(&air);
            pel_atmosphere_init(&d, &air);
            assert_int_equal(pel_atmosphere_tabulate(&air, NULL, NULL), PEL_OK);
            before = q[0];
        }
        struct pel_vec3 dir = at_elevation(90 - q[2]);
        dir.y = dir.x * sin(q[3] * PEL_DEG);
        dir.x = dir.x * cos(q[3] * PEL_DEG);
        struct pel_rgb l =
            pel_atmosphere_sky(&air, 2, dir, at_elevation(90 - q[1]));
        const double got[3] = { l.r, l.g, l.b };
        for (int c = 0; c < 3; c++) {
            assert_near(got[c], q[4 + c], 0.045 * q[4 + c]);
            worst = fmax(worst, fabs(got[c] / q[4 + c] - 1));
            sum += got[c] / q[4 + c] - 1;
        }
    }
    pel_atmosphere_finish(&air);
    sum /= 3.0 * sizeof rows / sizeof *rows;
    print_message("all orders within %.4f, mean %+.4f\n", worst, sum);
    assert_near(sum, 0.0, 0.003);
}

/* The table is the same bits however the work is shared. */
static void backwards(void *pool, int count,
                      void (*work)(void *user, int member, int i), void *user)
{
    (void)pool;
    for (int i = count - 1; i >= 0; i--) {
        work(user, i % 3, i);
    }
}

static void test_sharing(void **state)
{
    (void)state;
    scratch = haze;
    assert_int_equal(pel_atmosphere_tabulate(&scratch, backwards, NULL),
                     PEL_OK);
    assert_memory_equal(scratch.airlight, haze.airlight, sizeof *haze.airlight);
    pel_atmosphere_finish(&scratch);
}

/* What is kept is what is made, and the same to all who want it. */
static void test_kept(void **state)
{
    (void)state;
    const struct pel_atmosphere *first = NULL, *second = NULL, *other = NULL;
    assert_int_equal(pel_air_take(HAZE_M, NULL, NULL, &first), PEL_OK);
    assert_memory_equal(first->airlight, haze.airlight, sizeof *haze.airlight);
    assert_int_equal(pel_air_take(FOG_M, NULL, NULL, &other), PEL_OK);
    assert_memory_equal(other->airlight, fog.airlight, sizeof *fog.airlight);
    /* Whoever holds one keeps it whole. */
    assert_memory_equal(first->airlight, haze.airlight, sizeof *haze.airlight);
    pel_air_give(first);
    assert_int_equal(pel_air_take(FOG_M, NULL, NULL, &second), PEL_OK);
    assert_ptr_equal(second, other);
    pel_air_give(other);
    pel_air_give(second);
    assert_int_equal(pel_air_take(HAZE_M, NULL, NULL, &second), PEL_OK);
    assert_ptr_equal(second, first);
    pel_air_give(second);
    /* A third takes the place of the older, once nobody holds that. */
    assert_int_equal(pel_air_take(PEL_CLEAR_VISIBILITY_M, NULL, NULL, &second),
                     PEL_OK);
    assert_memory_equal(second->airlight, clear_air.airlight,
                        sizeof *clear_air.airlight);
    pel_air_give(second);
    assert_int_equal(pel_air_take(HAZE_M, NULL, NULL, &second), PEL_OK);
    assert_ptr_equal(second, first);
    pel_air_give(second);
}

/* --- the whole ----------------------------------------------------------- */

static double illuminance(const struct pel_atmosphere *a, double elevation,
                          double *sky_lx)
{
    struct pel_vec3 s = at_elevation(elevation);
    struct pel_rgb sky = pel_atmosphere_sky_irradiance(a, s);
    struct pel_rgb sun = pel_atmosphere_sun_irradiance(a, 0, s);
    *sky_lx = pel_colour_illuminance(sky, s.z);
    return *sky_lx + fmax(s.z, 0) * pel_colour_illuminance(sun, s.z);
}

static void test_daylight(void **state)
{
    (void)state;
    double sky, all = illuminance(&clear_air, 90, &sky);
    print_message("clear noon: %.0f lx, of them sky %.0f\n", all, sky);
    assert_true(all > 100e3 && all < 130e3);
    assert_true(sky > 5e3 && sky < 15e3);
    all = illuminance(&haze, 90, &sky);
    assert_true(all > 80e3 && all < 125e3 && sky > 15e3);
    all = illuminance(&fog, 90, &sky);
    print_message("fog at noon: %.0f lx, of them sky %.0f\n", all, sky);
    /* Optical depth 1.5, but what it scatters goes on downward: of a layer with
     * the asymmetry 0.84 two streams pass 1 / (1 + 0.75 · 0.16 · 1.5) = 85 %.
     */
    assert_true(all > 90e3 && all < 115e3);
    struct pel_rgb zenith = pel_atmosphere_sky(
        &clear_air, 0, (struct pel_vec3){ 0, 0, 1 }, at_elevation(45));
    assert_true(zenith.b > 1.8 * zenith.g && zenith.g > 1.8 * zenith.r);
}

/* Illuminance on a clear evening: about 1e3 lx at sunset, 3.4 lx at the end
 * of civil twilight, 8e-3 lx of nautical twilight with the night sky
 * (Seidelmann 1992, Explanatory Supplement, sec. 9.34): within a factor of
 * two, no refraction here; and it only ever falls. */
static void test_dusk(void **state)
{
    (void)state;
    double sky, before = INFINITY;
    for (double e = 20; e >= -18; e -= 0.5) {
        double lx = illuminance(&clear_air, e, &sky);
        assert_true(isfinite(lx) && lx >= 0 && lx < before);
        before = lx;
    }
    double sunset = illuminance(&clear_air, -0.3, &sky);
    double civil = illuminance(&clear_air, -6, &sky);
    double nautical = illuminance(&clear_air, -12, &sky);
    print_message("sunset %.0f lx, civil %.2f lx, nautical %.1e lx\n", sunset,
                  civil, nautical);
    assert_true(sunset > 400 && sunset < 1600);
    assert_true(civil > 1.7 && civil < 6.8);
    assert_true(nautical > 2e-3 && nautical < 1.6e-2);
}

/* No more light arrives than came in, reflections of the ground included. */
static void test_energy(void **state)
{
    (void)state;
    const struct pel_atmosphere *airs[] = { &clear_air, &haze, &fog };
    for (int i = 0; i < 3; i++) {
        for (double e = 5; e <= 90; e += 17) {
            struct pel_vec3 s = at_elevation(e);
            struct pel_rgb sky = pel_atmosphere_sky_irradiance(airs[i], s);
            struct pel_rgb sun = pel_atmosphere_sun_irradiance(airs[i], 0, s);
            assert_true(sky.r + s.z * sun.r < s.z * 1.474);
            assert_true(sky.g + s.z * sun.g < s.z * 1.850);
            assert_true(sky.b + s.z * sun.b < s.z * 1.912);
        }
    }
}

static void test_everywhere_finite(void **state)
{
    (void)state;
    const double heights[] = { -50, 0, 4, 1000, 60000, 60001, 4e5, 1e8 };
    for (int i = 0; i < 8; i++) {
        for (double e = -90; e <= 90; e += 15) {
            for (double s = -90; s <= 90; s += 30) {
                struct pel_rgb l = pel_atmosphere_sky(
                    &clear_air, heights[i], at_elevation(e), at_elevation(s));
                assert_true(isfinite(l.r) && l.r >= 0);
                assert_true(isfinite(l.g) && l.g >= 0);
                assert_true(isfinite(l.b) && l.b >= 0);
                l = pel_atmosphere_transmittance(&clear_air, heights[i],
                                                 sin(e * PEL_DEG));
                assert_true(l.r >= 0 && l.r <= 1);
                l = pel_atmosphere_sun_irradiance(&clear_air, heights[i],
                                                  at_elevation(s));
                assert_true(l.b >= 0 && l.b <= 1.912);
            }
        }
    }
}

/* The program's own table is the one that would be made now, to the bit. */
static void the_clear_air_is_as_it_is_made(void **state)
{
    (void)state;
    const struct pel_atmosphere_desc desc = { pel_clear_air.visibility_m };
    const struct pel_atmosphere *kept;
    static struct pel_atmosphere made;
    pel_atmosphere_init(&desc, &made);
    assert_int_equal(pel_atmosphere_tabulate(&made, NULL, NULL), PEL_OK);
    assert_int_equal(
        pel_air_take(pel_clear_air.visibility_m, NULL, NULL, &kept), PEL_OK);
    assert_memory_equal(made.airlight, kept->airlight, sizeof *made.airlight);
    assert_memory_equal(made.columns, kept->columns, sizeof made.columns);
    pel_air_give(kept);
    pel_atmosphere_finish(&made);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_constants),
        cmocka_unit_test(test_visibility),
        cmocka_unit_test(test_phases),
        cmocka_unit_test(test_vertical),
        cmocka_unit_test(test_slant),
        cmocka_unit_test(test_ground_hides),
        cmocka_unit_test(test_sun_disc),
        cmocka_unit_test(test_single_scattering),
        cmocka_unit_test(test_all_orders),
        cmocka_unit_test(test_sharing),
        cmocka_unit_test(test_kept),
        cmocka_unit_test(test_daylight),
        cmocka_unit_test(test_dusk),
        cmocka_unit_test(test_energy),
        cmocka_unit_test(test_everywhere_finite),
        cmocka_unit_test(the_clear_air_is_as_it_is_made),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
