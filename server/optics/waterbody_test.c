#include "optics/waterbody.h"

#include <math.h>
#include <string.h>

#include "base/near.h"
#include "base/vec.h"

static struct pel_water_body resolved(struct pel_water_desc desc)
{
    struct pel_water_body body;
    struct pel_fault fault = { 0 };
    desc.depth_m = desc.depth_m > 0.0 ? desc.depth_m : 100.0;
    desc.salinity_g_kg = PEL_SALINITY_USUAL;
    desc.temperature_c = PEL_TEMPERATURE_USUAL;
    assert_int_equal(pel_water_resolve(&desc, &body, &fault), PEL_OK);
    return body;
}

static double backscattering(const struct pel_water_body *w, int i)
{
    struct pel_medium m = pel_water_medium(w, i);
    return m.scattering * (1.0 - pel_medium_forward(&m));
}

/* C = 1 mg/m³ worked by hand from the sources named in seawater.c, at
 * 550 nm; what goes back is kept by either function of the particles. */
static void test_case1(void **state)
{
    (void)state;
    for (double c = 0.01; c <= 30.0; c *= 2.0) {
        struct pel_water_desc desc = { .chlorophyll_mg_m3 = c,
                                       .depth_m = 100.0,
                                       .salinity_g_kg = PEL_SALINITY_USUAL,
                                       .temperature_c = PEL_TEMPERATURE_USUAL };
        struct pel_water_body ff = resolved(desc);
        desc.phase = PEL_PARTICLES_HENYEY_GREENSTEIN;
        struct pel_water_body hg = resolved(desc);
        for (int i = 0; i < 3; i++) {
            struct pel_iop iop =
                pel_water_iop(&desc, pel_water_wavelength_nm[i]);
            assert_near(ff.absorption[i], pel_iop_absorption(&iop), 1e-15);
            assert_near(ff.scattering[i], pel_iop_scattering(&iop), 1e-15);
            assert_near(backscattering(&ff, i), pel_iop_backscattering(&iop),
                        1e-9);
            /* g ends at 0.98, which sends 0.0043 back. */
            if (iop.back > 0.0045) {
                assert_near(backscattering(&hg, i),
                            pel_iop_backscattering(&iop), 1e-9);
            }
            assert_true(ff.back[i] > 0.0 && hg.back[i] == 0.0);
        }
    }
    const struct pel_seawater one = { .chlorophyll_mg_m3 = 1.0,
                                      .salinity_g_kg = 35.0,
                                      .temperature_c = 15.0 };
    struct pel_iop at = pel_seawater_iop(&one, 550.0);
    assert_near(at.water, 0.0565, 1e-12);
    assert_near(at.phytoplankton, 0.00702755, 1e-9);
    /* 0.2 (0.00635 + 0.037824) e^(−1.54), 0.0124 e^(−1.21) */
    assert_near(at.dissolved, 0.0018940, 1e-6);
    assert_near(at.detritus, 0.0036976, 1e-6);
    /* 0.416; 0.002 + 0.01 · 0.5 */
    assert_near(at.particles, 0.416, 1e-12);
    assert_near(at.back, 0.007, 1e-12);
    /* Rows of Pope and Fry, and between them. */
    assert_near(pel_seawater_absorption(440.0), 0.00635, 1e-12);
    assert_near(pel_seawater_absorption(702.5), 0.624, 1e-12);
    assert_near(pel_seawater_absorption(602.5), 0.5 * (0.2224 + 0.2577), 1e-12);
}

/* What is given replaces what chlorophyll would say, and only that. */
static void test_constituents(void **state)
{
    (void)state;
    struct pel_water_desc desc = { .chlorophyll_mg_m3 = 2.0,
                                   .depth_m = 10.0,
                                   .salinity_g_kg = 8.0,
                                   .temperature_c = 12.0 };
    struct pel_iop before = pel_water_iop(&desc, 500.0);
    desc.has_dissolved = desc.has_detritus = desc.has_back = true;
    desc.dissolved_per_m = 0.4;
    desc.dissolved_slope = 0.018;
    desc.detritus_per_m = 0.1;
    desc.back = 0.015;
    struct pel_iop after = pel_water_iop(&desc, 500.0);
    assert_near(after.dissolved, 0.4 * exp(-0.018 * 60.0), 1e-12);
    assert_near(after.detritus, 0.1 * exp(-0.011 * 60.0), 1e-12);
    assert_near(after.back, 0.015, 0.0);
    assert_near(after.phytoplankton, before.phytoplankton, 0.0);
    assert_near(after.particles, before.particles, 0.0);
    desc.has_back = false;
    desc.minerals_g_m3 = 2.0;
    after = pel_water_iop(&desc, 500.0);
    assert_near(after.particles - before.particles, 1.02, 1e-12);
    assert_near(after.back * after.particles,
                before.back * before.particles + 1.02 * 0.02, 1e-12);
    assert_near(after.detritus,
                0.1 * exp(-0.011 * 60.0) + 0.082 * exp(-0.0123 * 57.0), 1e-12);
    struct pel_fault fault;
    struct pel_water_body body;
    desc.dissolved_per_m = -0.1;
    assert_int_equal(pel_water_resolve(&desc, &body, &fault),
                     PEL_ERR_OUT_OF_RANGE);
    assert_string_equal(fault.path, "cdom");
    desc.dissolved_per_m = 0.1;
    desc.has_back = true;
    desc.back = 0.5;
    assert_int_equal(pel_water_resolve(&desc, &body, &fault),
                     PEL_ERR_OUT_OF_RANGE);
    assert_string_equal(fault.path, "backscatterRatio");
}

/* Every kind at other wavelengths: where it is known itself, between, and
 * finite beyond. */
static void test_wavelengths(void **state)
{
    (void)state;
    const struct pel_water_desc kinds[] = {
        { .chlorophyll_mg_m3 = 0.5 },
        { .kind = PEL_WATER_JERLOV, .jerlov = PEL_JERLOV_3C },
        { .kind = PEL_WATER_NAMED, .name = PEL_WATER_HARBOUR },
        { .kind = PEL_WATER_COEFFICIENTS,
          .absorption = { 0.5, 0.06, 0.02 },
          .scattering = { 0.1, 0.2, 0.3 },
          .asymmetry = { 0.8, 0.9, 0.95 } },
    };
    for (int k = 0; k < 4; k++) {
        struct pel_water_desc desc = kinds[k];
        struct pel_water_body body = resolved(desc);
        desc.salinity_g_kg = PEL_SALINITY_USUAL;
        desc.temperature_c = PEL_TEMPERATURE_USUAL;
        for (int i = 0; i < 3; i++) {
            struct pel_medium at =
                pel_water_medium_at(&desc, &body, pel_water_wavelength_nm[i]);
            struct pel_medium known = pel_water_medium(&body, i);
            assert_memory_equal(&at, &known, sizeof at);
        }
        struct pel_medium before = { 0 };
        for (double nm = 400.0; nm <= 700.0; nm += 1.0) {
            struct pel_medium m = pel_water_medium_at(&desc, &body, nm);
            assert_int_equal(pel_medium_check(&m, NULL), PEL_OK);
            if (nm > 400.0) {
                /* No step: red water gains a fifth in 5 nm. */
                assert_near(m.absorption, before.absorption,
                            0.07 * before.absorption);
                assert_near(m.scattering, before.scattering,
                            0.02 * before.scattering);
            }
            before = m;
        }
    }
}

/* Jerlov's K_d comes back from a and b by Kirk's formula, except where pure
 * water as measured since absorbs more; classes follow each other. */
static void test_jerlov(void **state)
{
    (void)state;
    struct pel_water_body before = { 0 };
    for (int t = 0; t < PEL_JERLOV_COUNT; t++) {
        struct pel_water_body w = resolved((struct pel_water_desc){
            .kind = PEL_WATER_JERLOV, .jerlov = (enum pel_jerlov)t });
        for (int i = 0; i < 3; i++) {
            double k = pel_jerlov_attenuation((enum pel_jerlov)t, i);
            double mine =
                pel_kirk_attenuation(w.absorption[i], w.scattering[i]);
            assert_true(mine >= k - 1e-12);
            if (i > 0) {
                assert_near(mine, k, 1e-9 * k);
            }
            assert_true(w.scattering[i] >= before.scattering[i]);
        }
        assert_true(w.back[1] > 0.003 && w.back[1] < 0.019);
        before = w;
    }
    /* √(0.1² + 0.235 · 0.1 · 0.4) */
    assert_near(pel_kirk_attenuation(0.1, 0.4), 0.139284, 1e-6);
    /* Table XXVII as printed, and between 425 and 450 nm. */
    assert_near(pel_jerlov_attenuation(PEL_JERLOV_3C, 1), 0.19, 1e-12);
    assert_near(pel_jerlov_attenuation(PEL_JERLOV_I, 2), 0.0202, 1e-12);
}

static void test_names(void **state)
{
    (void)state;
    struct pel_water_body a = resolved((struct pel_water_desc){
        .kind = PEL_WATER_NAMED, .name = PEL_WATER_BALTIC });
    struct pel_water_body b = resolved((struct pel_water_desc){
        .kind = PEL_WATER_JERLOV, .jerlov = PEL_JERLOV_3C });
    assert_memory_equal(&a, &b, sizeof a);
    struct pel_water_body harbour =
        resolved((struct pel_water_desc){ .kind = PEL_WATER_NAMED,
                                          .name = PEL_WATER_HARBOUR,
                                          .bottom = PEL_BOTTOM_MUD });
    /* b ∝ 1/λ from 1.824 at 514 nm. */
    assert_near(harbour.scattering[1], 1.824 * 514.0 / 550.0, 1e-12);
    assert_near(harbour.back[1], 0.020, 1e-12);
    assert_near(harbour.albedo[0], 0.12, 0.0);
    assert_string_equal(pel_jerlov_word(PEL_JERLOV_9C), "9C");
    assert_string_equal(pel_water_name_word(1), "north-atlantic");
    assert_string_equal(pel_bottom_word(PEL_BOTTOM_CORAL), "coral");
    for (int i = 0; i < PEL_WATER_NAME_COUNT; i++) {
        struct pel_water_body each = resolved((struct pel_water_desc){
            .kind = PEL_WATER_NAMED, .name = (enum pel_water_name)i });
        assert_true(each.absorption[1] > 0.0 && each.scattering[1] > 0.0);
    }
    assert_null(pel_jerlov_word(PEL_JERLOV_COUNT));
    assert_null(pel_water_name_word(-1));
}

static void test_refusals(void **state)
{
    (void)state;
    struct pel_water_desc desc = { .chlorophyll_mg_m3 = 0.3, .depth_m = 10.0 };
    struct pel_water_body body = { .depth_m = -1.0 };
    struct pel_fault fault;
    desc.chlorophyll_mg_m3 = NAN;
    assert_int_equal(pel_water_resolve(&desc, &body, &fault),
                     PEL_ERR_OUT_OF_RANGE);
    assert_string_equal(fault.path, "chlorophyll");
    assert_true(fault.maximum == PEL_CHLOROPHYLL_MAX);
    assert_true(body.depth_m == -1.0);
    desc.chlorophyll_mg_m3 = 0.3;
    desc.depth_m = 0.0;
    assert_int_equal(pel_water_resolve(&desc, &body, &fault),
                     PEL_ERR_OUT_OF_RANGE);
    assert_string_equal(fault.path, "depth");
    desc.depth_m = 10.0;
    desc.salinity_g_kg = 43.0;
    assert_int_equal(pel_water_resolve(&desc, &body, &fault),
                     PEL_ERR_OUT_OF_RANGE);
    assert_string_equal(fault.path, "salinity");
    desc.salinity_g_kg = 0.0;
    desc.temperature_c = -3.0;
    assert_int_equal(pel_water_resolve(&desc, &body, &fault),
                     PEL_ERR_OUT_OF_RANGE);
    assert_string_equal(fault.path, "temperature");
    desc.temperature_c = 0.0;
    desc.bottom = (enum pel_bottom)99;
    assert_int_equal(pel_water_resolve(&desc, &body, NULL), PEL_ERR_INVALID);
    desc.bottom = PEL_BOTTOM_ALBEDO;
    desc.albedo[1] = 1.5;
    assert_int_equal(pel_water_resolve(&desc, &body, &fault),
                     PEL_ERR_OUT_OF_RANGE);
    assert_string_equal(fault.path, "albedo");
    desc.albedo[1] = 0.5;
    desc.kind = PEL_WATER_JERLOV;
    desc.jerlov = (enum pel_jerlov) - 1;
    assert_int_equal(pel_water_resolve(&desc, &body, &fault), PEL_ERR_INVALID);
    desc.kind = PEL_WATER_NAMED;
    desc.name = PEL_WATER_NAME_COUNT;
    assert_int_equal(pel_water_resolve(&desc, &body, &fault), PEL_ERR_INVALID);
    desc.kind = PEL_WATER_COEFFICIENTS;
    assert_int_equal(pel_water_resolve(&desc, &body, &fault),
                     PEL_ERR_OUT_OF_RANGE);
    assert_string_equal(fault.path, "absorption");
}

/* Salt scatters and refracts: Zhang, Hu and He 2009 have 1.30 between pure and
 * ocean water, and are 5 % from Morel 1974's pure water (0.00222 1/m at
 * 500 nm) beyond the 9.3 % that its depolarisation of 0.09 makes; pure water at
 * 20 °C has 1.3330 at the sodium line and sea water at 20 °C and 35 g/kg 1.3394
 * (Austin and Halikas 1976, which the fit holds to 1.5e-4). */
static void test_salt(void **state)
{
    (void)state;
    double fresh = pel_seawater_molecular(500.0, 0.0, 20.0);
    double salt = pel_seawater_molecular(500.0, 35.0, 20.0);
    assert_near(salt / fresh, 1.30, 0.02);
    assert_near(1.093 * fresh, 0.00222, 0.05 * 0.00222);
    /* Falls as λ^−4.32 (Morel 1974); in the red less. */
    double power = log(pel_seawater_molecular(440.0, 35.0, 20.0) /
                       pel_seawater_molecular(680.0, 35.0, 20.0)) /
                   log(440.0 / 680.0);
    assert_near(power, -4.25, 0.07);
    assert_near(pel_water_index(0.0, 20.0, 589.3), 1.3330, 2e-4);
    assert_near(pel_water_index(35.0, 20.0, 589.3), 1.3394, 2e-4);
    struct pel_water_desc lake = { .chlorophyll_mg_m3 = 0.2,
                                   .temperature_c = 20.0,
                                   .depth_m = 10.0 };
    struct pel_water_body body;
    assert_int_equal(pel_water_resolve(&lake, &body, NULL), PEL_OK);
    /* Red refracts less than blue. */
    assert_near(body.index[1], 1.3345, 5e-4);
    assert_true(body.index[0] < body.index[1] - 0.003);
    assert_true(body.index[2] > body.index[1] + 0.003);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_case1),        cmocka_unit_test(test_salt),
        cmocka_unit_test(test_constituents), cmocka_unit_test(test_wavelengths),
        cmocka_unit_test(test_jerlov),       cmocka_unit_test(test_names),
        cmocka_unit_test(test_refusals),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
