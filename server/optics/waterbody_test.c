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

/* b_b = 2π χ β(140°), χ = 1.08 (Maffione and Dana 1997). */
static double backscattering(const struct pel_water_body *w, int i)
{
    double nu = cos(140.0 * PEL_DEG);
    return 2.0 * PEL_PI * 1.08 * w->scattering[i] *
           pel_hg_phase(nu, w->asymmetry[i]);
}

/* C = 1 mg/m³ worked by hand from the sources named in waterbody.c, at
 * 550 nm, and the backscattering kept by the asymmetry. */
static void test_case1(void **state)
{
    (void)state;
    for (double c = 0.01; c <= 30.0; c *= 2.0) {
        struct pel_water_body w =
            resolved((struct pel_water_desc){ .chlorophyll_mg_m3 = c });
        for (int i = 0; i < 3; i++) {
            struct pel_case1 from = pel_water_case1(c, PEL_SALINITY_USUAL, i);
            assert_near(w.absorption[i], from.absorption, 1e-15);
            assert_near(w.scattering[i], from.scattering, 1e-15);
            assert_near(backscattering(&w, i), from.backscattering, 1e-7);
        }
    }
    struct pel_case1 one = pel_water_case1(1.0, PEL_SALINITY_USUAL, 1);
    /* 0.0565 + 0.0070 + 0.2 (0.00635 + 0.0378) e^(−1.54) */
    assert_near(one.absorption, 0.06539, 1e-5);
    /* 0.00288 (1 + 0.3 35/37) / 1.3 (500/550)^4.32 + 0.30 */
    assert_near(one.scattering, 0.30188, 1e-5);
    /* half of 0.00188, and 0.30 · 0.012 */
    assert_near(one.backscattering, 0.004542, 2e-6);
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
        assert_true(w.asymmetry[1] > 0.7 && w.asymmetry[1] < 0.93);
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
    assert_near(backscattering(&harbour, 1) / harbour.scattering[1], 0.020,
                1e-6);
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

/* Salt scatters and refracts: Morel's 1.30 between pure and ocean water; pure
 * water at 20 °C has 1.3330 at the sodium line and sea water at 20 °C and
 * 35 g/kg 1.3394 (Austin and Halikas 1976, which the fit holds to 1.5e-4). */
static void test_salt(void **state)
{
    (void)state;
    struct pel_case1 fresh = pel_water_case1(0.01, 0.0, 2);
    struct pel_case1 salt = pel_water_case1(0.01, 37.0, 2);
    double particles = 0.30 * pow(0.01, 0.62) * 550.0 / 440.0;
    assert_near((salt.scattering - particles) / (fresh.scattering - particles),
                1.3, 1e-9);
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
        cmocka_unit_test(test_case1),    cmocka_unit_test(test_salt),
        cmocka_unit_test(test_jerlov),   cmocka_unit_test(test_names),
        cmocka_unit_test(test_refusals),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
