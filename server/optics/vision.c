#include "optics/vision.h"

#include <math.h>

#include "optics/colour.h"
#include "shaders/lib/blocks.h"

#define FIRST_NM 380.0
#define STEP_NM 5.0

/* CIE 1951 (ISO/CIE 23539). */
static const double scotopic_table[] = {
    5.89e-4,  1.108e-3, 2.209e-3, 4.53e-3,  9.29e-3,  0.01852, 0.03484,
    0.0604,   0.0966,   0.1436,   0.1998,   0.2625,   0.3281,  0.3931,
    0.455,    0.513,    0.567,    0.620,    0.676,    0.734,   0.793,
    0.851,    0.904,    0.949,    0.982,    0.998,    0.997,   0.975,
    0.935,    0.880,    0.811,    0.733,    0.650,    0.564,   0.481,
    0.402,    0.3288,   0.2639,   0.2076,   0.1602,   0.1212,  0.0899,
    0.0655,   0.0469,   0.03315,  0.02312,  0.01593,  0.01088, 7.37e-3,
    4.97e-3,  3.335e-3, 2.235e-3, 1.497e-3, 1.005e-3, 6.77e-4, 4.59e-4,
    3.129e-4, 2.146e-4, 1.48e-4,  1.026e-4, 7.15e-5
};
#define COUNT ((int)(sizeof scotopic_table / sizeof *scotopic_table))

double pel_vision_rods(double nm)
{
    double at = (nm - FIRST_NM) / STEP_NM;
    if (at < 0.0 || at > COUNT - 1) {
        return 0.0;
    }
    int i = at >= COUNT - 1 ? COUNT - 2 : (int)at;
    double t = at - i;
    return (1.0 - t) * scotopic_table[i] + t * scotopic_table[i + 1];
}

/* Share of the cones in a mesopic luminance. */
static double weight(double cones)
{
    return cones / (cones + (1.0 - cones) * PEL_EYE_RODS);
}

double pel_vision_cones(double photopic, double scotopic)
{
    double m = 0.5;
    for (int i = 0; i < PEL_EYE_STEPS; i++) {
        double w = weight(m);
        double l = fmax(w * photopic + (1.0 - w) * scotopic, 1e-9);
        double q = m + (1.0 - m) * PEL_EYE_RODS;
        double slope = PEL_EYE_SLOPE * 0.43429 * PEL_EYE_RODS *
                       (photopic - scotopic) / (q * q * l);
        double off = PEL_EYE_OFFSET + PEL_EYE_SLOPE * log10(l) - m;
        m = fmin(fmax(m + off / fmax(1.0 - slope, 0.5), 0.0), 1.0);
    }
    return m;
}

double pel_vision_luminance(double photopic, double scotopic)
{
    double w = weight(pel_vision_cones(photopic, scotopic));
    return w * photopic + (1.0 - w) * scotopic;
}

void pel_vision_seen(const double rec709[3], double scotopic, double out[3])
{
    static const double rods[3] = { PEL_EYE_RED, PEL_EYE_GREEN, PEL_EYE_BLUE };
    double y = 0.2126 * rec709[0] + 0.7152 * rec709[1] + 0.0722 * rec709[2];
    double s = fmax(scotopic, 0.0);
    double w = weight(pel_vision_cones(y, s));
    for (int c = 0; c < 3; c++) {
        out[c] = w * rec709[c] + (1.0 - w) * s * rods[c];
    }
}

double pel_vision_sight(double adapted)
{
    double l = log10(fmax(adapted, 1e-9));
    double bent = pow(fmax(0.405 * l + 1.6, 0.0), 2.18) - 2.86;
    double threshold = l <= -3.94 ? -2.86 : l >= -1.44 ? l - 0.395 : bent;
    return pow(10.0, fmin(l - threshold - 0.395, 0.0));
}

double pel_vision_acuity(double adapted)
{
    double l = log10(fmax(adapted, exp2(PEL_ACUITY_LEAST)));
    return PEL_ACUITY_SPAN * atan(PEL_ACUITY_STEEP * l + PEL_ACUITY_OFF) +
           PEL_ACUITY_MIDDLE;
}

double pel_vision_blur(double adapted)
{
    double finest = pel_vision_acuity(adapted);
    double lost =
        1.0 / (finest * finest) - 1.0 / (PEL_ACUITY_DAY * PEL_ACUITY_DAY);
    return PEL_ACUITY_HALF * sqrt(fmax(lost, 0.0));
}

double pel_vision_ev(double mean, double high, double level_lx)
{
    const double middle = PEL_TONE_MIDDLE / PEL_METER_MIDDLE;
    double fall = 1.0 - PEL_EYE_FALL * (1.0 - sqrt(pel_vision_sight(mean)));
    double key =
        PEL_METER_KEY * (1.03 - 2.0 / (2.0 + log10(mean + 1.0))) * fall;
    double ev = log2(middle * fmax(mean / key, high / PEL_METER_HIGH));
    double most = PEL_METER_MOST + PEL_METER_SLOPE * log2(fmax(level_lx, 1e-6) /
                                                          PEL_METER_SUNLIGHT);
    return fmax(fmin(ev, most), PEL_EYE_LEAST);
}
