/* The ray-traced reference against cases with a known answer. */
#include "sealight.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>

#include <cmocka.h>

#define PI 3.14159265358979323846
#define INDEX 1.34

static struct sea_spectrum spectrum;

static void near(const char *what, double seen, double wanted, double tolerance)
{
    if (!(fabs(seen - wanted) <= tolerance)) {
        fail_msg("%s is %.8g, not %.8g within %.2g", what, seen, wanted,
                 tolerance);
    }
}

/* Closed forms: normal incidence, Brewster's angle (light of one plane of
 * polarisation alone), grazing. Water of 20 degrees without salt has 1.3330
 * at 589 nm (Quan and Fry give four digits for it). */
static void fresnel(void **state)
{
    (void)state;
    double n = INDEX, n2 = n * n;
    near("upright", sea_fresnel(1, n), pow((n - 1) / (n + 1), 2), 1e-12);
    near("Brewster", sea_fresnel(cos(atan(n)), n),
         0.5 * pow((n2 - 1) / (n2 + 1), 2), 1e-12);
    near("grazing", sea_fresnel(0, n), 1, 1e-12);
    near("index", sea_water_index(0, 20, 589), 1.3330, 1e-4);
    near("index of sea water", sea_water_index(35, 20, 589), 1.3396, 2e-4);
}

/* Pierson and Moskowitz in closed form: m0 = alpha V4 / (2.96 g2), and the
 * mean-square slope down to k is alpha/4 E1(0.74 (g / (V2 k))2), with
 * E1(x) = -0.5772 - ln x for small x. The quadrature has 4,000 rings. */
static void pierson_moskowitz(void **state)
{
    (void)state;
    for (double wind = 2; wind < 13; wind += 5) {
        sea_spectrum_init(&spectrum, SEA_PIERSON_MOSKOWITZ, wind, 0, 0.02);
        struct sea_moments m =
            sea_spectrum_moments(&spectrum, spectrum.k_low, spectrum.k_high);
        double v = 1.0625 * wind, g = 9.81;
        double m0 = 0.0081 * pow(v, 4) / (2.96 * g * g);
        double x = 0.74 * pow(g / (v * v * 2 * PI / 0.02), 2);
        double slopes = 0.0081 / 4 * (-0.5772156649 - log(x));
        near("m0", m.m0 / m0, 1, 2e-4);
        near("slopes", (m.along + m.cross) / slopes, 1, 5e-4);
    }
}

/* Far from the peak the exponent is 2, and a half (1 + 1/6) of the slopes'
 * variance runs along the wind: cos^4(angle/2) has the second circular moment
 * s (s - 1) / ((s + 1) (s + 2)) = 1/6. */
static void spreading(void **state)
{
    (void)state;
    sea_spectrum_init(&spectrum, SEA_PIERSON_MOSKOWITZ, 12, 0, 0.02);
    struct sea_moments m =
        sea_spectrum_moments(&spectrum, 2 * PI / 0.1, 2 * PI / 0.03);
    near("along", m.along / (m.along + m.cross), 7.0 / 12, 1e-4);
}

/* Cox and Munk 1954, clean sea: 0.003 + 0.00512 U, +- 0.004; the wind at
 * 12.5 m is 1.02 of that at 10 m. */
static void elfouhaily(void **state)
{
    (void)state;
    for (double wind = 5; wind < 14; wind += 3) {
        sea_spectrum_init(&spectrum, SEA_ELFOUHAILY, wind, 2e6, 0.0028);
        struct sea_moments m =
            sea_spectrum_moments(&spectrum, spectrum.k_low, spectrum.k_high);
        near("slopes", m.along + m.cross, 0.003 + 0.00512 * 1.02 * wind, 0.005);
    }
}

/* What is drawn has the spectrum's slopes: the mean of a realisation scatters
 * by about 1 % (its longest waves are few), its energy by 10 %. */
static void realised(void **state)
{
    (void)state;
    struct sea_random random;
    struct sea_surface surface;
    sea_random_init(&random, 4);
    sea_spectrum_init(&spectrum, SEA_PIERSON_MOSKOWITZ, 7, 0, 0.02);
    struct sea_moments m =
        sea_spectrum_moments(&spectrum, spectrum.k_low, spectrum.k_high);
    sea_surface_init(&surface, &spectrum, 256, 0.7);
    double m0 = 0, along = 0, cross = 0;
    enum { TIMES = 4 };
    for (int i = 0; i < TIMES; i++) {
        sea_surface_fill(&surface, &random);
        m0 += surface.m0 / TIMES;
        along += surface.along / TIMES;
        cross += surface.cross / TIMES;
    }
    near("m0", m0 / m.m0, 1, 0.25);
    near("along", along / m.along, 1, 0.03);
    near("cross", cross / m.cross, 1, 0.03);
    /* Height and gradient are of one surface. */
    for (int i = 0; i < 100; i++) {
        double x = 300 * sea_random_unit(&random), y = x - 77, d = 1e-8;
        double g[2];
        sea_surface_height(&surface, x, y, g);
        double right = sea_surface_height(&surface, x + d, y, 0);
        double left = sea_surface_height(&surface, x - d, y, 0);
        double up = sea_surface_height(&surface, x, y + d, 0);
        double down = sea_surface_height(&surface, x, y - d, 0);
        near("dz/dx", (right - left) / (2 * d), g[0], 2e-4);
        near("dz/dy", (up - down) / (2 * d), g[1], 2e-4);
    }
    sea_surface_finish(&surface);
}

/* The march finds what steps of half a millimetre find, the first place where
 * a ray is under the surface, on a real sea at grazing sight. */
static void no_crest_is_missed(void **state)
{
    (void)state;
    struct sea_random random;
    struct sea_surface surface;
    sea_random_init(&random, 9);
    sea_spectrum_init(&spectrum, SEA_PIERSON_MOSKOWITZ, 2, 0, 0.02);
    sea_surface_init(&surface, &spectrum, 256, 0.2);
    sea_surface_fill(&surface, &random);
    for (int i = 0; i < 400; i++) {
        double zenith = (80 + 8 * sea_random_unit(&random)) * PI / 180;
        double azimuth = 2 * PI * sea_random_unit(&random);
        double d[3] = { sin(zenith) * cos(azimuth), sin(zenith) * sin(azimuth),
                        -cos(zenith) };
        double from[3] = { 100 * sea_random_unit(&random),
                           100 * sea_random_unit(&random), 0.1 };
        struct sea_hit hit;
        if (sea_surface_height(&surface, from[0], from[1], 0) > from[2]) {
            continue;
        }
        assert_int_equal(sea_trace(&surface, from, d, &hit), SEA_HIT);
        double found = (hit.point[2] - from[2]) / d[2], at = 0;
        while (sea_surface_height(&surface, from[0] + at * d[0],
                                  from[1] + at * d[1],
                                  0) < from[2] + at * d[2]) {
            at += 5e-4;
        }
        /* Earlier by a crest thinner than the step is right, too; later is
         * a crest missed. */
        near("hit", found, at, 6e-4);
    }
    sea_surface_finish(&surface);
}

/* A mirror: Fresnel's reflectance itself, nothing blocked, all seen. */
static void flat(void **state)
{
    (void)state;
    struct sea_random random;
    struct sea_surface surface;
    sea_random_init(&random, 1);
    sea_surface_sinusoid(&surface, 0, 1, 1, 128);
    for (double zenith = 0; zenith < 90; zenith += 14.98) {
        struct sea_row row = { zenith * PI / 180, 0.3, 0, 0 };
        struct sea_row_light light;
        sea_row_rays(&surface, INDEX, &row, 0, 0, 10, &random, &light);
        double wanted = sea_fresnel(cos(row.zenith_rad), INDEX);
        near("reflectance", light.fresnel, wanted, 1e-9);
        near("white", light.white, wanted, 1e-9);
        near("area", light.area, 1, 1e-9);
        near("blocked", light.blocked, 0, 0);
    }
    double from[3] = { 1, 2, 3 }, down[3] = { 0.6, 0, -0.8 }, out[3];
    struct sea_hit hit;
    assert_int_equal(sea_trace(&surface, from, down, &hit), SEA_HIT);
    near("x", hit.point[0], 1 + 3 * 0.75, 1e-6);
    near("z", hit.point[2], 0, 1e-6);
    sea_reflect(down, hit.normal, out);
    near("up", out[2], 0.8, 1e-12);
    near("on", out[0], 0.6, 1e-12);
    sea_surface_finish(&surface);
}

/* A sinusoid of steepest slope 0.2 from 40 degrees: all of it is seen and
 * nothing is mirrored twice, so the mean over phases, each with the area that
 * it shows, is a quadrature. Rays: 4 standard errors; the grid's straight
 * pieces, 64 a wave, are less steep by 4e-4. */
static void sinusoid_in_full_sight(void **state)
{
    (void)state;
    enum { RAYS = 20000, PHASES = 10000 };
    struct sea_random random;
    struct sea_surface surface;
    sea_random_init(&random, 2);
    double wavelength = 5, steepest = 0.2;
    sea_surface_sinusoid(&surface, steepest * wavelength / (2 * PI), wavelength,
                         8, 512);
    struct sea_row row = { 40 * PI / 180, 0.5, 0, 0 };
    struct sea_row_light light;
    sea_row_rays(&surface, INDEX, &row, 0, 0, RAYS, &random, &light);
    double v[3] = { -sin(row.zenith_rad) * cos(0.5),
                    -sin(row.zenith_rad) * sin(0.5), cos(row.zenith_rad) };
    double sum = 0, squares = 0;
    for (int i = 0; i < PHASES; i++) {
        double slope = steepest * cos(2 * PI * i / PHASES);
        double shown = -slope * v[0] + v[2];
        double f = sea_fresnel(shown / sqrt(1 + slope * slope), INDEX);
        sum += f * shown / v[2] / PHASES;
        squares += f * f * shown / v[2] / PHASES;
    }
    double error = sqrt((squares - sum * sum) / RAYS);
    near("reflectance", light.fresnel, sum, 4 * error + 2e-4 * sum);
    near("white", light.white, light.fresnel, 1e-12);
    near("area", light.area, 1, 0.01);
    near("closed", light.closed, 1, 1e-9);
    sea_surface_finish(&surface);
}

/* The share of a sinusoid that is seen from 85 degrees, its own crests in
 * front, by a running maximum along the line of sight. */
static void sinusoid_masks_itself(void **state)
{
    (void)state;
    enum { RAYS = 20000, PLACES = 100000 };
    struct sea_random random;
    struct sea_surface surface;
    sea_random_init(&random, 3);
    double wavelength = 5, a = 0.25 * wavelength / (2 * PI);
    sea_surface_sinusoid(&surface, a, wavelength, 8, 512);
    struct sea_row row = { 85 * PI / 180, 0, 0, 0 };
    struct sea_row_light light;
    sea_row_rays(&surface, INDEX, &row, 0, 0, RAYS, &random, &light);
    /* Seen by an eye to the left where no place before it stands above the
     * line of sight: h + x / tan(zenith) exceeds its running maximum. */
    double highest = -1e9, seen = 0, mean = 0, squares = 0;
    for (int i = 0; i < 2 * PLACES; i++) {
        double x = wavelength * i / PLACES;
        double slope = 2 * PI / wavelength * a * cos(2 * PI * x / wavelength);
        double at = a * sin(2 * PI * x / wavelength) + x / tan(row.zenith_rad);
        if (at > highest) {
            highest = at;
            if (i >= PLACES) {
                double shown = 1 + slope * tan(row.zenith_rad);
                double f = sea_fresnel(shown * cos(row.zenith_rad) /
                                           sqrt(1 + slope * slope),
                                       INDEX);
                seen += 1.0 / PLACES;
                mean += f * shown / PLACES;
                squares += f * f * shown / PLACES;
            }
        }
    }
    /* Places seen are weighted by 1 / shown, some thousand where a crest is
     * grazed: 4 % is what this many rays need (2 % seen). */
    near("area", light.area / seen, 1, 0.04);
    double error = sqrt((squares - mean * mean) / RAYS);
    near("reflectance", light.fresnel, mean, 4 * error + 1e-3 * mean);
    near("closed", light.closed, 1, 1e-6);
    sea_surface_finish(&surface);
}

/* From 45 degrees a sea of little wind neither masks nor mirrors itself: what
 * it shows is the quadrature over Gaussian slopes, each with the area that it
 * shows, under a sky that falls with height and away from the Sun. Rays: 4
 * standard errors are 1.5 %. */
static double sky_of(double elevation, double azimuth)
{
    return exp(-2 * elevation) * (1.5 + cos(azimuth));
}

static double gaussian_quadrature(const struct sea_surface *surface,
                                  const double *v)
{
    enum { N = 200 };
    double sum = 0, weights = 0;
    for (int i = 0; i < N * N; i++) {
        int column = i % N, line = i / N;
        double a = 10 * (column + 0.5) / N - 5, b = 10 * (line + 0.5) / N - 5;
        double along = a * sqrt(surface->along),
               cross = b * sqrt(surface->cross);
        double sx = along * surface->wind_x - cross * surface->wind_y;
        double sy = along * surface->wind_y + cross * surface->wind_x;
        double n[3] = { -sx, -sy, 1 }, r[3], d[3] = { -v[0], -v[1], -v[2] };
        double length = sqrt(sea_dot(n, n)), shown = sea_dot(n, v) / v[2];
        for (int k = 0; k < 3; k++) {
            n[k] /= length;
        }
        double weight = exp(-0.5 * (a * a + b * b));
        weights += weight;
        sea_reflect(d, n, r);
        if (shown > 0 && r[2] > 0) {
            sum += weight * shown * sea_fresnel(sea_dot(n, v), INDEX) *
                   sky_of(asin(r[2]), atan2(r[1], r[0]));
        }
    }
    return sum / weights;
}

static void gaussian_sea(void **state)
{
    (void)state;
    enum { RAYS = 15000, TIMES = 3 };
    struct sea_random random;
    struct sea_surface surface;
    struct sea_sky *sky = calloc(1, sizeof(*sky));
    assert_non_null(sky);
    sky->sun[0] = 1;
    for (int i = 0; i < SEA_SKY_ELEVATIONS; i++) {
        double u = (double)i / (SEA_SKY_ELEVATIONS - 1);
        for (int j = 0; j < SEA_SKY_AZIMUTHS; j++) {
            sky->radiance[i][j][1] =
                (float)sky_of(PI / 2 * u * u, PI * j / (SEA_SKY_AZIMUTHS - 1));
        }
    }
    sea_random_init(&random, 8);
    sea_spectrum_init(&spectrum, SEA_PIERSON_MOSKOWITZ, 2, 0, 0.02);
    sea_surface_init(&surface, &spectrum, 256, 0.9);
    for (double azimuth = 0; azimuth < 3; azimuth += 1.3) {
        struct sea_row row = { PI / 4, azimuth, 0, 0 };
        double v[3] = { -sin(PI / 4) * cos(azimuth),
                        -sin(PI / 4) * sin(azimuth), cos(PI / 4) };
        double seen = 0, wanted = 0;
        for (int t = 0; t < TIMES; t++) {
            struct sea_row_light light = { 0 };
            sea_surface_fill(&surface, &random);
            sea_row_rays(&surface, INDEX, &row, sky, 1, RAYS, &random, &light);
            seen += light.sky[0][1] / TIMES;
            wanted += gaussian_quadrature(&surface, v) / TIMES;
        }
        near("sky", seen / wanted, 1, 0.015);
    }
    free(sky);
    sea_surface_finish(&surface);
}

/* One trochoid: over x0 + a cos(k x0) stands a sin(k x0), and its slope is
 * k a cos / (1 - k a sin); the grid has 64 cells a wave. */
static void trochoid(void **state)
{
    (void)state;
    enum { NODES = 512, WAVES = 8 };
    struct sea_surface surface;
    double wavelength = 5, k = 2 * PI / wavelength, a = 0.3 / k;
    sea_surface_sinusoid(&surface, a, wavelength, WAVES, NODES);
    struct sea_level *level = &surface.level[0];
    for (int axis = 0; axis < 2; axis++) {
        level->shift[axis] = calloc((size_t)NODES * NODES, sizeof(float));
        assert_non_null(level->shift[axis]);
    }
    for (int i = 0; i < NODES * NODES; i++) {
        level->shift[0][i] =
            (float)(a * cos(2 * PI * WAVES * (i % NODES) / NODES));
    }
    surface.choppy = 1;
    for (double x0 = 0.02; x0 < wavelength; x0 += 0.13) {
        double g[2], phase = k * x0;
        double z = sea_surface_height(&surface, x0 + a * cos(phase), 1.3, g);
        near("height", z, a * sin(phase), 2e-3 * a);
        near("slope", g[0], 0.3 * cos(phase) / (1 - 0.3 * sin(phase)), 0.03);
        near("across", g[1], 0, 1e-6);
    }
    sea_surface_finish(&surface);
}

/* Crests, not troughs, are sharpened: over places of the map the mean level
 * lies lower by the integral of k S(k), trochoids' own; c falls short of 1
 * for the shortest waves, which have little of it. */
static void chop_lowers_the_mean(void **state)
{
    (void)state;
    enum { PLACES = 40000 };
    struct sea_random random;
    struct sea_surface surface;
    sea_random_init(&random, 6);
    sea_spectrum_init(&spectrum, SEA_PIERSON_MOSKOWITZ, 7, 0, 0.02);
    sea_surface_init(&surface, &spectrum, 256, 0.4);
    sea_surface_chop(&surface, &spectrum);
    sea_surface_fill(&surface, &random);
    double lower = 0, wanted = 0;
    for (int i = 0; i < PLACES; i++) {
        double x = 2000 * sea_random_unit(&random);
        double y = 2000 * sea_random_unit(&random);
        lower += sea_surface_height(&surface, x, y, 0) / PLACES;
        surface.choppy = 0;
        lower -= sea_surface_height(&surface, x, y, 0) / PLACES;
        surface.choppy = 1;
    }
    for (int i = 0; i + 1 < SEA_TABLE; i++) {
        double k = exp(spectrum.log_low + i * spectrum.log_step);
        wanted -= spectrum.elevation[i] * k * k * spectrum.log_step;
    }
    /* One realisation's energy scatters by 10 % and more. */
    near("lower", lower / wanted, 1, 0.3);
    sea_surface_finish(&surface);
}

/* A real sea under a white sky: what is mirrored and what is let through is
 * all there is, but for the last order; and the Sun by rays of the eye is the
 * Sun by its own facets, which at a steep sight is Cox and Munk's
 * E F p / (4 cos n_z4) of a Gaussian sea. */
static void the_sun_twice(void **state)
{
    (void)state;
    enum { RAYS = 30000, FACETS = 1000000, TIMES = 2 };
    struct sea_random random;
    struct sea_surface surface;
    struct sea_facet *facets = calloc(FACETS, sizeof(*facets));
    struct sea_sky *sky = calloc(1, sizeof(*sky));
    assert_true(facets && sky);
    sea_random_init(&random, 5);
    sea_spectrum_init(&spectrum, SEA_PIERSON_MOSKOWITZ, 7, 0, 0.02);
    sea_surface_init(&surface, &spectrum, 256, 0);
    sky->irradiance = 1;
    const double elevation[2] = { 50 * PI / 180, 4 * PI / 180 };
    double by_facets[2] = { 0 }, by_rays[2] = { 0 }, gauss = 0;
    struct sea_row row[2] = { { 30 * PI / 180, 0, 0, 0 },
                              { 85 * PI / 180, 0, 0, 0 } };
    for (int t = 0; t < TIMES; t++) {
        sea_surface_fill(&surface, &random);
        sea_facets(&surface, &random, facets, FACETS);
        for (int i = 0; i < 2; i++) {
            struct sea_row_light light = { 0 };
            sky->sun[0] = cos(elevation[i]);
            sky->sun[2] = sin(elevation[i]);
            sea_row_sun(&surface, INDEX, &row[i], sky, 1, facets, FACETS,
                        &random, &light);
            sea_row_rays(&surface, INDEX, &row[i], sky, 1, RAYS, &random,
                         &light);
            by_facets[i] += light.sun[0] / TIMES;
            by_rays[i] += light.sun_rays[0] / TIMES;
            near("closed", light.closed, 1, 1e-4);
            near("lost", light.lost, 0, 0);
        }
        /* Half-way between zeniths 30 and 40 on opposite sides: 5 degrees. */
        double slope = tan(5 * PI / 180), nz = cos(5 * PI / 180);
        gauss += sea_fresnel(cos(35 * PI / 180), INDEX) *
                 exp(-0.5 * slope * slope / surface.along) /
                 (2 * PI * sqrt(surface.along * surface.cross)) /
                 (4 * cos(30 * PI / 180) * pow(nz, 4)) / TIMES;
    }
    /* Rays: some 1,200 of 60,000 count; places: 10,000 of 2,000,000. Two
     * realisations differ from the Gaussian by their finite long waves. */
    near("rays at 30", by_rays[0] / by_facets[0], 1, 0.12);
    near("rays at 85", by_rays[1] / by_facets[1], 1, 0.12);
    near("Gauss", by_facets[0] / gauss, 1, 0.05);
    free(facets);
    free(sky);
    sea_surface_finish(&surface);
}

/* The same at steep facets, 20 degrees, where n_z^4 is a fifth: eye at 38
 * degrees, Sun at 2 behind it, both on the wind's line. */
static void the_sun_on_steep_facets(void **state)
{
    (void)state;
    enum { FACETS = 1000000, TIMES = 2 };
    struct sea_random random;
    struct sea_surface surface;
    struct sea_facet *facets = calloc(FACETS, sizeof(*facets));
    struct sea_sky *sky = calloc(1, sizeof(*sky));
    assert_true(facets && sky);
    sea_random_init(&random, 7);
    sea_spectrum_init(&spectrum, SEA_ELFOUHAILY, 14, 2e6, 0.0028);
    sea_surface_init(&surface, &spectrum, 512, 0);
    sky->sun[0] = sin(2 * PI / 180);
    sky->sun[2] = cos(2 * PI / 180);
    sky->irradiance = 1;
    struct sea_row row = { 38 * PI / 180, PI, 0, 0 };
    double seen = 0, gauss = 0;
    for (int t = 0; t < TIMES; t++) {
        struct sea_row_light light = { 0 };
        double slope = tan(20 * PI / 180), nz = cos(20 * PI / 180);
        sea_surface_fill(&surface, &random);
        sea_facets(&surface, &random, facets, FACETS);
        sea_row_sun(&surface, INDEX, &row, sky, 1, facets, FACETS, &random,
                    &light);
        seen += light.sun[0];
        gauss += sea_fresnel(cos(18 * PI / 180), INDEX) *
                 exp(-0.5 * slope * slope / surface.along) /
                 (2 * PI * sqrt(surface.along * surface.cross)) /
                 (4 * cos(38 * PI / 180) * pow(nz, 4));
    }
    /* Some 5,000 facets count. */
    near("Gauss", seen / gauss, 1, 0.045);
    free(facets);
    free(sky);
    sea_surface_finish(&surface);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(fresnel),
        cmocka_unit_test(pierson_moskowitz),
        cmocka_unit_test(spreading),
        cmocka_unit_test(elfouhaily),
        cmocka_unit_test(realised),
        cmocka_unit_test(no_crest_is_missed),
        cmocka_unit_test(flat),
        cmocka_unit_test(sinusoid_in_full_sight),
        cmocka_unit_test(sinusoid_masks_itself),
        cmocka_unit_test(gaussian_sea),
        cmocka_unit_test(trochoid),
        cmocka_unit_test(chop_lowers_the_mean),
        cmocka_unit_test(the_sun_twice),
        cmocka_unit_test(the_sun_on_steep_facets),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
