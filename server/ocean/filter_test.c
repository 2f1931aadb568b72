/* What a footprint sees: the mean surface and the variance it leaves out, of
 * both synthesisers. */
#include "ocean/filter.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include <cmocka.h>

#include "ocean/cascade.h"
#include "ocean/directional.h"

static struct pel_sea sea;
static const struct pel_filter filter = PEL_FILTER_DEFAULT;

static void build(enum pel_synthesiser synthesiser, double wind_mps, int waves)
{
    const struct pel_sea_desc desc = {
        .synthesiser = synthesiser,
        .kind = PEL_SPECTRUM_ELFOUHAILY,
        .wind_mps = wind_mps,
        .direction_rad = 0.7,
        .fetch_m = 2e5,
        .gamma = 3.3,
        .seed = 11,
        .wave_count = waves,
    };
    pel_sea_finish(&sea);
    assert_int_equal(pel_sea_build(&desc, &sea), PEL_OK);
}

static double uniform(uint64_t *state)
{
    *state = *state * 6364136223846793005u + 1442695040888963407u;
    return (double)(*state >> 11) * 0x1p-53;
}

static void weights(void **state)
{
    (void)state;
    assert_true(pel_filter_weight(&filter, 1.0) == 0);
    assert_true(pel_filter_weight(&filter, 2.5) == 1);
    assert_float_equal(pel_filter_weight(&filter, 1.75), 0.5, 1e-12);
    assert_float_equal(pel_filter_weight(&filter, 1.375), 0.15625, 1e-12);
}

/* No footprint: the surface itself. A great one: the plane, all left over. */
static void limits(void **state)
{
    (void)state;
    for (int fft = 0; fft < 2; fft++) {
        build(fft ? PEL_SYNTHESISER_FFT : PEL_SYNTHESISER_TROCHOIDS, 9, 256);
        const double none = 1e-6, all = 1e7;
        uint64_t rng = 1;
        for (int i = 0; i < 20; i++) {
            struct pel_vec2 rest = { 1e4 * uniform(&rng), 1e4 * uniform(&rng) };
            struct pel_filtered f;
            assert_int_equal(
                pel_sea_filtered(&sea, &filter, none, &rest, 1, 33, &f),
                PEL_OK);
            struct pel_vec3 d = pel_sea_displace(&sea, rest.x, rest.y, 33);
            struct pel_surface_sample s;
            pel_sea_sample(&sea, rest.x + d.x, rest.y + d.y, 33, &s);
            /* Queries of cascades sum single texels in single precision. */
            assert_float_equal(f.shift.x, d.x, fft ? 2e-6 : 1e-9);
            assert_float_equal(f.shift.y, d.y, fft ? 2e-6 : 1e-9);
            assert_float_equal(f.shift.z, s.height_m, 1e-5);
            /* A query is within 1 µm of its place, where ripples bend by 100/m.
             * The cascades' slopes are interpolated linearly where a query
             * takes the gradient of its spline: 1° rms, worst 4°. */
            assert_float_equal(f.normal.x, s.normal.x, fft ? 0.07 : 2e-4);
            assert_float_equal(f.normal.y, s.normal.y, fft ? 0.07 : 2e-4);
            assert_int_equal(
                pel_sea_filtered(&sea, &filter, all, &rest, 1, 33, &f), PEL_OK);
            assert_float_equal(f.normal.z, 1, 1e-9);
            assert_float_equal(f.shift.z, 0, 1e-3);
            assert_float_equal(f.left.along, sea.slope_variance_along, 1e-6);
            assert_float_equal(f.left.cross, sea.slope_variance_cross, 1e-6);
        }
    }
}

/* What the mean normals show and what is left to the BRDF make the total, also
 * along and across the wind. 24,000 samples of six moments scatter by some
 * percent. */
static void compare_variance(double footprint_m, double tolerance)
{
    enum { POINTS = 4000, MOMENTS = 6 };
    static struct pel_vec2 points[POINTS];
    static struct pel_filtered out[POINTS];
    double along = 0, cross = 0;
    uint64_t rng = 3;
    double c = cos(sea.desc.direction_rad), s = sin(sea.desc.direction_rad);
    for (int m = 0; m < MOMENTS; m++) {
        for (int i = 0; i < POINTS; i++) {
            points[i] =
                (struct pel_vec2){ 1e5 * uniform(&rng), 1e5 * uniform(&rng) };
        }
        assert_int_equal(pel_sea_filtered(&sea, &filter, footprint_m, points,
                                          POINTS, 977.0 * m, out),
                         PEL_OK);
        for (int i = 0; i < POINTS; i++) {
            struct pel_vec3 n = out[i].normal;
            double zx = -n.x / n.z, zy = -n.y / n.z;
            along += pow(zx * c + zy * s, 2) / (POINTS * MOMENTS);
            cross += pow(zy * c - zx * s, 2) / (POINTS * MOMENTS);
        }
    }
    struct pel_slopes left = pel_sea_slopes_left(&sea, &filter, footprint_m);
    double total_along = sea.slope_variance_along;
    double total_cross = sea.slope_variance_cross;
    print_message("%s %6.2f m: along %.5f + %.5f of %.5f, "
                  "cross %.5f + %.5f of %.5f\n",
                  sea.cascades ? "FFT      " : "trochoids", footprint_m, along,
                  left.along, total_along, cross, left.cross, total_cross);
    assert_float_equal(along + left.along, total_along,
                       tolerance * total_along);
    assert_float_equal(cross + left.cross, total_cross,
                       tolerance * total_cross);
}

static void shown_and_left_make_the_total(void **state)
{
    (void)state;
    static const double footprints[] = { 0.1, 0.3, 1, 3, 10 };
    for (int fft = 0; fft < 2; fft++) {
        build(fft ? PEL_SYNTHESISER_FFT : PEL_SYNTHESISER_TROCHOIDS, 8, 256);
        for (size_t i = 0; i < sizeof footprints / sizeof *footprints; i++) {
            compare_variance(footprints[i], 0.06);
        }
    }
}

/* The table of what lies below a wavelength against the spectrum's integral. */
static void below_is_the_spectrums_integral(void **state)
{
    (void)state;
    for (double wind = 4; wind <= 20; wind += 8) {
        build(PEL_SYNTHESISER_FFT, wind, 60);
        struct pel_directional *spectrum;
        assert_int_equal(pel_directional_create(&sea.desc, &spectrum), PEL_OK);
        double worst = 0;
        for (double length = 0.021; length < 1000; length *= 1.23) {
            struct pel_band_moments want;
            pel_directional_moments(spectrum, 2 * PEL_PI / length, INFINITY,
                                    &want);
            struct pel_slopes got = pel_sea_slopes_below(&sea, length);
            worst = fmax(worst, fabs(got.along / want.along - 1));
            worst = fmax(worst, fabs(got.cross / want.cross - 1));
        }
        pel_directional_destroy(spectrum);
        print_message("%g m/s: within %.2f %% of the integral, 2 cm to 1 km\n",
                      wind, 100 * worst);
        assert_true(worst < 0.02);
    }
}

static int tear_down(void **state)
{
    (void)state;
    pel_sea_finish(&sea);
    return 0;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(weights),
        cmocka_unit_test(limits),
        cmocka_unit_test(shown_and_left_make_the_total),
        cmocka_unit_test(below_is_the_spectrums_integral),
    };
    return cmocka_run_group_tests(tests, NULL, tear_down);
}
