#include "optics/colour.h"

#include <math.h>

#include "base/vec.h"
#include "optics/coloursuns.h"
#include "shaders/lib/blocks.h"

/* Rows of X, Y, Z and of the rods for a Sun. */
static void xyz_at(double sun_sine, double m[12])
{
    const struct pel_colour_suns *suns = &pel_colour_suns;
    const double *elevation = suns->elevation_deg;
    double deg = asin(fmin(fmax(sun_sine, -1), 1)) / PEL_DEG;
    deg = fmax(deg, elevation[0]);
    int i = 0;
    while (i + 2 < PEL_COLOUR_SUNS && deg >= elevation[i + 1]) {
        i++;
    }
    double t = (deg - elevation[i]) / (elevation[i + 1] - elevation[i]);
    for (int c = 0; c < 12; c++) {
        m[c] = suns->weight[i][c] +
               t * (suns->weight[i + 1][c] - suns->weight[i][c]);
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
