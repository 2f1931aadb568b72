#include "optics/colour.h"

#include <math.h>

#include "shaders/lib/blocks.h"

#define LUMENS_PER_WATT 683.0

/* Sun above the air, W m⁻² nm⁻¹: means of ASTM G-173's extraterrestrial column
 * over 360..370 nm, 370..380 nm and so on (Bruneton 2017). */
static const double sun[] = {
    1.11776, 1.14259, 1.01249, 1.14716, 1.72765, 1.73054, 1.68870, 1.61253,
    1.91198, 2.03474, 2.02042, 2.02212, 1.93377, 1.95809, 1.91686, 1.82980,
    1.86850, 1.89310, 1.85149, 1.85040, 1.83410, 1.83450, 1.81470, 1.78158,
    1.75330, 1.69650, 1.68194, 1.64654, 1.60480, 1.52143, 1.55622, 1.51130,
    1.47400, 1.44820, 1.41018, 1.36775, 1.34188, 1.31429, 1.28303, 1.26758,
    1.23670, 1.20820, 1.18737, 1.14683, 1.12362, 1.10580, 1.07124, 1.04992,
};
#define SUN_FIRST_NM 365.0 /* middle of the first */
#define SUN_STEP_NM 10.0
#define SUN_COUNT ((int)(sizeof sun / sizeof sun[0]))

static const double wavelength_nm[3] = { 680.0, 550.0, 440.0 };
static const double sun_there[3] = { 1.474, 1.850, 1.912 };

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

/* CIE XYZ of the three samples' shares: the spectrum is the Sun's times the
 * parabola through the three ratios. */
static void xyz_matrix(double m[3][3])
{
    for (int c = 0; c < 9; c++) {
        m[c / 3][c % 3] = 0;
    }
    for (int i = 0; i < SUN_COUNT; i++) {
        double nm = SUN_FIRST_NM + SUN_STEP_NM * i, xyz[3];
        observer(nm, xyz);
        for (int s = 0; s < 3; s++) {
            double p = wavelength_nm[(s + 1) % 3],
                   q = wavelength_nm[(s + 2) % 3];
            double at = wavelength_nm[s];
            double share = (nm - p) * (nm - q) / ((at - p) * (at - q));
            double w =
                LUMENS_PER_WATT * SUN_STEP_NM * sun[i] * share / sun_there[s];
            for (int c = 0; c < 3; c++) {
                m[c][s] += w * xyz[c];
            }
        }
    }
}

void pel_colour_matrix(double m[9])
{
    /* CIE XYZ to linear Rec. 709, D65: IEC 61966-2-1. */
    static const double rec709[3][3] = {
        { 3.2404542, -1.5371385, -0.4985314 },
        { -0.9692660, 1.8760108, 0.0415560 },
        { 0.0556434, -0.2040259, 1.0572252 },
    };
    double xyz[3][3];
    xyz_matrix(xyz);
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            m[3 * i + j] = 0;
            for (int k = 0; k < 3; k++) {
                m[3 * i + j] += rec709[i][k] * xyz[k][j];
            }
        }
    }
}

double pel_colour_illuminance(struct pel_rgb e)
{
    double m[3][3];
    xyz_matrix(m);
    return fmax(m[1][0] * e.r + m[1][1] * e.g + m[1][2] * e.b, 0);
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
