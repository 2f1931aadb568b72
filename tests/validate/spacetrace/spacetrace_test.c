/* The Earth from any height against cases with a known answer. */
#include "spacesight.h"
#include "spacewaves.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>

#include <cmocka.h>

#define PI 3.14159265358979323846
#define RADIAN (PI / 180)

enum { MEANS = 16 };

static struct air air;
static struct air_sun sun;
static struct air_ground ground;
static const struct air_scene scene = { &air, &sun, &ground };

static void near(const char *what, double seen, double wanted, double tolerance)
{
    if (!(fabs(seen - wanted) <= tolerance)) {
        fail_msg("%s is %.8g, not %.8g within %.2g", what, seen, wanted,
                 tolerance);
    }
}

struct mean {
    double value, error;
};

static struct mean mean_of(const double *value)
{
    double sum = 0, squares = 0;
    for (int i = 0; i < MEANS; i++) {
        sum += value[i] / MEANS;
        squares += value[i] * value[i] / MEANS;
    }
    return (struct mean){ sum,
                          sqrt(fmax(squares - sum * sum, 0) / (MEANS - 1)) };
}

/* All orders. */
static struct mean look(const struct space_eye *eye, struct air_vec toward,
                        int channel, int paths)
{
    struct air_sight sight;
    double value[MEANS] = { 0 };
    if (space_sight(&air, eye, toward, channel, &sight)) {
        double once[AIR_SUNS], more[AIR_SUNS];
        air_once(&scene, &sight, once);
        for (int i = 0; i < MEANS; i++) {
            air_more(&scene, &sight, paths, 40 + (uint64_t)i, more);
            value[i] = once[0] + more[0];
        }
    }
    return mean_of(value);
}

/* Air that is all but gone. */
static void nothing(double radius)
{
    air_init(&air, 40);
    air.ground = radius;
    air.top = radius + 60;
    for (int c = 0; c < AIR_CHANNELS; c++) {
        air.molecules[c] = 1e-12;
        air.ozone[c] = 0;
    }
    air.aerosol_extinction = 0;
    air_tabulate(&air);
    air_sun_init(&sun, &air);
}

/* Fresnel's equations as sines and tangents of the two angles. */
static double fresnel(double incidence, double index)
{
    double t = asin(sin(incidence) / index);
    double s = sin(incidence - t) / sin(incidence + t);
    double p = tan(incidence - t) / tan(incidence + t);
    return (s * s + p * p) / 2;
}

/* Smith's shadowing, by quadrature of the slopes beyond the ray's: the integral
 * of (x - c) over their density, over c. */
static double smith(double variance, double zenith)
{
    enum { STEPS = 20000 };
    double c = 1 / tan(zenith) / sqrt(variance), sum = 0;
    for (int i = 0; i < STEPS; i++) {
        double x = 10.0 * (i + 0.5) / STEPS;
        sum += x * exp(-(c + x) * (c + x) / 2) / sqrt(2 * PI) * 10.0 / STEPS;
    }
    return sum / c;
}

/* The glint of a sphere without air: where the sight meets it by the law of
 * sines, slopes from the angles there (Cox and Munk 1954). */
static void vacuum(void **state)
{
    (void)state;
    static const double heights[] = { 0.01, 20, 400, 1e4 };
    for (int i = 0; i < 16; i++) {
        if (i % 8 == 0) {
            nothing(i < 8 ? 6360 : 1000);
        }
        air_ground_sea(&ground, 7);
        if (i % 2) {
            ground.variance = 0.03;
            ground.across = 0.012;
            /* In the plane of eye and Sun, so that laying it down is plain. */
            ground.axis = (struct air_vec){ 1, 0, 0 };
        }
        double r = air.ground, h = heights[i / 2 % 4], zenith = 0.6 + 0.03 * i;
        double limb = asin(r / (r + h)), nadir = (i % 3 - 0.6) * 0.6 * limb;
        double there = asin((r + h) / r * sin(fabs(nadir)));
        /* Angles from the eye's vertical in that plane, to the Sun positive. */
        double place = copysign(there - fabs(nadir), nadir);
        double view = -copysign(there, nadir), light = zenith - place;
        double slope = tan((view + light) / 2), turned = (light - view) / 2;
        double v = ground.variance, w = ground.across > 0 ? ground.across : v;
        double wanted = fresnel(fabs(turned), ground.index[1]) /
                        (2 * PI * sqrt(v * w)) * exp(-slope * slope / (2 * v)) /
                        (4 * cos(view) * pow(cos(atan(slope)), 4) *
                         (1 + smith(v, fabs(view)) + smith(v, light)));
        struct space_eye eye = { h, zenith };
        double seen = space_glint(&scene, &eye, space_toward(nadir, 0), 1);
        near("glint", seen, wanted, 1e-4 * wanted + 1e-9);
        /* The rest is the water's, alike to all sides; of light once met. */
        struct air_sight s;
        double once[AIR_SUNS];
        assert_true(space_sight(&air, &eye, space_toward(nadir, 0), 1, &s));
        air_once(&scene, &s, once);
        near("water", once[0] - seen, ground.albedo[1] / PI * cos(light),
             3e-4 * once[0] + 1e-6);
    }
    /* Past the limb there is nothing. */
    struct space_eye eye = { 400, 0.5 };
    near("space", look(&eye, space_toward(100 * RADIAN, 1), 1, 4).value, 0, 0);
    /* Off that plane: the facets' slopes add up to their whole projected area,
     * whatever their variances. */
    struct air_vec up = { 0, 0, 1 };
    double sum = 0;
    enum { GRID = 1500 };
    ground.axis = (struct air_vec){ 0.6, 0.8, 0.3 };
    for (int c = 0; c < AIR_CHANNELS; c++) {
        ground.index[c] = 1e6; /* mirrors all */
    }
    for (int i = 0; i < GRID; i++) {
        double z = (i + 0.5) / GRID;
        for (int k = 0; k < 360; k++) {
            struct air_vec to = { sqrt(1 - z * z) * cos(k * RADIAN),
                                  sqrt(1 - z * z) * sin(k * RADIAN), z };
            sum +=
                z * air_ground_mirror(&ground, 1, up, to, up) / GRID * RADIAN;
        }
    }
    near("upright mirror", sum, 1, 0.005);
    double drawn = 0;
    struct sea_random random;
    sea_random_init(&random, 5);
    enum { DRAWN = 200000 };
    struct air_vec from = { 0.48, -0.36, 0.8 };
    double whole = 0;
    for (int i = 0; i < DRAWN; i++) {
        double u[3], weight;
        for (int k = 0; k < 3; k++) {
            u[k] = sea_random_unit(&random);
        }
        air_ground_sample(&ground, 1, from, up, u, &weight);
        drawn += weight / DRAWN;
    }
    for (int i = 0; i < GRID; i++) {
        double z = (i + 0.5) / GRID;
        for (int k = 0; k < 360; k++) {
            struct air_vec to = { sqrt(1 - z * z) * cos(k * RADIAN),
                                  sqrt(1 - z * z) * sin(k * RADIAN), z };
            whole += z * air_ground_reflect(&ground, 1, from, to, up) / GRID *
                     RADIAN;
        }
    }
    near("drawn", drawn, whole, 0.01 * whole);
}

static const double heights[] = { 0.01, 3, 30, 100, 400, 1e4 };

/* Over black ground, light turned once: a plain sum without tables, in the
 * eye's frame. */
static void once(void **state)
{
    (void)state;
    double worst = 0;
    for (int i = 0; i < 36; i++) {
        air_init(&air, i < 18 ? 40 : 10);
        if (i % 18 >= 12) {
            air.ground = 2000;
            air.top = 2060;
            air_tabulate(&air);
        }
        if (i % 18 == 0 || i % 18 == 12) {
            air_sun_init(&sun, &air);
        }
        ground = (struct air_ground){ .kind = AIR_BLACK };
        double h = heights[i % 6];
        struct space_eye eye = { h, (15 + 25 * (i % 4)) * RADIAN };
        double limb = asin(fmin(1, air.ground / (air.ground + h)));
        double top = asin(fmin(1, air.top / (air.ground + h)));
        /* To the ground, above it, through the limb. */
        double part = 0.1 + 0.85 * (i / 6) / 5.0;
        double nadir = i % 3 ? part * limb : limb + part * (top - limb);
        struct air_vec toward = space_toward(nadir, 0.8 * i);
        struct air_sight s;
        double seen[AIR_SUNS];
        assert_true(space_sight(&air, &eye, toward, i % 3, &s));
        air_once(&scene, &s, seen);
        double wanted = space_once(&air, &eye, toward, i % 3, 2000, 4);
        /* The table of the Sun's light is known to 4e-4; a sum of 2,000 steps
         * through the limb to 0.2 %. */
        near("once", seen[0], wanted, 4e-3 * wanted + 1e-6);
        if (wanted > 1e-4) {
            worst = fmax(worst, fabs(seen[0] / wanted - 1));
        }
    }
    print_message("once: within %.1e\n", worst);
}

/* The glint through the air is what a sea of facets alone adds to black ground:
 * here the Sun by quadrature over its disc, there by its table. */
static void glint(void **state)
{
    (void)state;
    air_init(&air, 20);
    air_sun_init(&sun, &air);
    for (int i = 0; i < 12; i++) {
        double h = heights[i % 6], limb = asin(air.ground / (air.ground + h));
        struct space_eye eye = { h, (15 + 20 * (i % 4)) * RADIAN };
        struct air_vec toward = space_toward(limb * (0.2 + 0.06 * i), 0.3 * i);
        struct air_sight s;
        double bare[AIR_SUNS], whole[AIR_SUNS];
        assert_true(space_sight(&air, &eye, toward, i % 3, &s));
        ground = (struct air_ground){ .kind = AIR_BLACK };
        air_once(&scene, &s, bare);
        air_ground_sea(&ground, 12);
        for (int c = 0; c < AIR_CHANNELS; c++) {
            ground.albedo[c] = 0;
        }
        air_once(&scene, &s, whole);
        near("glint through air", space_glint(&scene, &eye, toward, i % 3),
             whole[0] - bare[0], 4e-3 * (whole[0] - bare[0]) + 1e-9);
    }
}

/* Without a surface an eye in the air sees what airtrace's sees, whose frame is
 * the eye's; one above it sees the same along the same line. */
static void airs(void **state)
{
    (void)state;
    air_init(&air, 40);
    air_sun_init(&sun, &air);
    ground = (struct air_ground){ .kind = AIR_BLACK };
    struct space_eye eye = { 0.01, 0.7 };
    struct air_vec toward = space_toward(100 * RADIAN, 0.9);
    struct air_sight sight = { .channel = 2,
                               .height = 0.01,
                               .toward = toward,
                               .suns = 1,
                               .zenith = { 0.7 } };
    double a[MEANS], light[AIR_SUNS], first[AIR_SUNS];
    air_once(&scene, &sight, first);
    for (int i = 0; i < MEANS; i++) {
        air_more(&scene, &sight, 500, 40 + (uint64_t)i, light);
        a[i] = first[0] + light[0];
    }
    struct mean wanted = mean_of(a), seen = look(&eye, toward, 2, 500);
    near("airtrace", seen.value, wanted.value, 1e-9);
    /* 400 km and 10,000 km away on one line. */
    struct space_eye far = { 1e4, 0.7 };
    toward = space_toward(20 * RADIAN, 0.9);
    struct mean there = look(&far, toward, 2, 500);
    double r = air.ground + 1e4, s = r * cos(20 * RADIAN);
    double low = air.ground + 400;
    double t = s - sqrt(s * s - r * r + low * low);
    struct air_vec p = { t * toward.x, t * toward.y, r + t * toward.z };
    struct air_vec up = { p.x / low, p.y / low, p.z / low };
    struct air_vec to_sun = { sin(0.7), 0, cos(0.7) };
    struct space_eye closer = { 400, acos(air_dot(up, to_sun)) };
    /* Its own nadir angle and azimuth. */
    double nadir = acos(-air_dot(toward, up));
    struct air_vec level = air_along(toward, cos(nadir), up);
    struct air_vec sunward = air_along(to_sun, -air_dot(to_sun, up), up);
    double azimuth =
        acos(air_dot(level, sunward) / (sin(nadir) * sin(closer.sun_zenith)));
    struct mean here = look(&closer, space_toward(nadir, azimuth), 2, 500);
    near("one line", here.value, there.value,
         4 * hypot(here.error, there.error));
    assert_true(there.error < 0.01 * there.value);
}

/* A white planet below air that absorbs nothing sends back all light that it
 * takes out of the Sun's beam: what meets the ground's disc and what the air
 * about it turns aside. A small planet, so that its round counts. */
static void energy(void **state)
{
    (void)state;
    enum { SIGHTS = 6000, PATHS = 8, RINGS = 2000 };
    air_init(&air, 40);
    air.ground = 1000;
    air.top = 1060;
    air.aerosol_albedo = 1;
    air.ozone[2] = 0;
    air_tabulate(&air);
    air_sun_init(&sun, &air);
    ground = (struct air_ground){ .kind = AIR_LAMBERT, .albedo = { 1, 1, 1 } };
    double taken = PI * air.ground * air.ground;
    for (int i = 0; i < RINGS; i++) {
        double b = air.ground + 60 * (i + 0.5) / RINGS;
        /* Its lowest place, there and back. */
        double depth = 2 * air_depth(&air, 2, b - air.ground, 0, 200);
        taken += 2 * PI * b * 60 / RINGS * -expm1(-depth);
    }
    double flux[MEANS];
    for (int k = 0; k < MEANS; k++) {
        struct sea_random random;
        sea_random_init(&random, (uint64_t)k);
        flux[k] = 0;
        for (int i = 0; i < SIGHTS; i++) {
            double cosine = -1 + 2 * (i + sea_random_unit(&random)) / SIGHTS;
            double mu = sqrt(sea_random_unit(&random));
            double azimuth = 2 * PI * sea_random_unit(&random);
            struct space_eye eye = { 60, acos(cosine) };
            struct air_sight s;
            if (!space_sight(&air, &eye, space_toward(acos(mu), azimuth), 2,
                             &s)) {
                continue;
            }
            double first[AIR_SUNS], more[AIR_SUNS];
            air_once(&scene, &s, first);
            air_more(&scene, &s, PATHS, (uint64_t)k * SIGHTS + (uint64_t)i,
                     more);
            flux[k] += (first[0] + more[0]) / SIGHTS;
        }
        flux[k] *= 4 * PI * air.top * air.top * PI;
    }
    struct mean seen = mean_of(flux);
    print_message("planetary albedo: %.4f +- %.4f\n", seen.value / taken,
                  seen.error / taken);
    near("energy", seen.value, taken, 4 * seen.error + 2e-3 * taken);
    assert_true(seen.error < 0.006 * taken);
}

enum { RAYS = 20000 };

static struct air_escape escapes[RAYS];

/* The same sight over the ground's mean and over realised waves. */
static void compare(const struct space_waves *waves, double nadir,
                    struct mean seen[2], struct air_first *first, double *rough)
{
    struct space_eye eye = { 0.02, 0.9 };
    struct air_vec toward = space_toward(nadir, 2), up = { 0, 0, 1 };
    struct air_vec to_sun = { sin(0.9), 0, cos(0.9) };
    struct air_sight s;
    assert_true(space_sight(&air, &eye, toward, 1, &s));
    *first =
        space_waves_first(waves, s.toward, up, to_sun, 3, escapes, RAYS, rough);
    for (int k = 0; k < 2; k++) {
        double value[MEANS], once[AIR_SUNS], more[AIR_SUNS];
        s.first = k ? first : NULL;
        air_once(&scene, &s, once);
        for (int i = 0; i < MEANS; i++) {
            air_more(&scene, &s, 2000, 70 + (uint64_t)i, more);
            value[i] = once[0] + more[0];
        }
        seen[k] = mean_of(value);
    }
}

/* Waves that are all but level mirror as Fresnel has it; what is neither
 * mirrored nor out of the water is nothing; a mirror sends all light back.
 * Straight down, where waves hide nothing, they show what facets of their
 * slopes do; at a slant they send more, by what they mirror twice. */
static void waves(void **state)
{
    (void)state;
    struct space_waves sea;
    struct air_vec up = { 0, 0, 1 };
    air_init(&air, 40);
    air_sun_init(&sun, &air);
    air_ground_sea(&ground, 7);
    ground.across = 1e-7;
    ground.variance = 2e-7;
    ground.axis = (struct air_vec){ 0.6, 0.8, 0 };
    space_waves_init(&sea, &ground, 7, 8, 4);
    struct space_white level =
        space_waves_white(&sea, space_toward(60 * RADIAN, 1), up, 400, 5);
    near("level", level.mirrored, fresnel(60 * RADIAN, ground.index[1]), 1e-4);
    near("level, all", level.mirrored + level.water, 1, 1e-9);
    space_waves_finish(&sea);

    ground.variance = 0.022;
    ground.across = 0.015;
    space_waves_init(&sea, &ground, 7, 60, 4);
    struct space_white steep =
        space_waves_white(&sea, space_toward(76 * RADIAN, 0), up, RAYS, 5);
    print_message("mirrored at 76 degrees: %.4f, of it once %.4f\n",
                  steep.mirrored, steep.once);
    near("all", steep.mirrored + steep.water, 1, 1e-9);
    /* Smith's, whose heights and slopes have nothing to do with each other,
     * is within 2 %; twice and more is a tenth of it (seatrace: 0.097). */
    near("once", steep.once,
         air_ground_albedo(&ground, 1, cos(76 * RADIAN)) - ground.albedo[1],
         0.04 * steep.once);
    near("twice", steep.mirrored / steep.once, 1.1, 0.03);
    for (int c = 0; c < AIR_CHANNELS; c++) {
        ground.index[c] = 1e9;
    }
    near("mirror",
         space_waves_white(&sea, space_toward(76 * RADIAN, 0), up, 4000, 5)
             .mirrored,
         1, 1e-6);
    air_ground_sea(&ground, 7);
    ground.variance = 0.022;
    ground.across = 0.015;
    ground.axis = (struct air_vec){ 0.6, 0.8, 0 };

    struct mean seen[2];
    struct air_first first;
    double rough;
    const double nadir[] = { 20 * RADIAN, 76 * RADIAN };
    for (int i = 0; i < 2; i++) {
        double kept = ground.albedo[1];
        ground.albedo[1] = 0;
        compare(&sea, nadir[i], seen, &first, &rough);
        ground.albedo[1] = kept;
        double noise =
            hypot(hypot(seen[0].error, seen[1].error), rough * seen[1].value);
        print_message("%.0f degrees: %.4g and %.4g +- %.2g, water %.3f\n",
                      nadir[i] / RADIAN, seen[0].value, seen[1].value, noise,
                      first.leaves[1]);
        if (i == 0) {
            near("steep", seen[1].value, seen[0].value, 4 * noise);
            near("water", first.leaves[1], 0.979 / 0.934, 0.004);
        } else {
            assert_true(seen[1].value > seen[0].value + 8 * noise);
            assert_true(first.leaves[1] < 0.93);
        }
    }
    space_waves_finish(&sea);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(vacuum), cmocka_unit_test(once),
        cmocka_unit_test(glint),  cmocka_unit_test(airs),
        cmocka_unit_test(energy), cmocka_unit_test(waves),
    };
    return cmocka_run_group_tests(tests, 0, 0);
}
