/* A front that passes: from an old swell under light wind over a rising and
 * veering wind to its own sea. The sea has the field's height, and no step of
 * it is seen. */
#include "scene/weathersea.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

/* after those */
#include <cmocka.h>

#include "base/vec.h"
#include "ocean/sea.h"
#include "scene/weatherlead.h"

/* The field at hour h: what a service could have. */
static void front(double h, bool parts, struct pel_weather_now *out)
{
    double f = 0.5 + 0.5 * tanh((h - 6) / 1.5); /* the front */
    double wind = 4 + 11 * f, from = 200 + 95 * f;
    double grown = 0.2 + 2.6 * pow(fmax(0.5 + 0.5 * tanh((h - 8) / 3), 0), 1.5);
    double to = (270 - from) * PEL_DEG;
    *out = (struct pel_weather_now){
        .wind_known = true,
        .waves_known = true,
        .wind_east_mps = wind * cos(to),
        .wind_north_mps = wind * sin(to),
        .height_m = hypot(1.9, grown),
        .period_s = 11.5 - 3 * f + 0.3 * sin(h),
        .direction_rad = (270 - (215 + 60 * f)) * PEL_DEG,
        .agreement = 1 - 0.1 * f * (1 - f),
        .parts = parts,
        .wind_height_m = grown,
        .swell_period_s = 12 - 0.1 * h,
        .swell_direction_rad = (270 - 210 - 2 * h) * PEL_DEG,
        .swell_agreement = 1,
    };
}

static void describe(const struct pel_weather_sea *s,
                     const struct pel_growth_law *law, struct pel_sea_desc *out)
{
    *out = (struct pel_sea_desc){
        .synthesiser = PEL_SYNTHESISER_FFT,
        .kind = law->kind,
        .gamma = law->gamma,
        .wind_mps = s->wind_mps,
        .direction_rad = (270 - s->wind_from_deg) * PEL_DEG,
        .fetch_m = s->fetch_m,
        .seed = 7,
        .wave_count = 60,
        .whitecaps = 1,
        .steady = true,
        .swell_count = 1,
        .swell = { { s->swell_height_m, s->swell_period_s,
                     (270 - s->swell_from_deg) * PEL_DEG,
                     s->swell_spread_deg * PEL_DEG } },
    };
}

#define PLACES 400

struct seen {
    double height_m, at[PLACES];
};

static void see(const struct pel_sea_desc *desc, double time_s,
                struct seen *out)
{
    static struct pel_surface_sample samples[PLACES];
    struct pel_vec2 places[PLACES];
    struct pel_sea *sea = calloc(1, sizeof *sea);
    assert_non_null(sea);
    assert_int_equal(pel_sea_build(desc, sea), PEL_OK);
    for (int i = 0; i < PLACES; i++) {
        places[i] =
            (struct pel_vec2){ 37.7 * (i % 20) - 300, 41.3 * (i / 20) - 500 };
    }
    pel_sea_query(sea, places, PLACES, time_s, samples);
    for (int i = 0; i < PLACES; i++) {
        out->at[i] = samples[i].height_m;
    }
    out->height_m = 4 * sqrt(sea->m0);
    pel_sea_finish(sea);
    free(sea);
}

/* The next sea as weatherlead.c would find it, in steps of `step_h` from *h. */
static bool next_sea(double *h, double step_h, bool parts,
                     const struct pel_growth_law *law,
                     struct pel_weather_sea *sea)
{
    struct pel_weather_sea to;
    struct pel_weather_now now;
    for (double until = *h + 3; *h < until;) {
        *h += step_h;
        front(*h, parts, &now);
        pel_weather_sea_of(&now, law, 0, &to);
        if (pel_weather_sea_moves(sea, &to, law) >= PEL_WEATHER_MOVES_M) {
            *sea = to;
            return true;
        }
    }
    return false;
}

/* After 12 days of simulated time, when the least change of a frequency would
 * have turned every phase. The steps are those of a second: what is over the
 * bound of one is what a second brings. */
static void test_front(void **state)
{
    (void)state;
    const double time_s = 1e6;
    struct pel_growth_law law;
    double largest = 0, worst_rms = 0, off = 0, step_s = 1e9;
    for (int run = 0; run < 4; run++) {
        bool parts = run & 1;
        pel_growth_of(run & 2 ? PEL_SPECTRUM_JONSWAP : PEL_SPECTRUM_ELFOUHAILY,
                      3.3, &law);
        for (double from = 2; from < 11; from += 2.17) {
            struct pel_weather_now now;
            struct pel_weather_sea sea;
            struct pel_sea_desc desc;
            struct seen a, b;
            double h = from, before = from;
            front(h, parts, &now);
            pel_weather_sea_of(&now, &law, 0, &sea);
            describe(&sea, &law, &desc);
            see(&desc, time_s, &a);
            off = fmax(off, fabs(a.height_m / now.height_m - 1));
            assert_true(next_sea(&h, 1.0 / 3600, parts, &law, &sea));
            step_s = fmin(step_s, 3600 * (h - before));
            describe(&sea, &law, &desc);
            see(&desc, time_s, &b);
            double sum = 0;
            for (int i = 0; i < PLACES; i++) {
                double d = fabs(b.at[i] - a.at[i]);
                largest = fmax(largest, d);
                sum += d * d;
            }
            worst_rms = fmax(worst_rms, sqrt(sum / PLACES));
        }
    }
    printf("from one sea to the next: %.2f mm at most, %.2f mm rms; every %.0f "
           "s or more; height within %.2f %%\n",
           1e3 * largest, 1e3 * worst_rms, step_s, 100 * off);
    /* The estimate is one, within a factor of three; four σ. */
    assert_true(worst_rms < 4 * PEL_WEATHER_MOVES_M);
    assert_true(largest < 6e-3);
    assert_true(off < 0.03);
}

/* Without `steady` the same step moves the sea by decimetres. */
static void test_unsteady(void **state)
{
    (void)state;
    struct pel_growth_law law;
    struct pel_weather_now now;
    struct pel_weather_sea sea;
    struct pel_sea_desc desc;
    struct seen a, b;
    double h = 6, largest = 0;
    pel_growth_of(PEL_SPECTRUM_ELFOUHAILY, 3.3, &law);
    front(h, false, &now);
    pel_weather_sea_of(&now, &law, 0, &sea);
    describe(&sea, &law, &desc);
    desc.steady = false;
    see(&desc, 1e6, &a);
    assert_true(next_sea(&h, 1.0 / 3600, false, &law, &sea));
    describe(&sea, &law, &desc);
    desc.steady = false;
    see(&desc, 1e6, &b);
    for (int i = 0; i < PLACES; i++) {
        largest = fmax(largest, fabs(b.at[i] - a.at[i]));
    }
    printf("with frequencies of its own: %.0f mm\n", 1e3 * largest);
    assert_true(largest > 0.05);
}

/* No step of the numbers makes a step of the sea: in small steps through every
 * kind of weather, and height is kept. */
static void test_continuous(void **state)
{
    (void)state;
    struct pel_growth_law law;
    pel_growth_of(PEL_SPECTRUM_ELFOUHAILY, 3.3, &law);
    double off = 0, worst = 0;
    for (int path = 0; path < 60; path++) {
        struct pel_weather_sea last;
        double wind0 = 2 * (path % 8), wind1 = 3 * ((path * 5) % 9);
        double turn = 20 * (path % 10), hs0 = 0.5 * (path % 7);
        double hs1 = 0.4 * ((path * 3) % 11), t0 = 4 + path % 11;
        for (int i = 0; i <= 20000; i++) {
            double f = i / 20000.0, to = 1 + turn * f * PEL_DEG;
            double wind = wind0 + (wind1 - wind0) * f;
            struct pel_weather_sea sea;
            const struct pel_weather_now now = {
                .wind_east_mps = wind * cos(to),
                .wind_north_mps = wind * sin(to),
                .height_m = hs0 + (hs1 - hs0) * f,
                .period_s = t0 + 2 * f,
                .direction_rad = 1,
                .agreement = 1,
            };
            pel_weather_sea_of(&now, &law, 0, &sea);
            double h = hypot(pel_growth_height(&law, sea.wind_mps, sea.fetch_m),
                             sea.swell_height_m);
            double least =
                pel_growth_height(&law, wind, PEL_GROWTH_LEAST_FETCH_M);
            off = fmax(off, fabs(h - fmax(now.height_m, least)));
            if (i > 0 && wind > 0.5) {
                worst = fmax(worst, pel_weather_sea_moves(&last, &sea, &law));
            }
            last = sea;
        }
    }
    printf("a 20000th of a path moves %.2f mm at most\n", 1e3 * worst);
    assert_true(off < 1e-6);
    /* Paths are metres, seconds and half turns long: a 20000th of 3 m and of a
     * swell whose 6 % are passed in 0.1 s is 1 mm; a jump is centimetres. */
    assert_true(worst < 5e-3);
}

/* What the numbers mean in plain cases. */
static void test_cases(void **state)
{
    (void)state;
    struct pel_growth_law law;
    struct pel_weather_sea sea;
    pel_growth_of(PEL_SPECTRUM_ELFOUHAILY, 3.3, &law);
    /* The wind's own sea: no swell. */
    struct pel_weather_now now = { .wind_east_mps = 12, .agreement = 1 };
    now.height_m = pel_growth_height(&law, 12, 1e5);
    now.period_s = pel_growth_peak(&law, 12, 1e5);
    pel_weather_sea_of(&now, &law, 0, &sea);
    assert_float_equal(sea.fetch_m, 1e5, 1e3);
    assert_true(sea.swell_height_m < 0.05 * now.height_m);
    assert_float_equal(sea.wind_from_deg, 270, 1e-9);
    /* Old swell under a breeze: little of it is the wind's. */
    now = (struct pel_weather_now){ .wind_north_mps = 3,
                                    .height_m = 3,
                                    .period_s = 14,
                                    .direction_rad = 0,
                                    .agreement = 1 };
    pel_weather_sea_of(&now, &law, 0.1, &sea);
    assert_true(sea.swell_height_m > 2.98);
    assert_float_equal(sea.swell_period_s, 14, 0);
    assert_float_equal(sea.swell_from_deg, 270 + 0.1 / PEL_DEG, 1e-9);
    assert_float_equal(sea.wind_from_deg, 180 + 0.1 / PEL_DEG, 1e-9);
    /* Against the wind: it has a young sea. */
    now = (struct pel_weather_now){ .wind_east_mps = -15,
                                    .height_m = 4,
                                    .period_s = 9,
                                    .direction_rad = 0,
                                    .agreement = 1 };
    pel_weather_sea_of(&now, &law, 0, &sea);
    assert_float_equal(sea.fetch_m, 2e4, 200);
    /* Waves of two ways that meet spread. */
    now.agreement = 0.5;
    pel_weather_sea_of(&now, &law, 0, &sea);
    assert_float_equal(sea.swell_spread_deg, 60, 0);
    /* No waves in the file: the wind alone. */
    now.height_m = -1;
    pel_weather_sea_of(&now, &law, 0, &sea);
    assert_float_equal(sea.fetch_m, 0, 0);
    /* A storm that the schema does not have. */
    now.wind_east_mps = 60;
    pel_weather_sea_of(&now, &law, 0, &sea);
    assert_float_equal(sea.wind_mps, 30, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_front),
        cmocka_unit_test(test_unsteady),
        cmocka_unit_test(test_continuous),
        cmocka_unit_test(test_cases),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
