/* The spectrum found again in time series of surface queries, as a wave gauge
 * would find it: Welch's method, Hann windows that overlap by half. */
#include "base/near.h"
#include "ocean/directional.h"

#define LENGTH 256   /* samples of a window */
#define SAMPLES 384  /* of a gauge: two windows */
#define STEP_S 0.625 /* up to 0.8 Hz */
#define GAUGES 96
#define BINS (LENGTH / 2)

static double series[GAUGES][SAMPLES];

static void record(const struct pel_sea *sea)
{
    struct pel_vec2 at[GAUGES];
    struct pel_surface_sample out[GAUGES];
    for (int i = 0; i < GAUGES; i++) {
        /* Golden ratio in both directions, over 40 km. */
        double u = 0.6180339887 * i, v = 0.7548776662 * i;
        at[i] = (struct pel_vec2){ 4e4 * (u - floor(u)), 4e4 * (v - floor(v)) };
    }
    for (int n = 0; n < SAMPLES; n++) {
        pel_sea_query(sea, at, GAUGES, STEP_S * n, out);
        for (int i = 0; i < GAUGES; i++) {
            series[i][n] = out[i].height_m;
        }
    }
}

/* Mean periodogram [m²/Hz]. */
static void welch(double density[BINS])
{
    static double cosine[LENGTH], sine[LENGTH], window[LENGTH];
    double power = 0;
    for (int i = 0; i < LENGTH; i++) {
        cosine[i] = cos(2 * PEL_PI * i / LENGTH);
        sine[i] = sin(2 * PEL_PI * i / LENGTH);
        window[i] = 0.5 - 0.5 * cosine[i];
        power += window[i] * window[i];
    }
    int windows = 0;
    for (int k = 0; k < BINS; k++) {
        density[k] = 0;
    }
    for (int g = 0; g < GAUGES; g++) {
        double mean = 0;
        for (int i = 0; i < SAMPLES; i++) {
            mean += series[g][i] / SAMPLES;
        }
        for (int from = 0; from + LENGTH <= SAMPLES; from += LENGTH / 2) {
            windows++;
            for (int k = 1; k < BINS; k++) {
                double re = 0, im = 0;
                for (int i = 0; i < LENGTH; i++) {
                    double h = (series[g][from + i] - mean) * window[i];
                    re += h * cosine[i * k % LENGTH];
                    im += h * sine[i * k % LENGTH];
                }
                density[k] += 2 * STEP_S * (re * re + im * im) / power;
            }
        }
    }
    for (int k = 0; k < BINS; k++) {
        density[k] /= windows;
    }
}

/* 192 windows of five bins know the energy of a band to 4 % (one sigma), more
 * where gauges see the same few waves; the window leaks 2 %; crests pointed by
 * choppiness move some percent from the peak to its double. */
#define ALLOWED 0.12

/* Energies of bands against the spectrum's integral. */
static void compare(const struct pel_sea_desc *desc)
{
    static struct pel_sea sea;
    struct pel_directional *spectrum;
    double density[BINS], step = 1 / (STEP_S * LENGTH);
    assert_int_equal(pel_sea_build(desc, &sea), PEL_OK);
    assert_int_equal(pel_directional_create(desc, &spectrum), PEL_OK);
    record(&sea);
    welch(density);
    /* Bins of 1/160 Hz; the peak is at 0.129 Hz. */
    const int edges[] = { 14, 19, 23, 29, 38, 52, 72 };
    for (int b = 0; b < 6; b++) {
        double seen = 0;
        for (int k = edges[b]; k < edges[b + 1]; k++) {
            seen += density[k] * step;
        }
        double lo = 2 * PEL_PI * (edges[b] - 0.5) * step;
        double hi = 2 * PEL_PI * (edges[b + 1] - 0.5) * step;
        struct pel_band_moments want;
        pel_directional_moments(spectrum, lo * lo / PEL_GRAVITY,
                                hi * hi / PEL_GRAVITY, &want);
        print_message("%.3f to %.3f Hz: %.5f m2, spectrum %.5f (%+.1f %%)\n",
                      lo / (2 * PEL_PI), hi / (2 * PEL_PI), seen, want.m0,
                      100 * (seen / want.m0 - 1));
        assert_near(seen, want.m0, ALLOWED * want.m0);
    }
    pel_directional_destroy(spectrum);
    pel_sea_finish(&sea);
}

static const struct pel_sea_desc base = {
    .kind = PEL_SPECTRUM_PIERSON_MOSKOWITZ,
    .wind_mps = 10,
    .direction_rad = 0.4,
    .seed = 3,
    .wave_count = 256,
};

static void test_trochoids(void **state)
{
    (void)state;
    compare(&base);
}

static void test_cascades(void **state)
{
    (void)state;
    struct pel_sea_desc d = base;
    d.synthesiser = PEL_SYNTHESISER_FFT;
    compare(&d);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_trochoids),
        cmocka_unit_test(test_cascades),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
