#include "optics/raman.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/vec.h"
#include "optics/daylight.h"
#include "optics/linear.h"
#include "optics/ordinates.h"

#define SHIFT_PER_NM 3400e-7 /* of the wavenumber */
#define PLANES 32
#define BEAMS PEL_ORDINATES_BEAMS

/* Phase function 1 + 0.55 cos² (Ge, Gordon and Voss 1993, depolarisation 0.17),
 * over its mean: 1 + TWO P_2. */
#define TWO (0.55 * (2.0 / 3.0) / (1.0 + 0.55 / 3.0))

double pel_raman_excitation_nm(double nm)
{
    return 1.0 / (1.0 / nm + SHIFT_PER_NM);
}

double pel_raman_scattering(double nm)
{
    return 2.7e-4 * pow(nm / 488.0, -5.5);
}

/* The Sun above the air, smoothed over the 40 nm of the band. */
static double sunlight(double nm)
{
    double sum = 0.0, at = (nm - PEL_DAYLIGHT_FIRST_NM) / PEL_DAYLIGHT_STEP_NM;
    for (int k = -2; k <= 2; k++) {
        double x = pel_clamp(at + 0.8 * k, 0.0, PEL_DAYLIGHT_COUNT - 1.0);
        int i = (int)fmin(x, PEL_DAYLIGHT_COUNT - 2.0);
        sum += pel_sun_spectrum[i] +
               (x - i) * (pel_sun_spectrum[i + 1] - pel_sun_spectrum[i]);
    }
    return sum;
}

double pel_raman_strength(double nm)
{
    double from = pel_raman_excitation_nm(nm), part = from / nm;
    return pel_raman_scattering(from) * part * part * sunlight(from) /
           sunlight(nm);
}

struct work {
    double depth[PLANES], weight[PLANES];
    double light[PEL_MOMENTS][PLANES][BEAMS];
    double eye[PEL_MOMENTS][PLANES][BEAMS];
};

/* Planes at Gauss nodes of what daylight of both wavelengths is left with,
 * denser under the surface and above the bottom. */
static void place_planes(const struct pel_medium *a, const struct pel_medium *b,
                         double depth, struct work *w)
{
    double node[PLANES], part[PLANES];
    double rate =
        sqrt(a->absorption * (a->absorption + 0.235 * a->scattering)) +
        sqrt(b->absorption * (b->absorption + 0.235 * b->scattering));
    double reach = -expm1(-rate * depth);
    pel_gauss_legendre(PLANES, 0.0, 1.0, node, part);
    for (int k = 0; k < PLANES; k++) {
        double t = node[k], u = t * t * (3.0 - 2.0 * t);
        w->depth[k] = -log1p(-u * reach) / rate;
        w->weight[k] =
            part[k] * 6.0 * t * (1.0 - t) * reach / (rate * (1.0 - u * reach));
    }
}

static void add_up(const struct work *w, double strength, int beams,
                   const double *view_mu, int views, double *out)
{
    /* Mode, coefficient and sign of each moment: light goes up towards the
     * eye, the eye's beam down. */
    static const struct {
        int mode;
        double factor;
    } moments[PEL_MOMENTS] = {
        { 0, 1.0 }, { 0, TWO }, { 1, -0.5 * TWO }, { 2, 0.5 * TWO }
    };
    for (int i = 0; i < beams * views; i++) {
        int b = i / views, v = i % views;
        for (int m = 0; m < PEL_MOMENTS; m++) {
            double sum = 0.0;
            for (int k = 0; k < PLANES; k++) {
                sum += w->weight[k] * w->light[m][k][b] * w->eye[m][k][v];
            }
            out[moments[m].mode * beams * views + i] +=
                strength / (4.0 * PEL_PI * view_mu[v]) * moments[m].factor *
                sum;
        }
    }
}

static enum pel_err moments(struct pel_ordinates *o,
                            const struct pel_medium *medium, const double *mu,
                            int count, const struct work *w,
                            double to[PEL_MOMENTS][PLANES][BEAMS])
{
    double found[PEL_MOMENTS * PLANES * BEAMS];
    enum pel_err err =
        pel_ordinates_moments(o, medium, mu, count, w->depth, PLANES, found);
    for (int i = 0; i < PEL_MOMENTS * PLANES && !err; i++) {
        memcpy(to[i / PLANES][i % PLANES], found + i * count,
               (size_t)count * sizeof *found);
    }
    return err;
}

enum pel_err pel_raman_respond(struct pel_ordinates *o,
                               const struct pel_medium *medium,
                               const struct pel_raman *raman,
                               const double *depths, int levels,
                               const double *mu, int beams,
                               const double *view_mu, int views, double *out)
{
    const int size = PEL_RAMAN_MODES * beams * views;
    struct work *w = malloc(sizeof *w);
    enum pel_err err = w ? PEL_OK : PEL_ERR_NO_MEMORY;
    memset(out, 0, (size_t)(levels * size) * sizeof *out);
    for (int i = 0; i < levels && !err; i++) {
        struct pel_medium to = *medium, from = raman->from;
        to.depth_m = from.depth_m = depths[i];
        place_planes(&to, &from, depths[i], w);
        err = moments(o, &from, mu, beams, w, w->light);
        if (!err) {
            err = moments(o, &to, view_mu, views, w, w->eye);
        }
        if (!err) {
            add_up(w, raman->strength, beams, view_mu, views, out + i * size);
        }
    }
    free(w);
    return err;
}
