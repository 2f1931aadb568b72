/* The spectrum found again in time series of surface queries, as a gauge
 * of height and current would find it: Welch's method, Hann windows that
 * overlap by half, directions from the co-spectra of height and velocity
 * (Longuet-Higgins, Cartwright, Smith 1963, with velocities for slopes: those
 * of waves too short for the sampling would fold back). */
#include <string.h>

#include "base/near.h"
#include "ocean/directional.h"
#include "ocean/report.h"

#define LENGTH 256   /* samples of a window */
#define SAMPLES 384  /* of a gauge: two windows */
#define STEP_S 0.625 /* up to 0.8 Hz */
#define GAUGES 96
#define BINS (LENGTH / 2)

enum { HEIGHT, EAST, NORTH, SERIES };
static double series[SERIES][GAUGES][SAMPLES];

/* Sums over windows and gauges. */
struct estimate {
    double density[BINS];           /* m²/Hz */
    double speed[BINS];             /* of both components, m²/s²/Hz */
    double east[BINS], north[BINS]; /* co-spectra with height */
    double significant_height;      /* m */
};

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
            series[HEIGHT][i][n] = out[i].height_m;
            series[EAST][i][n] = out[i].velocity_mps.x;
            series[NORTH][i][n] = out[i].velocity_mps.y;
        }
    }
}

static double cosine[LENGTH], sine[LENGTH], window[LENGTH];

/* Fourier sum k of a window of gauge g. */
static void transform(int what, int g, int from, int k, double mean,
                      double out[2])
{
    out[0] = out[1] = 0;
    for (int i = 0; i < LENGTH; i++) {
        double h = (series[what][g][from + i] - mean) * window[i];
        out[0] += h * cosine[i * k % LENGTH];
        out[1] -= h * sine[i * k % LENGTH];
    }
}

static void add_window(int g, int from, const double mean[SERIES],
                       double factor, struct estimate *e)
{
    for (int k = 1; k < BINS; k++) {
        double f[SERIES][2];
        for (int s = 0; s < SERIES; s++) {
            transform(s, g, from, k, mean[s], f[s]);
        }
        const double *z = f[HEIGHT], *u = f[EAST], *v = f[NORTH];
        e->density[k] += factor * (z[0] * z[0] + z[1] * z[1]);
        e->speed[k] +=
            factor * (u[0] * u[0] + u[1] * u[1] + v[0] * v[0] + v[1] * v[1]);
        e->east[k] += factor * (z[0] * u[0] + z[1] * u[1]);
        e->north[k] += factor * (z[0] * v[0] + z[1] * v[1]);
    }
}

static void welch(struct estimate *e)
{
    double power = 0, square = 0, sum = 0;
    for (int i = 0; i < LENGTH; i++) {
        cosine[i] = cos(2 * PEL_PI * i / LENGTH);
        sine[i] = sin(2 * PEL_PI * i / LENGTH);
        window[i] = 0.5 - 0.5 * cosine[i];
        power += window[i] * window[i];
    }
    *e = (struct estimate){ 0 };
    const int windows = (SAMPLES - LENGTH) / (LENGTH / 2) + 1;
    for (int g = 0; g < GAUGES; g++) {
        double mean[SERIES] = { 0 };
        for (int s = 0; s < SERIES; s++) {
            for (int i = 0; i < SAMPLES; i++) {
                mean[s] += series[s][g][i] / SAMPLES;
            }
        }
        for (int i = 0; i < SAMPLES; i++) {
            double h = series[HEIGHT][g][i];
            sum += h;
            square += h * h;
        }
        for (int n = 0; n < windows; n++) {
            add_window(g, n * LENGTH / 2, mean,
                       2 * STEP_S / power / (windows * GAUGES), e);
        }
    }
    sum /= GAUGES * SAMPLES;
    e->significant_height = 4 * sqrt(square / (GAUGES * SAMPLES) - sum * sum);
}

/* 192 windows of five bins know the energy of a band to 4 % (one sigma), more
 * where gauges see the same few waves; the window leaks 2 %; crests pointed by
 * choppiness move some percent from the peak to its double. */
#define ALLOWED 0.12

/* Directions: sampling of the same windows, 4 %, is 3° of a mean direction and
 * 0.04 of r1; few trochoids in a band have directions of their own. */
#define ALLOWED_DEG 6.0
#define ALLOWED_R1 0.06
/* Significant height of 96 gauges over four minutes. */
#define ALLOWED_HEIGHT 0.03

/* Mean direction and r1 of a band against the spectrum's. */
static void compare_direction(const struct estimate *e,
                              const struct pel_directional *spectrum, int from,
                              int to)
{
    double east = 0, north = 0, height = 0, speed = 0;
    double want_east = 0, want_north = 0, want = 0;
    for (int k = from; k < to; k++) {
        struct pel_spectrum_row row;
        pel_spectrum_row(spectrum, 2 * PEL_PI * k / (STEP_S * LENGTH), &row);
        east += e->east[k];
        north += e->north[k];
        height += e->density[k];
        speed += e->speed[k];
        want += row.density;
        want_east += row.density * row.r1 * cos(row.mean_to_rad);
        want_north += row.density * row.r1 * sin(row.mean_to_rad);
    }
    double r1 = hypot(east, north) / sqrt(height * speed);
    double want_r1 = hypot(want_east, want_north) / want;
    double off = remainder(atan2(north, east) - atan2(want_north, want_east),
                           2 * PEL_PI);
    print_message("    direction %+.1f deg off, r1 %.3f, spectrum %.3f\n",
                  off / PEL_DEG, r1, want_r1);
    assert_near(off / PEL_DEG, 0, ALLOWED_DEG);
    assert_near(r1, want_r1, ALLOWED_R1);
}

/* The fourth power's mean over some eight bins about the peak, each known to
 * 10 %, moves by 0.03 of its frequency. */
#define ALLOWED_PEAK 0.05

/* Young 1995: the highest of noisy bins says little where the spectrum is
 * flat; the mean weighted by the fourth power of the density does not jump. */
static double peak_bin(const double density[BINS])
{
    double sum = 0, weight = 0;
    for (int k = 1; k < BINS; k++) {
        double w = pow(density[k], 4);
        sum += k * w;
        weight += w;
    }
    return sum / weight;
}

/* Energies of bands, heights and the peak against the spectrum's integral. */
static void compare(const struct pel_sea_desc *desc)
{
    static struct pel_sea sea;
    static struct estimate e;
    struct pel_directional *spectrum;
    double step = 1 / (STEP_S * LENGTH);
    assert_int_equal(pel_sea_build(desc, &sea), PEL_OK);
    assert_int_equal(pel_directional_create(desc, &spectrum), PEL_OK);
    record(&sea);
    welch(&e);
    /* Bins of 1/160 Hz; the peak is at 0.129 Hz. */
    const int edges[] = { 14, 19, 23, 29, 38, 52, 72 };
    for (int b = 0; b < 6; b++) {
        double seen = 0;
        for (int k = edges[b]; k < edges[b + 1]; k++) {
            seen += e.density[k] * step;
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
        compare_direction(&e, spectrum, edges[b], edges[b + 1]);
    }
    struct pel_sea_report report;
    pel_sea_report(&sea, spectrum, 0, &report);
    double want_density[BINS] = { 0 };
    for (int k = 1; k < BINS; k++) {
        struct pel_spectrum_row row;
        pel_spectrum_row(spectrum, 2 * PEL_PI * k * step, &row);
        want_density[k] = row.density;
    }
    double hs = 4 * sqrt(report.spectrum.m0);
    double peak = peak_bin(e.density) * step;
    double want_peak = peak_bin(want_density) * step;
    print_message("Hs %.3f m, spectrum %.3f; Tp %.2f s, %.2f\n",
                  e.significant_height, hs, 1 / peak, 1 / want_peak);
    assert_near(e.significant_height, hs, ALLOWED_HEIGHT * hs);
    assert_near(peak, want_peak, ALLOWED_PEAK * want_peak);
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

/* Sixty trochoids: each bin of a Welch spectrum of 24 peak periods a segment
 * against the spectrum, from 0.7 to 4 peak frequencies, root mean square of the
 * logarithm. Sixteen gauges for 3,600 s know a bin to 4 to 8 %; waves
 * of one height each leave steps between bins, 5 %. */
#define ALLOWED_LOG 0.15
#define LONG_GAUGES 16
#define SEGMENT 512

static double periodogram[SEGMENT / 2];

static void add_segment(const double *z, double step_s)
{
    double mean = 0, power = 0;
    static double h[SEGMENT];
    for (int i = 0; i < SEGMENT; i++) {
        mean += z[i] / SEGMENT;
    }
    for (int i = 0; i < SEGMENT; i++) {
        double w = 0.5 - 0.5 * cos(2 * PEL_PI * i / SEGMENT);
        h[i] = w * (z[i] - mean);
        power += w * w;
    }
    for (int k = 1; k <= 4 * 24; k++) {
        double re = 0, im = 0;
        for (int i = 0; i < SEGMENT; i++) {
            double a = 2 * PEL_PI * (i * k % SEGMENT) / SEGMENT;
            re += h[i] * cos(a);
            im -= h[i] * sin(a);
        }
        periodogram[k] += 2 * step_s / power * (re * re + im * im);
    }
}

static void compare_bins(const struct pel_sea_desc *desc)
{
    static struct pel_sea sea;
    struct pel_directional *spectrum;
    struct pel_spectrum_row row;
    assert_int_equal(pel_sea_build(desc, &sea), PEL_OK);
    assert_int_equal(pel_directional_create(desc, &spectrum), PEL_OK);
    double peak = 0, most = 0;
    for (double w = 0.2; w < 6; w *= 1.005) {
        pel_spectrum_row(spectrum, w, &row);
        peak = row.density > most ? w : peak;
        most = fmax(most, row.density);
    }
    double step_s = 24 * 2 * PEL_PI / peak / SEGMENT;
    int segments = (int)(2 * 3600 / (step_s * SEGMENT)) - 1;
    static double z[LONG_GAUGES][SEGMENT];
    memset(periodogram, 0, sizeof periodogram);
    for (int n = 0; n < (segments + 1) * (SEGMENT / 2); n++) {
        struct pel_vec2 at[LONG_GAUGES];
        struct pel_surface_sample out[LONG_GAUGES];
        for (int i = 0; i < LONG_GAUGES; i++) {
            at[i] = (struct pel_vec2){ 4e3 * i, 4e4 * fmod(0.618034 * i, 1) };
        }
        pel_sea_query(&sea, at, LONG_GAUGES, step_s * n, out);
        /* The second half is full every SEGMENT/2 samples. */
        int slot = SEGMENT / 2 + n % (SEGMENT / 2);
        for (int i = 0; i < LONG_GAUGES; i++) {
            z[i][slot] = out[i].height_m;
            if (slot == SEGMENT - 1) {
                if (n >= SEGMENT) {
                    add_segment(z[i], step_s);
                }
                memcpy(z[i], z[i] + SEGMENT / 2, sizeof z[i] / 2);
            }
        }
    }
    double sum = 0;
    int bins = 0, counted = LONG_GAUGES * (segments - 1);
    for (int k = (int)ceil(0.7 * 24); k <= 4 * 24; k++, bins++) {
        pel_spectrum_row(spectrum, peak * k / 24, &row);
        double off = log(periodogram[k] / counted / (2 * PEL_PI * row.density));
        sum += off * off;
    }
    print_message("spectrum %d, %.0f m/s: %.3f rms of ln over %d bins\n",
                  (int)desc->kind, desc->wind_mps, sqrt(sum / bins), bins);
    assert_true(sqrt(sum / bins) < ALLOWED_LOG);
    pel_directional_destroy(spectrum);
    pel_sea_finish(&sea);
}

static void test_sixty(void **state)
{
    (void)state;
    static const enum pel_spectrum_kind kinds[] = {
        PEL_SPECTRUM_PIERSON_MOSKOWITZ, PEL_SPECTRUM_JONSWAP,
        PEL_SPECTRUM_ELFOUHAILY, PEL_SPECTRUM_TMA
    };
    for (int i = 0; i < 8; i++) {
        compare_bins(&(struct pel_sea_desc){ .kind = kinds[i / 2],
                                             .wind_mps = i % 2 ? 20 : 5,
                                             .direction_rad = 0.4,
                                             .fetch_m = 4e5,
                                             .gamma = 3.3,
                                             .depth_m = i / 2 == 3 ? 20 : 0,
                                             .seed = 3,
                                             .wave_count = 60 });
    }
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
        cmocka_unit_test(test_sixty),
        cmocka_unit_test(test_cascades),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
