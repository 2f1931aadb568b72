#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

#include "base/vec.h"
#include "optics/brdf.h"
#include "optics/ordinates.h"
#include "optics/raman.h"
#include "optics/waterkernel.h"
#include "optics/waterreport.h"

static void wavelengths_and_strength(void **state)
{
    (void)state;
    /* 488 nm becomes 585 (Bartlett et al. 1998; Ge, Gordon and Voss 1993). */
    assert_true(fabs(pel_raman_excitation_nm(585.0) - 488.0) < 0.5);
    assert_true(fabs(pel_raman_scattering(488.0) - 2.7e-4) < 1e-9);
    assert_true(fabs(pel_raman_scattering(400.0) / 2.7e-4 -
                     pow(488.0 / 400.0, 5.5)) < 1e-9);
    /* A band of wavenumbers, 100 of them wide, and how wide it is in nm. */
    double red = 680.0, blue = pel_raman_excitation_nm(red);
    double wide = 1.0 / (1.0 / red - 100e-7) - red;
    double narrow = 1.0 / (1.0 / blue - 100e-7) - blue;
    double without_sun = pel_raman_scattering(blue) * narrow / wide;
    assert_true(fabs(pel_raman_strength(red) / without_sun / (1.86 / 1.51) -
                     1.0) < 0.03);
}

/* Nothing else scatters: ∫ b_R p e^(−a' z/μ_s − a z/μ_v) dz / μ_v. */
static void lone_scattering(void **state)
{
    (void)state;
    struct pel_ordinates *o = pel_ordinates_create(16, 1e-6);
    assert_non_null(o);
    const struct pel_medium red = { .absorption = 0.4, .molecular = 1.0 };
    const struct pel_raman raman = {
        .strength = 2e-4, .from = { .absorption = 0.06, .molecular = 1.0 }
    };
    const double mu[2] = { 0.95, 0.7 }, view[2] = { 1.0, 0.75 };
    const double depths[2] = { 3.0, 2000.0 };
    double out[2 * PEL_RAMAN_MODES * 4];
    assert_int_equal(
        pel_raman_respond(o, &red, &raman, depths, 2, mu, 2, view, 2, out),
        PEL_OK);
    for (int i = 0; i < 2 * 4 * 5; i++) {
        int k = i / 20, b = i / 10 % 2, v = i / 5 % 2;
        double azimuth = i % 5 * 45 * PEL_DEG, found = 0.0;
        for (int m = 0; m < PEL_RAMAN_MODES; m++) {
            found += out[(k * PEL_RAMAN_MODES + m) * 4 + b * 2 + v] *
                     cos(m * azimuth);
        }
        double c = -mu[b] * view[v] + sqrt(1.0 - mu[b] * mu[b]) *
                                          sqrt(1.0 - view[v] * view[v]) *
                                          cos(azimuth);
        double rate = 0.06 / mu[b] + 0.4 / view[v];
        double want = 2e-4 * (1.0 + 0.55 * c * c) / (1.0 + 0.55 / 3.0) /
                      (4.0 * PEL_PI) * -expm1(-rate * depths[k]) /
                      (rate * view[v]);
        assert_true(fabs(found / want - 1.0) < 1e-4);
    }
    pel_ordinates_destroy(o);
}

/* What is absorbed between two depths is what the net flux loses. */
static void scalar_irradiance(void **state)
{
    (void)state;
    struct pel_ordinates *o = pel_ordinates_create(24, 1e-7);
    assert_non_null(o);
    const struct pel_medium m = { .absorption = 0.08,
                                  .scattering = 0.4,
                                  .back = 0.015,
                                  .molecular = 0.1,
                                  .albedo = 0.4,
                                  .depth_m = 12.0 };
    struct pel_geometry sun = { .sun_zenith_rad = 50 * PEL_DEG };
    struct pel_interface face = pel_interface_at(&sun);
    for (double z = 0.5; z < 12.0; z += 2.5) {
        double around[2] = { z - 0.05, z + 0.05 }, moment[PEL_MOMENTS];
        struct pel_field f[2];
        pel_ordinates_field(o, &m, sun.sun_zenith_rad, around, 2, f);
        assert_int_equal(
            pel_ordinates_moments(o, &m, &face.sun_mu, 1, &z, 1, moment),
            PEL_OK);
        double lost =
            ((f[0].down - f[0].up) - (f[1].down - f[1].up)) / (0.1 * 0.08);
        assert_true(fabs(face.beam * moment[0] / lost - 1.0) < 1e-4);
    }
    pel_ordinates_destroy(o);
}

/* Clear water: about a fifth of the green, less of the blue (Westberry, Boss
 * and Lee 2013, fig. 4; Gordon 1999); turbid water: next to nothing. */
static void share_by_water(void **state)
{
    (void)state;
    const struct pel_geometry at = { 30 * PEL_DEG, 0, 0 };
    const struct {
        double chlorophyll, nm, least, most;
    } known[] = { { 0.03, 440, 0.05, 0.10 },
                  { 0.03, 550, 0.10, 0.25 },
                  { 0.03, 670, 0.12, 0.35 },
                  { 5.0, 550, 0.0, 0.03 } };
    for (int i = 0; i < 4; i++) {
        struct pel_water_desc desc = { .chlorophyll_mg_m3 =
                                           known[i].chlorophyll,
                                       .salinity_g_kg = 35,
                                       .temperature_c = 15,
                                       .depth_m = 1000,
                                       .raman = true };
        struct pel_water_body body;
        struct pel_water_report r, without;
        assert_int_equal(pel_water_resolve(&desc, &body, NULL), PEL_OK);
        assert_int_equal(pel_water_report(&desc, &body, known[i].nm, &at,
                                          PEL_ORDERS_ALL, &r),
                         PEL_OK);
        desc.raman = false;
        assert_int_equal(pel_water_report(&desc, &body, known[i].nm, &at,
                                          PEL_ORDERS_ALL, &without),
                         PEL_OK);
        double share = r.raman / (r.raman + r.leaving.total);
        print_message("%g mg/m3, %g nm: %.3f of what leaves; R %+.1f %%\n",
                      known[i].chlorophyll, known[i].nm, share,
                      100 * (r.reflectance / without.reflectance - 1.0));
        assert_true(share > known[i].least && share < known[i].most);
        assert_true(without.raman == 0.0 && r.rrs > without.rrs);
    }
}

/* The kernel that colours pictures holds the same. */
static void kernel_has_it(void **state)
{
    (void)state;
    static struct pel_water_kernel with, without;
    const struct pel_water_depths depths = { .levels = 1, .first_m = 20 };
    struct pel_water_desc desc = { .chlorophyll_mg_m3 = 0.1,
                                   .salinity_g_kg = 35,
                                   .temperature_c = 15,
                                   .depth_m = 20,
                                   .bottom = PEL_BOTTOM_SAND,
                                   .raman = true };
    struct pel_water_body body, plain;
    assert_int_equal(pel_water_resolve(&desc, &body, NULL), PEL_OK);
    assert_int_equal(
        pel_water_kernel_build(&body, &depths, PEL_ORDERS_ALL, &with), PEL_OK);
    plain = body;
    memset(plain.raman, 0, sizeof plain.raman);
    assert_int_equal(
        pel_water_kernel_build(&plain, &depths, PEL_ORDERS_ALL, &without),
        PEL_OK);
    for (int i = 0; i < 27; i++) {
        int b = 2 + i / 9 * 4, v = i / 3 % 3 * 4, wavelength = i % 3;
        const struct pel_geometry at = {
            asin(PEL_WATER_INDEX * pel_kernel_sine(b)),
            asin(PEL_WATER_INDEX * pel_kernel_sine(v)), 0.7
        };
        struct pel_interface face = pel_interface_at(&at);
        struct pel_water_report r;
        assert_int_equal(pel_water_report(&desc, &body,
                                          pel_water_wavelength_nm[wavelength],
                                          &at, PEL_ORDERS_ALL, &r),
                         PEL_OK);
        double more = 0.0;
        for (int m = 0; m < PEL_RAMAN_MODES; m++) {
            more +=
                ((double)with.response[PEL_KERNEL_BEYOND][m][b][v][wavelength] -
                 (double)
                     without.response[PEL_KERNEL_BEYOND][m][b][v][wavelength]) *
                cos(m * at.azimuth_rad);
        }
        double want = r.raman / (face.leaving * face.beam) * PEL_KERNEL_LEAVING;
        assert_true(fabs(more - want) < 2e-3 * want);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(wavelengths_and_strength),
        cmocka_unit_test(lone_scattering),
        cmocka_unit_test(scalar_irradiance),
        cmocka_unit_test(share_by_water),
        cmocka_unit_test(kernel_has_it),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
