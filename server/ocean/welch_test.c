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

/* Each bin of a Welch spectrum of 24 peak periods a segment against the
 * spectrum, from 0.7 to 4 peak frequencies, root mean square of the logarithm:
 * what the gauges know of a bin, 4 %, which their scatter says, and what is the
 * sea's own: steps between trochoids of one height each, 5 to 8 %; of cascades
 * hardly anything (seen 0.03 to 0.05; 0.16 to 0.19 where modes had the
 * frequencies of their cells' middles). */
#define ALLOWED_LOG 0.15
#define ALLOWED_MODES 0.07
#define ALLOWED_NOISE 0.05
#define LONG_GAUGES 200 /* of which trochoids take half */
#define SEGMENT 512
#define SEGMENTS 4 /* that overlap by half */
#define PEAKS 24
#define LONG_BINS (4 * PEAKS + 1)

/* Sums over gauges of a gauge's density and of its square. */
struct gauges {
    double sum[LONG_BINS], square[LONG_BINS];
};

static double turn[SEGMENT]; /* cosine of it */
static float level[LONG_GAUGES][(SEGMENTS + 1) * SEGMENT / 2];

static void add_segment(const float *z, double step_s, double *density)
{
    double mean = 0, power = 0;
    static double h[SEGMENT];
    for (int i = 0; i < SEGMENT; i++) {
        mean += (double)z[i] / SEGMENT;
    }
    for (int i = 0; i < SEGMENT; i++) {
        double w = 0.5 - 0.5 * cos(2 * PEL_PI * i / SEGMENT);
        h[i] = w * ((double)z[i] - mean);
        power += w * w;
    }
    for (int k = 1; k < LONG_BINS; k++) {
        double re = 0, im = 0;
        for (int i = 0; i < SEGMENT; i++) {
            int at = i * k % SEGMENT;
            re += h[i] * turn[at];
            im -= h[i] * turn[(at + 3 * SEGMENT / 4) % SEGMENT];
        }
        density[k] += 2 * step_s / power * (re * re + im * im) / SEGMENTS;
    }
}

static void gauge(const struct pel_sea *sea, int count, double step_s,
                  struct gauges *out)
{
    struct pel_vec2 at[LONG_GAUGES];
    static struct pel_surface_sample seen[LONG_GAUGES];
    for (int i = 0; i < count; i++) {
        double u = 0.6180339887 * i, v = 0.7548776662 * i;
        at[i] = (struct pel_vec2){ 6e4 * (u - floor(u)), 6e4 * (v - floor(v)) };
    }
    for (int n = 0; n < (SEGMENTS + 1) * SEGMENT / 2; n++) {
        pel_sea_query(sea, at, (size_t)count, step_s * n, seen);
        for (int i = 0; i < count; i++) {
            level[i][n] = (float)seen[i].height_m;
        }
    }
    for (int i = 0; i < SEGMENT; i++) {
        turn[i] = cos(2 * PEL_PI * i / SEGMENT);
    }
    *out = (struct gauges){ 0 };
    for (int i = 0; i < count; i++) {
        double density[LONG_BINS] = { 0 };
        for (int n = 0; n < SEGMENTS; n++) {
            add_segment(level[i] + n * SEGMENT / 2, step_s, density);
        }
        for (int k = 1; k < LONG_BINS; k++) {
            out->sum[k] += density[k] / count;
            out->square[k] += density[k] * density[k] / count;
        }
    }
}

static double peak_of(const struct pel_directional *spectrum)
{
    double peak = 0, most = 0;
    for (double w = 0.2; w < 6; w *= 1.005) {
        struct pel_spectrum_row row;
        pel_spectrum_row(spectrum, w, &row);
        peak = row.density > most ? w : peak;
        most = fmax(most, row.density);
    }
    return peak;
}

static void compare_bins(const struct pel_sea_desc *desc)
{
    static struct pel_sea sea;
    static struct gauges g;
    struct pel_directional *spectrum;
    assert_int_equal(pel_sea_build(desc, &sea), PEL_OK);
    assert_int_equal(pel_directional_create(desc, &spectrum), PEL_OK);
    double peak = peak_of(spectrum), sum = 0, noise = 0;
    bool fft = desc->synthesiser == PEL_SYNTHESISER_FFT;
    int count = fft ? LONG_GAUGES : LONG_GAUGES / 2;
    gauge(&sea, count, PEAKS * 2 * PEL_PI / peak / SEGMENT, &g);
    int bins = 0;
    for (int k = (int)ceil(0.7 * PEAKS); k < LONG_BINS; k++, bins++) {
        struct pel_spectrum_row row;
        pel_spectrum_row(spectrum, peak * k / PEAKS, &row);
        double mean = g.sum[k], off = log(mean / (2 * PEL_PI * row.density));
        sum += off * off;
        noise += (g.square[k] / (mean * mean) - 1) / (count - 1);
    }
    print_message("%s, spectrum %d, %.0f m/s: %.3f rms of ln over %d bins, "
                  "noise %.3f\n",
                  fft ? "FFT" : "sixty", (int)desc->kind, desc->wind_mps,
                  sqrt(sum / bins), bins, sqrt(noise / bins));
    assert_true(sqrt(sum / bins) < (fft ? ALLOWED_MODES : ALLOWED_LOG));
    assert_true(sqrt(noise / bins) < ALLOWED_NOISE);
    pel_directional_destroy(spectrum);
    pel_sea_finish(&sea);
}

static void test_bins(enum pel_synthesiser synthesiser)
{
    static const enum pel_spectrum_kind kinds[] = {
        PEL_SPECTRUM_PIERSON_MOSKOWITZ, PEL_SPECTRUM_JONSWAP,
        PEL_SPECTRUM_ELFOUHAILY, PEL_SPECTRUM_TMA
    };
    static const double winds[] = { 5, 10, 15, 20 };
    bool fft = synthesiser == PEL_SYNTHESISER_FFT;
    for (int i = 0; i < 16; i++) {
        /* Of cascades fewer: the fields of 1,280 moments cost seconds. */
        if (fft && i > 3 && (i + i / 4) % 4 != 0) {
            continue;
        }
        compare_bins(&(struct pel_sea_desc){ .kind = kinds[i / 4],
                                             .synthesiser = synthesiser,
                                             .wind_mps = winds[i % 4],
                                             .direction_rad = 0.4,
                                             .fetch_m = 4e5,
                                             .gamma = 3.3,
                                             .depth_m = i / 4 == 3 ? 20 : 0,
                                             .seed = 3,
                                             .wave_count = 60 });
    }
}

static void test_sixty(void **state)
{
    (void)state;
    test_bins(PEL_SYNTHESISER_TROCHOIDS);
}

static void test_modes(void **state)
{
    (void)state;
    test_bins(PEL_SYNTHESISER_FFT);
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
        cmocka_unit_test(test_modes),
        cmocka_unit_test(test_cascades),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
