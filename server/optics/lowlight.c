#include "optics/lowlight.h"

#include <math.h>

#include "base/vec.h"

#define PLANCK_LIGHT 1.98644586e-25 /* h c, J m */

/* After published curves of third-generation tubes: read to some 0.02. */
static const double efficiency[][2] = {
    { 400, 0.02 }, { 450, 0.06 }, { 500, 0.20 }, { 550, 0.30 },
    { 600, 0.36 }, { 650, 0.39 }, { 700, 0.40 }, { 750, 0.40 },
    { 800, 0.38 }, { 850, 0.33 }, { 880, 0.18 }, { 900, 0.03 },
};
#define ROWS ((int)(sizeof efficiency / sizeof *efficiency))

double pel_lowlight_efficiency(double nm)
{
    if (nm < efficiency[0][0] || nm > efficiency[ROWS - 1][0]) {
        return 0;
    }
    int i = 0;
    while (i < ROWS - 2 && nm > efficiency[i + 1][0]) {
        i++;
    }
    double t =
        (nm - efficiency[i][0]) / (efficiency[i + 1][0] - efficiency[i][0]);
    return efficiency[i][1] + t * (efficiency[i + 1][1] - efficiency[i][1]);
}

void pel_lowlight_photons(double exposure_s, double f_number, double out[3])
{
    const double step = 1; /* nm */
    double side = PEL_LOWLIGHT_PITCH_M / f_number;
    double taken = 0.25 * PEL_PI * side * side * PEL_LOWLIGHT_LENS * exposure_s;
    out[0] = out[1] = out[2] = 0;
    for (double nm = 400.5; nm < 900; nm += step) {
        double photons = taken * pel_lowlight_efficiency(nm) * nm * 1e-9 /
                         PLANCK_LIGHT * step;
        double red = pel_clamp((nm - 550) / (680 - 550), 0, 1),
               blue = pel_clamp((550 - nm) / (550 - 440), 0, 1);
        out[0] += photons * red;
        out[1] += photons * (1 - red - blue);
        out[2] += photons * blue;
    }
}
