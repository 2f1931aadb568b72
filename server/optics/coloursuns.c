#include "optics/coloursuns.h"

#include <math.h>

#include "base/vec.h"
#include "optics/daylight.h"
#include "optics/vision.h"

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

void pel_colour_suns_make(struct pel_colour_suns *out)
{
    static const double elevation_deg[PEL_COLOUR_SUNS] = {
        -9, -8, -7, -6, -5, -4, -3, -2, -1, 0,  1,
        2,  3,  5,  7,  10, 15, 20, 28, 40, 60, 90
    };
    for (int i = 0; i < PEL_COLOUR_SUNS; i++) {
        struct pel_daylight light;
        pel_daylight(sin(elevation_deg[i] * PEL_DEG), &light);
        out->elevation_deg[i] = elevation_deg[i];
        xyz_matrix(&light, out->weight[i]);
    }
}
