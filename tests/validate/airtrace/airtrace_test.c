/* The Monte Carlo of the air against cases with a known answer. */
#include "airpath.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>

#include <cmocka.h>

#define PI 3.14159265358979323846

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

/* Both densities have the integral 1; the mean cosine of Cornette and Shanks
 * is 3 g (4 + g2) / (5 (2 + g2)) (eq. 9 there); what is drawn has it too. */
static void phases(void **state)
{
    (void)state;
    air_init(&air, 40);
    double sum[2] = { 0 }, mean = 0, drawn = 0, square = 0, g = air.asymmetry;
    enum { STEPS = 100000 };
    for (int i = 0; i < STEPS; i++) {
        double c = -1 + 2 * (i + 0.5) / STEPS, ring = 4 * PI / STEPS;
        sum[0] += ring * air_phase_molecules(&air, c);
        sum[1] += ring * air_phase_aerosols(&air, c);
        mean += ring * c * air_phase_aerosols(&air, c);
        double density, u = (i + 0.5) / STEPS;
        double turned = air_turn_aerosols(&air, u, &density);
        drawn += turned * air_phase_aerosols(&air, turned) / density / STEPS;
        square += pow(air_turn_molecules(&air, u), 2) / STEPS;
    }
    near("molecules", sum[0], 1, 1e-6);
    near("aerosols", sum[1], 1, 1e-4);
    double known = 3 * g * (4 + g * g) / (5 * (2 + g * g));
    near("mean cosine", mean, known, 1e-4);
    near("mean cosine drawn", drawn, known, 1e-4);
    near("mean square drawn", square, 0.4, 1e-4);
}

/* Straight up, the exponentials and the triangle in closed form; the table of
 * the disc against its own quadrature, low Suns and high places too. */
static void depths(void **state)
{
    (void)state;
    static const double clear[] = { 2, 40 };
    double worst = 0;
    for (int v = 0; v < 2; v++) {
        air_init(&air, clear[v]);
        air_sun_init(&sun, &air);
        for (int c = 0; c < AIR_CHANNELS; c++) {
            double known = air.molecules[c] * 8 * (1 - exp(-60.0 / 8)) +
                           air.aerosol_extinction * air.aerosol_height +
                           air.ozone[c] * air.ozone_width;
            near("upright depth", air_depth(&air, c, 0, 1, 200), known,
                 1e-4 * known);
            for (int i = 0; i < 100; i++) {
                double height = 40 * pow((i % 10) / 10.0, 2);
                double low = 0.02 * ((double)(i / 10) - 3);
                double limb = -acos(6360 / (6360 + height));
                double cosine = sin(limb + low);
                double wanted = air_sun_exact(&air, c, height, cosine, 64);
                struct air_sun_place place =
                    air_sun_place(&sun, c, 6360 + height);
                double seen = air_sun_seen(&place, cosine);
                near("sunlight", seen, wanted, 0.01 * wanted + 1e-3);
                worst = fmax(worst, fabs(seen - wanted));
            }
        }
    }
    print_message("sunlight: within %.1e\n", worst);
}

static double deviation(const double *value, int n, double *mean)
{
    double sum = 0, squares = 0;
    for (int i = 0; i < n; i++) {
        sum += value[i];
        squares += value[i] * value[i];
    }
    *mean = sum / n;
    return sqrt(fmax(squares / n - *mean * *mean, 0) / (n - 1));
}

/* The paths' own first order against quadrature: day and dusk, sought turns
 * and others, through haze and through clearer air. */
static void first_order(void **state)
{
    (void)state;
    enum { TIMES = 16, PATHS = 400 };
    air_ground_sea(&ground, 7);
    for (int i = 0; i < 24; i++) {
        if (i % 12 == 0) {
            air_init(&air, i ? 10 : 40);
            air_sun_init(&sun, &air);
        }
        double zenith = 0.05 + 1.5 * (i % 6) / 5.0, azimuth = 0.7 * i;
        struct air_sight sight = {
            .channel = i % 3,
            .height = 0.002,
            .toward = { sin(zenith) * cos(azimuth), sin(zenith) * sin(azimuth),
                        cos(zenith) },
            .suns = 1,
            .zenith = { (i % 12 < 6 ? 40 : 91) * PI / 180 },
            .guided = i % 12 >= 6,
        };
        double once[AIR_SUNS], more[TIMES], light[AIR_SUNS], mean;
        air_once(&scene, &sight, once);
        for (int t = 0; t < TIMES; t++) {
            air_more(&scene, &sight, PATHS, (uint64_t)t, light);
            more[t] = light[0];
            sight.first_order = 1;
            air_more(&scene, &sight, PATHS, (uint64_t)t, light);
            more[t] = light[0] - more[t];
            sight.first_order = 0;
        }
        double error = deviation(more, TIMES, &mean);
        near("first order", mean, once[0], 4 * error + 2e-3 * once[0] + 1e-6);
    }
}

/* Turns and directions that are sought at dusk against those that are not: the
 * same light. Where light comes from above, through haze, and where it comes
 * from the side. */
static void sought(void **state)
{
    (void)state;
    enum { TIMES = 24, PATHS = 1500 };
    static const double rows[][4] = { { 100, 92, 60, 90 },
                                      { 100, 92, 84, 180 },
                                      { 10, 91, 40, 120 } };
    air_ground_sea(&ground, 7);
    for (int i = 0; i < 3; i++) {
        double mean[2], error[2];
        double zenith = rows[i][2] * PI / 180, azimuth = rows[i][3] * PI / 180;
        air_init(&air, rows[i][0]);
        air_sun_init(&sun, &air);
        for (int guided = 0; guided < 2; guided++) {
            struct air_sight sight = {
                .channel = 1,
                .height = 0.002,
                .toward = { sin(zenith) * cos(azimuth),
                            sin(zenith) * sin(azimuth), cos(zenith) },
                .suns = 1,
                .zenith = { rows[i][1] * PI / 180 },
                .guided = guided,
            };
            double more[TIMES], light[AIR_SUNS];
            for (int t = 0; t < TIMES; t++) {
                air_more(&scene, &sight, PATHS, (uint64_t)t, light);
                more[t] = light[0];
            }
            error[guided] = deviation(more, TIMES, &mean[guided]);
        }
        print_message("sought %.4g +- %.2g, else %.4g +- %.2g\n", mean[1],
                      error[1], mean[0], error[0]);
        near("light sought", mean[1], mean[0], 4 * hypot(error[0], error[1]));
        /* Else the comparison would say nothing. */
        assert_true(error[1] < 0.02 * mean[1] && error[0] < 0.06 * mean[0]);
    }
}

/* Chandrasekhar's H function for isotropic scattering (Radiative Transfer,
 * 1950, V sec. 38), by iteration. */
static double chandrasekhar(double albedo, double mu)
{
    enum { NODES = 400 };
    static double h[NODES];
    for (int i = 0; i < NODES; i++) {
        h[i] = 1;
    }
    double value = 1;
    for (int turn = 0; turn < 200; turn++) {
        for (int i = -1; i < NODES; i++) {
            double m = i < 0 ? mu : (i + 0.5) / NODES, sum = 0;
            for (int j = 0; j < NODES; j++) {
                sum += h[j] / (m + (j + 0.5) / NODES) / NODES;
            }
            double x = 1 / (1 - albedo / 2 * m * sum);
            *(i < 0 ? &value : &h[i]) = x;
        }
    }
    return value;
}

/* Deep air over a nearly flat ground that scatters alike in all directions and
 * absorbs a tenth: what comes back upwards is
 * albedo / (4 pi) mu0 / (mu + mu0) H(mu) H(mu0). */
static void deep_air(void **state)
{
    (void)state;
    enum { TIMES = 16, PATHS = 2000 };
    air_init(&air, 300);
    air.ground = 1e6;
    air.top = air.ground + 60;
    air.aerosol_height = air.molecule_height;
    air.molecules[1] = 0.9 * 4;
    air.aerosol_extinction = 0.1 * 4;
    air.aerosol_albedo = 0;
    air.ozone[1] = 0;
    air.isotropic = 1;
    air_tabulate(&air);
    air_sun_init(&sun, &air);
    ground.kind = AIR_BLACK;
    double zenith = 1;
    for (int i = 0; i < 3; i++) {
        double mu = 0.3 + 0.3 * i, mu0 = cos(zenith);
        struct air_sight sight = { .channel = 1,
                                   .height = 60,
                                   .toward = { 0, sqrt(1 - mu * mu), -mu },
                                   .suns = 1,
                                   .zenith = { zenith } };
        double light[AIR_SUNS], once[AIR_SUNS], more[TIMES], mean;
        air_once(&scene, &sight, once);
        for (int t = 0; t < TIMES; t++) {
            air_more(&scene, &sight, PATHS, (uint64_t)t, light);
            more[t] = light[0];
        }
        double error = deviation(more, TIMES, &mean);
        double known = 0.9 / (4 * PI) * mu0 / (mu + mu0) *
                       chandrasekhar(0.9, mu) * chandrasekhar(0.9, mu0);
        print_message("mu %.1f: %.5f, known %.5f\n", mu, once[0] + mean, known);
        near("first order", once[0], 0.9 / (4 * PI) * mu0 / (mu + mu0),
             1e-3 * once[0]);
        near("deep air", once[0] + mean, known, 4 * error + 2e-3 * known);
    }
}

/* Without absorption and over a black ground, light that comes in leaves at
 * the top or ends on the ground; over a white one, all of it leaves. */
static void energy(void **state)
{
    (void)state;
    enum { TIMES = 16, SIGHTS = 200, PATHS = 20 };
    air_init(&air, 20);
    air.ground = 1e6;
    air.top = air.ground + 60;
    air.aerosol_albedo = 1;
    air.ozone[2] = 0;
    air_tabulate(&air);
    air_sun_init(&sun, &air);
    for (int white = 0; white < 2; white++) {
        ground = (struct air_ground){ .kind = white ? AIR_LAMBERT : AIR_BLACK,
                                      .albedo = { 1, 1, 1 } };
        double zenith = 0.8, flux[TIMES], mean;
        for (int t = 0; t < TIMES; t++) {
            struct sea_random random;
            sea_random_init(&random, (uint64_t)t);
            flux[t] = 0;
            for (int i = 0; i < 2 * SIGHTS; i++) {
                double mu = sqrt((i / 2 + sea_random_unit(&random)) / SIGHTS);
                double a = 2 * PI * sea_random_unit(&random);
                double level = sqrt(1 - mu * mu);
                struct air_sight sight = {
                    .channel = 2,
                    .height = i % 2 ? 60 : 0,
                    .toward = { level * cos(a), level * sin(a),
                                i % 2 ? -mu : mu },
                    .suns = 1,
                    .zenith = { zenith },
                };
                if (white && i % 2 == 0) {
                    continue;
                }
                double once[AIR_SUNS], light[AIR_SUNS];
                air_once(&scene, &sight, once);
                uint64_t seed = (uint64_t)t * 2 * SIGHTS + (uint64_t)i;
                air_more(&scene, &sight, PATHS, seed, light);
                flux[t] += PI * (once[0] + light[0]) / SIGHTS;
            }
        }
        double error = deviation(flux, TIMES, &mean);
        double straight =
            cos(zenith) * exp(-air_depth(&air, 2, 0, cos(zenith), 200));
        double sum = mean + (white ? 0 : straight);
        print_message("%s ground: %.4f of %.4f +- %.4f\n",
                      white ? "white" : "black", sum, cos(zenith), error);
        near("energy", sum, cos(zenith), 4 * error + 1e-3);
    }
}

/* The sea: both ways alike; what is drawn has the integral; steep light comes
 * back by Fresnel's law (n = 1.34: 2.1 %), grazing light less than all. */
static void sea(void **state)
{
    (void)state;
    air_ground_sea(&ground, 7);
    near("index", ground.index[1], 1.3413, 5e-4);
    near("upright", air_ground_albedo(&ground, 1, 1) - ground.albedo[1], 0.0213,
         5e-4);
    struct air_vec up = { 0, 0, 1 };
    struct air_vec a = { 0.6, 0, 0.8 }, b = { 0, -0.8, 0.6 };
    near("both ways", air_ground_reflect(&ground, 1, a, b, up),
         air_ground_reflect(&ground, 1, b, a, up), 1e-15);
    for (double mu = 0.05; mu < 1; mu += 0.19) {
        struct air_vec eye = { sqrt(1 - mu * mu), 0, mu };
        struct sea_random random;
        sea_random_init(&random, 5);
        enum { DRAWN = 200000 };
        double sum = 0;
        for (int i = 0; i < DRAWN; i++) {
            double u[3], weight;
            for (int k = 0; k < 3; k++) {
                u[k] = sea_random_unit(&random);
            }
            air_ground_sample(&ground, 1, eye, up, u, &weight);
            sum += weight / DRAWN;
        }
        double whole = air_ground_albedo(&ground, 1, mu);
        print_message("cosine %.2f: albedo %.4f\n", mu, whole);
        near("drawn", sum, whole, 0.015 * whole);
        assert_true(whole < 1);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(phases),      cmocka_unit_test(depths),
        cmocka_unit_test(first_order), cmocka_unit_test(deep_air),
        cmocka_unit_test(energy),      cmocka_unit_test(sea),
        cmocka_unit_test(sought),
    };
    return cmocka_run_group_tests(tests, 0, 0);
}
