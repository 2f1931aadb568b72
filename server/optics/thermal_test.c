/* Heat against other ways to the same numbers: Planck's series, Fresnel in real
 * numbers, facets drawn at random. */
#include "optics/thermal.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "optics/lowlight.h"

static void near(double got, double want, double off)
{
    if (!(fabs(got - want) <= off)) {
        fail_msg("%.9g is not %.9g ± %.2g", got, want, off);
    }
}

/* Share of a black body's light below a wavelength, by its series. */
static double share_below(double um, double kelvin)
{
    double x = 14387.77 / (um * kelvin), sum = 0;
    for (int n = 1; n < 60; n++) {
        sum += exp(-n * x) / n *
               (x * x * x + 3 * x * x / n + 6 * x / (n * n) +
                6.0 / ((double)n * n * n));
    }
    return 15 / pow(PEL_PI, 4) * sum;
}

static void radiance_is_plancks(void **state)
{
    (void)state;
    for (double t = 180; t < 500; t += 20) {
        double want = (share_below(12, t) - share_below(8, t)) * 5.670374e-8 *
                      pow(t, 4) / PEL_PI;
        near(pel_thermal_radiance(t) / want, 1, 2e-6);
        near(pel_thermal_temperature(pel_thermal_radiance(t)), t, 1e-6);
    }
}

/* Born and Wolf, sec. 14.2: reflectance of an absorbing body in real numbers.
 */
static double fresnel(double n, double k, double angle)
{
    double s2 = sin(angle) * sin(angle), c = cos(angle);
    double d = n * n - k * k - s2;
    double a2b2 = sqrt(d * d + 4 * n * n * k * k);
    double a = sqrt(0.5 * (a2b2 + d));
    double rs = (a2b2 - 2 * a * c + c * c) / (a2b2 + 2 * a * c + c * c);
    double t = sin(angle) * tan(angle);
    double rp = rs * (a2b2 - 2 * a * t + t * t) / (a2b2 + 2 * a * t + t * t);
    return 0.5 * (rs + rp);
}

/* Water every micrometre (Hale and Querry 1973) and Planck's weights of 288 K
 * to 1 %, the ends half. */
static double emissivity(double angle)
{
    static const double at[][3] = { { 1.291, 0.0343, 0.5 * 8.25 },
                                    { 1.262, 0.0399, 8.86 },
                                    { 1.218, 0.0508, 9.08 },
                                    { 1.153, 0.0968, 8.97 },
                                    { 1.111, 0.199, 0.5 * 8.63 } };
    double sum = 0, all = 0;
    for (int i = 0; i < 5; i++) {
        sum += at[i][2] * (1 - fresnel(at[i][0], at[i][1], angle));
        all += at[i][2];
    }
    return sum / all;
}

static void level_water_is_fresnels(void **state)
{
    (void)state;
    for (int deg = 0; deg < 88; deg += 3) {
        near(pel_thermal_emissivity(cos(deg * PEL_DEG)),
             emissivity(deg * PEL_DEG), 0.004);
    }
    /* Of 11 µm, at the nadir: 1 - ((n - 1)² + k²) / ((n + 1)² + k²). */
    near(pel_thermal_emissivity(1), 0.990, 0.003);
    near(pel_thermal_emissivity(0), 0, 1e-9);
}

static uint64_t bits;
static double chance(void)
{
    uint64_t z = bits += 0x9E3779B97F4A7C15u;
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
    return ((double)((z ^ (z >> 31)) >> 11) + 0.5) * 0x1p-53;
}

/* Masuda's mean over facets, with Cox and Munk's variances for 0 to 15 m/s. */
static void rough_water_is_its_facets(void **state)
{
    (void)state;
    double level[PEL_THERMAL_LEVELS];
    pel_thermal_level(level);
    for (int wind = 0; wind <= 15; wind += 5) {
        double variance = 0.5 * (0.003 + 0.00512 * wind);
        for (int deg = 0; deg <= 85; deg += 17) {
            double sent = 0, shown = 0;
            for (int i = 0; i < 60000; i++) {
                double r = sqrt(-2 * variance * log(chance())),
                       turn = 2 * PEL_PI * chance();
                double x = r * cos(turn), y = r * sin(turn);
                double faces = cos(deg * PEL_DEG) + x * sin(deg * PEL_DEG);
                if (faces > 0) {
                    double angle =
                        acos(fmin(faces / sqrt(1 + x * x + y * y), 1));
                    sent += faces * emissivity(angle);
                    shown += faces;
                }
            }
            struct pel_thermal_rough got =
                pel_thermal_rough(cos(deg * PEL_DEG), variance, level);
            near(got.emissivity, sent / shown, 0.005);
        }
    }
}

static void sky_is_cold_above_and_air_below(void **state)
{
    (void)state;
    struct pel_thermal_air air = pel_thermal_air(288.15, 0.75, 40000, 0);
    near(pel_thermal_temperature(pel_thermal_sky(&air, 0)), 288.15, 0.1);
    /* Clear zeniths are 40 to 60 K colder than the air. */
    near(pel_thermal_temperature(pel_thermal_sky(&air, 1)), 238, 10);
    struct pel_thermal_air cloudy = pel_thermal_air(288.15, 0.75, 40000, 1);
    near(pel_thermal_temperature(pel_thermal_sky(&cloudy, 1)), 288.15, 1e-3);
    /* 8 to 12 µm go through a kilometre of such air to some 0.86. */
    near(exp(-1000 * air.extinction), 0.87, 0.03);
    struct pel_thermal_air fog = pel_thermal_air(288.15, 1, 300, 0);
    near(fog.extinction, 3.912 / 300, 0.001);
}

static void photons_are_counted(void **state)
{
    (void)state;
    double n[3], twice[3], sum = 0;
    pel_lowlight_photons(0.01, 1.4, n);
    pel_lowlight_photons(0.02, 2.8, twice);
    for (int i = 0; i < 3; i++) {
        near(twice[i] / n[i], 0.5, 1e-12);
    }
    /* A level spectrum, by trapezia of 10 nm. */
    for (int nm = 400; nm <= 900; nm += 10) {
        sum += pel_lowlight_efficiency(nm) * nm * 10e-9 /
               (6.62607015e-34 * 299792458);
    }
    sum *= PEL_PI / 4 * 1e-10 / (1.4 * 1.4) * 0.8 * 0.01;
    near((n[0] + n[1] + n[2]) / sum, 1, 0.003);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(radiance_is_plancks),
        cmocka_unit_test(level_water_is_fresnels),
        cmocka_unit_test(rough_water_is_its_facets),
        cmocka_unit_test(sky_is_cold_above_and_air_below),
        cmocka_unit_test(photons_are_counted),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
