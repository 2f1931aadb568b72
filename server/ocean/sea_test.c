#include "ocean/sea.h"

#include <stdio.h>
#include <string.h>

#include "base/near.h"
#include "ocean/spectrum.h"

static struct pel_sea sea;

static const struct pel_sea_desc base = {
    .kind = PEL_SPECTRUM_PIERSON_MOSKOWITZ,
    .wind_mps = 10,
    .direction_rad = 0.6,
    .fetch_m = 2e5,
    .gamma = 3.3,
    .seed = 1,
    .wave_count = 60,
};

static double uniform(uint64_t *state)
{
    *state = *state * UINT64_C(6364136223846793005) + 1442695040888963407u;
    return (double)(*state >> 11) * 0x1p-53;
}

static double wavelength(const struct pel_wave *w)
{
    return 2 * PEL_PI / hypot(w->kx, w->ky);
}

static void build(const struct pel_sea_desc *d)
{
    assert_int_equal(pel_sea_build(d, &sea), PEL_OK);
}

static struct pel_sea_desc windy(double wind_mps, uint32_t seed)
{
    struct pel_sea_desc d = base;
    d.wind_mps = wind_mps;
    d.seed = seed;
    return d;
}

/* Σ h²/2 equals the spectrum's m0 over the sampled band within 1 %; here by
 * construction, but for what lies outside the band. */
static void test_energy(void **state)
{
    (void)state;
    const int counts[] = { 20, 60, 256 };
    for (double u = 5; u <= 30; u += 5) {
        for (int i = 0; i < 3; i++) {
            struct pel_sea_desc d = windy(u, 7);
            d.wave_count = counts[i];
            d.kind = (enum pel_spectrum_kind)(i % 2);
            build(&d);
            assert_int_equal(sea.count, counts[i]);
            double sum = 0;
            for (int j = 0; j < sea.count; j++) {
                double h = sea.waves[j].amplitude;
                sum += 0.5 * h * h;
            }
            assert_near(sum, sea.m0, 1e-12 * sum);
            double m0 = pel_spectrum_m0(&d, 0, INFINITY);
            assert_near(sea.spectrum_m0, m0, 1e-12 * m0);
            /* Outside the band lie at most 1e-4 of it, from 5 m/s on. */
            assert_near(sea.m0, m0, 2e-4 * m0);
        }
    }
}

/* 4 std of the height over points and moments far apart: 40,000 samples of a
 * normal variable know their standard deviation to 0.35 % (one sigma). */
static void test_significant_height(void **state)
{
    (void)state;
    for (double u = 5; u <= 20; u += 5) {
        struct pel_sea_desc d = windy(u, 3);
        build(&d);
        const int n = 40000;
        uint64_t rng = 11;
        double sum = 0, squares = 0;
        for (int i = 0; i < n; i++) {
            struct pel_surface_sample s;
            double x = 1e5 * uniform(&rng), y = 1e5 * uniform(&rng);
            pel_sea_sample(&sea, x, y, 1e5 * uniform(&rng), &s);
            sum += s.height_m;
            squares += s.height_m * s.height_m;
        }
        double mean = sum / n;
        double hs = 4 * sqrt(squares / n - mean * mean);
        double expected = 4 * sqrt(sea.spectrum_m0);
        print_message("wind %2.0f m/s: Hs %.3f m, spectrum %.3f m\n", u, hs,
                      expected);
        assert_near(hs, expected, 0.02 * expected);
        /* Troughs of trochoids are wider than their crests. */
        double drop = 0;
        for (int i = 0; i < sea.count; i++) {
            const struct pel_wave *w = &sea.waves[i];
            drop += 0.5 * w->chop * hypot(w->kx, w->ky) * w->amplitude *
                    w->amplitude;
        }
        assert_near(mean, -drop, 0.01 * hs);
    }
}

static void test_wavelengths(void **state)
{
    (void)state;
    for (uint32_t seed = 0; seed < 20; seed++) {
        struct pel_sea_desc d = windy(10, seed);
        build(&d);
        double peak = pel_spectrum_peak(&d);
        double longest = 2 * PEL_PI * PEL_GRAVITY / (peak * peak);
        int near_peak = 0;
        for (int i = 0; i < sea.count; i++) {
            double l = wavelength(&sea.waves[i]);
            near_peak += l > longest / 2 && l < longest * 2;
            if (i > 0) {
                double before = wavelength(&sea.waves[i - 1]);
                assert_true(l <= before);
                /* No octave left empty: the filters fade wave by wave. */
                assert_true(before / l < 1.9);
            }
        }
        assert_true(wavelength(&sea.waves[0]) > 1.3 * longest);
        assert_true(wavelength(&sea.waves[sea.count - 1]) < 0.025);
        assert_true(near_peak >= 15);
    }
}

static double turn(double a, double b)
{
    return fabs(remainder(a - b, 2 * PEL_PI));
}

static void test_directions(void **state)
{
    (void)state;
    double closest = 10, next = 10;
    for (uint32_t seed = 0; seed < 20; seed++) {
        struct pel_sea_desc d = windy(12, seed);
        build(&d);
        double along = 0, across = 0, left = 0;
        for (int i = 0; i < sea.count; i++) {
            const struct pel_wave *w = &sea.waves[i];
            double energy = w->amplitude * w->amplitude;
            double angle = atan2(w->ky, w->kx);
            along += energy * cos(angle - base.direction_rad);
            across += energy * sin(angle - base.direction_rad);
            left += sin(angle - base.direction_rad) > 0 ? energy : 0;
            for (int j = i + 1; j < sea.count && j <= i + 4; j++) {
                const struct pel_wave *v = &sea.waves[j];
                double apart = turn(angle, atan2(v->ky, v->kx));
                closest = fmin(closest, apart);
                next = j == i + 1 ? fmin(next, apart) : next;
            }
        }
        assert_true(fabs(atan2(across, along)) < 4 * PEL_DEG);
        assert_near(left / (2 * sea.m0), 0.5, 0.1);
    }
    print_message("neighbours in wavelength differ by at least %.1f deg\n",
                  closest / PEL_DEG);
    assert_true(closest > 4 * PEL_DEG);
    assert_true(next > 15 * PEL_DEG);
}

static void test_same_bits(void **state)
{
    (void)state;
    static struct pel_sea again;
    struct pel_sea_desc d = windy(13, 5);
    d.swell_count = 1;
    d.swell[0] = (struct pel_swell_desc){ 2, 12, 1, 0.2 };
    build(&d);
    assert_int_equal(pel_sea_build(&d, &again), PEL_OK);
    assert_memory_equal(&sea, &again, sizeof sea);
    d.seed = 6;
    assert_int_equal(pel_sea_build(&d, &again), PEL_OK);
    assert_memory_not_equal(sea.waves, again.waves, sizeof sea.waves);
}

static void test_swell(void **state)
{
    (void)state;
    for (int trains = 1; trains <= PEL_SEA_MAX_SWELLS; trains++) {
        struct pel_sea_desc d = windy(trains % 2 ? 0 : 9, 2);
        d.swell_count = trains;
        double expected = pel_spectrum_m0(&d, 0, INFINITY);
        for (int i = 0; i < trains; i++) {
            d.swell[i] = (struct pel_swell_desc){ 1 + i, 8 + i, i, 0.15 };
            expected += (1 + i) * (1 + i) / 16.0;
        }
        build(&d);
        assert_true(sea.count <= d.wave_count);
        assert_near(sea.m0, expected, 2e-4 * expected);
        assert_near(sea.spectrum_m0, expected, 1e-9 * expected);
        for (int i = 1; i < sea.count; i++) {
            assert_true(wavelength(&sea.waves[i]) <=
                        wavelength(&sea.waves[i - 1]));
        }
    }
}

/* The waves of a train stay near its period and spread about its heading. */
static void test_swell_shape(void **state)
{
    (void)state;
    struct pel_sea_desc d = windy(0, 4);
    d.swell_count = 1;
    d.swell[0] = (struct pel_swell_desc){ 3, 11, -2.1, 0.2 };
    build(&d);
    assert_int_equal(sea.count, 16);
    double mean = 0, square = 0;
    for (int i = 0; i < sea.count; i++) {
        const struct pel_wave *w = &sea.waves[i];
        assert_near(2 * PEL_PI / w->omega, 11, 11 * 0.15);
        double a = remainder(atan2(w->ky, w->kx) + 2.1, 2 * PEL_PI);
        mean += a / sea.count;
        square += a * a / sea.count;
    }
    /* Sixteen strata know the mean to a fraction of a stratum. */
    assert_near(mean, 0, 0.05);
    assert_near(sqrt(square), 0.2, 0.04);
}

/* A wave of its own is where it was said to be: a crest at the origin at time
 * 0, a trough half a period later, in deep and in shallow water. */
static void test_single(void **state)
{
    (void)state;
    for (int shallow = 0; shallow < 2; shallow++) {
        struct pel_sea_desc d = windy(0, 1);
        d.depth_m = shallow ? 5 : 0;
        d.single_count = 1;
        d.single[0] = (struct pel_single_desc){ 1.2, 7, 0.5, 0 };
        build(&d);
        assert_int_equal(sea.count, 1);
        assert_near(sea.spectrum_m0, 1.2 * 1.2 / 8, 1e-12);
        assert_near(sea.m0, 1.2 * 1.2 / 8, 1e-12);
        const struct pel_wave *w = &sea.waves[0];
        double k = hypot(w->kx, w->ky), omega = 2 * PEL_PI / 7;
        double gk = PEL_GRAVITY * k * (shallow ? tanh(k * 5) : 1);
        assert_near(gk * (1 + k * k / 370 / 370), omega * omega, 1e-9);
        assert_near(atan2(w->ky, w->kx), 0.5, 1e-12);
        struct pel_surface_sample s;
        pel_sea_sample(&sea, 0, 0, 0, &s);
        assert_near(s.height_m, 0.6, 1e-9);
        pel_sea_sample(&sea, 0, 0, 3.5, &s);
        assert_near(s.height_m, -0.6, 1e-9);
    }
    struct pel_sea_desc d = windy(10, 1);
    d.swell_count = 1;
    d.swell[0] = (struct pel_swell_desc){ 2, 11, 1, 0.2 };
    d.single_count = 1;
    d.single[0] = (struct pel_single_desc){ 1.2, 7, 0.5, 0 };
    build(&d);
    assert_int_equal(sea.count, d.wave_count);
    assert_near(sea.m0, sea.spectrum_m0, 2e-4 * sea.m0);
}

static void test_flat(void **state)
{
    (void)state;
    const double winds[] = { 0, 0.05 };
    for (int i = 0; i < 2; i++) {
        struct pel_sea_desc d = windy(winds[i], 1);
        build(&d);
        assert_int_equal(sea.count, 0);
        struct pel_surface_sample s;
        pel_sea_sample(&sea, 12, -7, 100, &s);
        assert_true(s.height_m == 0 && s.normal.z == 1);
        assert_true(s.velocity_mps.x == 0 && s.velocity_mps.z == 0);
        assert_true(pel_sea_rms_below(&sea, 10) == 0);
    }
}

static void test_rms_below(void **state)
{
    (void)state;
    build(&base);
    assert_near(pel_sea_rms_below(&sea, 1e4), sqrt(sea.m0), 1e-12);
    assert_true(pel_sea_rms_below(&sea, 0.01) == 0);
    double cut =
        0.5 * (wavelength(&sea.waves[40]) + wavelength(&sea.waves[39]));
    double sum = 0;
    for (int i = 40; i < sea.count; i++) {
        sum += 0.5 * sea.waves[i].amplitude * sea.waves[i].amplitude;
    }
    assert_near(pel_sea_rms_below(&sea, cut), sqrt(sum), 1e-12);
}

static void refuse(struct pel_sea_desc d)
{
    memset(&sea, 0x55, sizeof sea);
    static struct pel_sea untouched;
    untouched = sea;
    assert_int_equal(pel_sea_build(&d, &sea), PEL_ERR_OUT_OF_RANGE);
    assert_memory_equal(&sea, &untouched, sizeof sea);
}

static void test_refusals(void **state)
{
    (void)state;
    const double bad[] = { NAN, INFINITY, -1, 1e9 };
    for (int i = 0; i < 4; i++) {
        struct pel_sea_desc d = base;
        d.wind_mps = bad[i];
        refuse(d);
        d = base;
        d.kind = PEL_SPECTRUM_JONSWAP;
        d.fetch_m = bad[i];
        refuse(d);
        d = base;
        d.swell_count = 1;
        d.swell[0] = (struct pel_swell_desc){ bad[i], 10, 0, 0.1 };
        refuse(d);
        d.swell[0] = (struct pel_swell_desc){ 1, bad[i], 0, 0.1 };
        refuse(d);
    }
    struct pel_sea_desc d = base;
    for (int i = 0; i < 4; i++) {
        d = base;
        d.single_count = 1;
        d.single[0] = (struct pel_single_desc){ bad[i], 7, 0, 0 };
        refuse(d);
        d.single[0] = (struct pel_single_desc){ 1, bad[i], 0, 0 };
        refuse(d);
    }
    d = base;
    d.single_count = PEL_SEA_MAX_SINGLES + 1;
    refuse(d);
    d = base;
    d.direction_rad = NAN;
    refuse(d);
    d = base;
    d.wave_count = 257;
    refuse(d);
    d = base;
    d.swell_count = 9;
    refuse(d);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_energy),
        cmocka_unit_test(test_significant_height),
        cmocka_unit_test(test_wavelengths),
        cmocka_unit_test(test_directions),
        cmocka_unit_test(test_same_bits),
        cmocka_unit_test(test_swell),
        cmocka_unit_test(test_swell_shape),
        cmocka_unit_test(test_single),
        cmocka_unit_test(test_flat),
        cmocka_unit_test(test_rms_below),
        cmocka_unit_test(test_refusals),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
