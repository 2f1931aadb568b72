#include "optics/colour.h"

#include <math.h>
#include <pthread.h>
#include <stddef.h>

#include "base/vec.h"
#include "optics/daylight.h"
#include "optics/vision.h"
#include "shaders/lib/blocks.h"

#define LUMENS_PER_WATT 683.0
#define RODS_LUMENS_PER_WATT 1700.0

static const double wavelength_nm[3] = { 680.0, 550.0, 440.0 };

static double lobe(double nm, double centre, double below, double above)
{
    double t = (nm - centre) / (nm < centre ? below : above);
    return exp(-0.5 * t * t);
}

/* CIE 1931 colour matching: Wyman, Sloan and Shirley 2013, multi-lobe fit. */
static void observer(double nm, double xyz[3])
{
    xyz[0] = 1.056 * lobe(nm, 599.8, 37.9, 31.0) +
             0.362 * lobe(nm, 442.0, 16.0, 26.7) -
             0.065 * lobe(nm, 501.1, 20.4, 26.2);
    xyz[1] = 0.821 * lobe(nm, 568.8, 46.9, 40.5) +
             0.286 * lobe(nm, 530.9, 16.3, 31.1);
    xyz[2] = 1.217 * lobe(nm, 437.0, 11.8, 36.0) +
             0.681 * lobe(nm, 459.0, 26.0, 13.8);
}

/* CIE XYZ of the three samples' shares, and the rods'. */
static void xyz_matrix(const struct pel_daylight *light, double m[12])
{
    for (int c = 0; c < 12; c++) {
        m[c] = 0;
    }
    for (int i = 0; i < PEL_DAYLIGHT_COUNT; i++) {
        double nm = PEL_DAYLIGHT_FIRST_NM + PEL_DAYLIGHT_STEP_NM * i, xyz[3];
        observer(nm, xyz);
        for (int s = 0; s < 3; s++) {
            double p = pow(wavelength_nm[(s + 1) % 3], -2),
                   q = pow(wavelength_nm[(s + 2) % 3], -2),
                   at = pow(wavelength_nm[s], -2), x = pow(nm, -2);
            double share = (x - p) * (x - q) / ((at - p) * (at - q));
            double lit =
                PEL_DAYLIGHT_STEP_NM * light->at[i] * share / light->sample[s];
            for (int c = 0; c < 3; c++) {
                m[3 * c + s] += LUMENS_PER_WATT * lit * xyz[c];
            }
            m[9 + s] += RODS_LUMENS_PER_WATT * lit * pel_vision_rods(nm);
        }
    }
}

/* By the Sun's elevation, deg. */
static const double elevation[] = {
    -9, -8, -7, -6, -5,   -4, -3, -2, -1, 0,  1,
    2,  3,  5,  7,  10.0, 15, 20, 28, 40, 60, 90
};
#define ELEVATIONS (sizeof elevation / sizeof elevation[0])
static double matrices[ELEVATIONS][12];
static pthread_once_t matrices_once = PTHREAD_ONCE_INIT;

static void matrices_fill(void)
{
    for (size_t i = 0; i < ELEVATIONS; i++) {
        struct pel_daylight light;
        pel_daylight(sin(elevation[i] * PEL_DEG), &light);
        xyz_matrix(&light, matrices[i]);
    }
}

/* Rows of X, Y, Z and of the rods for a Sun. */
static void xyz_at(double sun_sine, double m[12])
{
    pthread_once(&matrices_once, matrices_fill);
    double deg = asin(fmin(fmax(sun_sine, -1), 1)) / PEL_DEG;
    deg = fmax(deg, elevation[0]);
    size_t i = 0;
    while (i + 2 < ELEVATIONS && deg >= elevation[i + 1]) {
        i++;
    }
    double t = (deg - elevation[i]) / (elevation[i + 1] - elevation[i]);
    for (int c = 0; c < 12; c++) {
        m[c] = matrices[i][c] + t * (matrices[i + 1][c] - matrices[i][c]);
    }
}

void pel_colour_matrix(double sun_sine, double m[9])
{
    /* CIE XYZ to linear Rec. 709, D65: IEC 61966-2-1. */
    static const double rec709[3][3] = {
        { 3.2404542, -1.5371385, -0.4985314 },
        { -0.9692660, 1.8760108, 0.0415560 },
        { 0.0556434, -0.2040259, 1.0572252 },
    };
    double xyz[12];
    xyz_at(sun_sine, xyz);
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            m[3 * i + j] = 0;
            for (int k = 0; k < 3; k++) {
                m[3 * i + j] += rec709[i][k] * xyz[3 * k + j];
            }
        }
    }
}

void pel_colour_rods(double sun_sine, double weights[3])
{
    double m[12];
    xyz_at(sun_sine, m);
    for (int s = 0; s < 3; s++) {
        weights[s] = m[9 + s];
    }
}

double pel_colour_illuminance(struct pel_rgb e, double sun_sine)
{
    double m[12];
    xyz_at(sun_sine, m);
    return fmax(m[3] * e.r + m[4] * e.g + m[5] * e.b, 0);
}

double pel_colour_exposure_scale(double ev100)
{
    return PEL_TONE_MIDDLE / PEL_METER_MIDDLE * exp2(-ev100);
}

double pel_tone_curve(double x)
{
    double p = pow(x, PEL_TONE_POWER);
    double f = p / (PEL_TONE_STRETCH * p + PEL_TONE_HALF);
    return f * f * (1.0 + PEL_TONE_FLARE) / (f + PEL_TONE_FLARE);
}

void pel_tone_filmic(const double exposed[3], double out[3])
{
    double peak = fmax(fmax(exposed[0], exposed[1]), fmax(exposed[2], 1e-9));
    double shown = fmin(pel_tone_curve(peak), 1.0);
    double pale = peak / PEL_TONE_PALE;
    double kept = PEL_TONE_LEAST + (1.0 - PEL_TONE_LEAST) / (1.0 + pale * pale);
    for (int c = 0; c < 3; c++) {
        out[c] = shown * (1.0 + (exposed[c] / peak - 1.0) * kept);
    }
}

double pel_meter_mean(double mean, double level_lx)
{
    double level = fmax(level_lx, 1e-6);
    double day = fmin(fmax(log2(level / PEL_METER_DULL) / 3.0, 0), 1);
    double share = PEL_METER_INCIDENT * day;
    return pow(mean, 1.0 - share) * pow(PEL_METER_MATT * level, share);
}

double pel_meter_ev(double mean, double high, double level_lx)
{
    double key = PEL_METER_KEY * pow(1.03 - 2.0 / (2.0 + log10(mean + 1.0)),
                                     PEL_METER_KEY_POWER);
    double adapted = log2(mean / key * (PEL_TONE_MIDDLE / PEL_METER_MIDDLE));
    double kept =
        log2(high / PEL_METER_HIGH * (PEL_TONE_MIDDLE / PEL_METER_MIDDLE));
    double most = PEL_METER_MOST + PEL_METER_SLOPE * log2(fmax(level_lx, 1e-6) /
                                                          PEL_METER_SUNLIGHT);
    return fmax(fmin(fmax(adapted, kept), most), PEL_METER_LEAST);
}

double pel_glare_spread(double away)
{
    const double core2 = 0.5 * PEL_GLARE_CORE * PEL_GLARE_CORE;
    return 1.0 / (2.0 * PEL_PI * core2 * log(1.0 + 2.0 / core2) *
                  (1.0 + away / core2));
}
