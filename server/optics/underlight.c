#include "optics/underlight.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/vec.h"
#include "optics/ordinates.h"
#include "optics/waterkernel.h"

#define ORDINATES 12
#define LEVELS PEL_UNDER_LEVELS
#define MODES PEL_UNDER_MODES
#define NODES PEL_UNDER_NODES
#define ROWS PEL_UNDER_ROWS
#define DARK 25.0       /* optical depths of the clearest colour that matter */
#define SHALLOWEST 1e-3 /* sine of the first row */

_Static_assert(NODES <= PEL_ORDINATES_BEAMS, "a beam a node");
_Static_assert(ROWS <= PEL_ORDINATES_VIEWS, "a view a row");

double pel_under_row(int row)
{
    double x = (double)row / (ROWS - 1);
    return fmax(sin(0.5 * PEL_PI * pow(x, PEL_UNDER_POWER)), SHALLOWEST);
}

double pel_under_level(const struct pel_under_medium *m, int i)
{
    double octaves = log2(1.0 + m->last_m / m->step_m);
    return m->step_m * (exp2(octaves * i / (LEVELS - 1)) - 1.0);
}

/* The angle within which the function, less its value there, holds `share`. */
static double peak_angle(const struct pel_phase_table *t, double share)
{
    double low = 0.0, high = PEL_PI;
    for (int i = 0; i < 50; i++) {
        double angle = 0.5 * (low + high), nu = cos(angle), inside = 0.0;
        double edge = pel_phase_look_up(t, nu);
        const int steps = 200;
        for (int k = 0; k < steps; k++) {
            /* Evenly in the root of the angle, as the function rises. */
            double r = (k + 0.5) / steps, a = angle * r * r;
            double ring = 2.0 * PEL_PI * sin(a) * angle * 2.0 * r / steps;
            inside += ring * (pel_phase_look_up(t, cos(a)) - edge);
        }
        if (inside < share) {
            low = angle;
        } else {
            high = angle;
        }
    }
    return 0.5 * (low + high);
}

/* Mean square, over one of two axes, of the angles that it turns light by
 * within an angle beyond what it has at it. */
static double peak_square(const struct pel_phase_table *t, double angle)
{
    double edge = pel_phase_look_up(t, cos(angle)), sum = 0.0, square = 0.0;
    const int steps = 400;
    for (int k = 0; k < steps; k++) {
        double r = (k + 0.5) / steps, a = angle * r * r;
        double share = sin(a) * r * (pel_phase_look_up(t, cos(a)) - edge);
        sum += share;
        square += share * a * a;
    }
    return 0.5 * square / fmax(sum, 1e-12);
}

static void put_turns(const struct pel_phase_table *t, double angle,
                      int wavelength, struct pel_under_medium *out)
{
    for (int k = 0; k <= PEL_UNDER_TURNS; k++) {
        double x = (double)k / PEL_UNDER_TURNS, turn = PEL_PI * x * x;
        double rest = pel_phase_look_up(t, cos(fmax(turn, angle)));
        (&out->turns[k].x)[wavelength] = (float)log2(fmax(rest, 1e-12));
    }
}

enum pel_err pel_under_medium_make(const struct pel_water_body *body,
                                   double deepest_m,
                                   struct pel_under_medium *out)
{
    struct pel_ordinates *o = pel_ordinates_create(ORDINATES, 0.0);
    struct pel_phase_table *t = malloc(sizeof *t);
    if (!o || !t) {
        pel_ordinates_destroy(o);
        free(t);
        return PEL_ERR_NO_MEMORY;
    }
    double clearest = HUGE_VAL, murkiest = 0.0;
    *out = (struct pel_under_medium){ .step_m = 1.0 };
    for (int i = 0; i < PEL_WATER_WAVELENGTHS; i++) {
        const struct pel_medium m = pel_water_medium(body, i);
        const struct pel_phase phase = pel_medium_phase(&m);
        double c = m.absorption + m.scattering;
        out->full[i] = c;
        out->scaled[i] = pel_ordinates_extinction(o, &m);
        out->fall[i] = pel_kirk_attenuation(m.absorption, m.scattering);
        out->peak[i] =
            m.scattering > 0.0 ? (c - out->scaled[i]) / m.scattering : 0.0;
        clearest = fmin(clearest, out->fall[i]);
        murkiest = fmax(murkiest, out->scaled[i]);
        pel_phase_tabulate(&phase, t);
        double angle = peak_angle(t, out->peak[i]);
        if (i == 1) {
            out->peak_rad = angle;
            out->peak_square = peak_square(t, angle);
        }
        put_turns(t, angle, i, out);
    }
    out->step_m = fmin(1.0, 0.5 / murkiest);
    out->last_m = fmax(fmin(deepest_m, DARK / clearest), out->step_m);
    pel_ordinates_destroy(o);
    free(t);
    return PEL_OK;
}

struct work {
    double many[LEVELS * MODES * NODES * 2 * ROWS];
    double once[LEVELS * MODES * NODES * 2 * ROWS];
    double flux[LEVELS * NODES * 2];
};

static enum pel_err build_one(const struct pel_medium *medium,
                              const struct pel_under_medium *u, int i,
                              struct work *w, struct pel_under_kernel *out)
{
    struct pel_ordinates *o = pel_ordinates_create(ORDINATES, 0.0);
    double mu[NODES], view_mu[ROWS], depth[LEVELS], scale[LEVELS];
    if (!o) {
        return PEL_ERR_NO_MEMORY;
    }
    for (int k = 0; k < NODES; k++) {
        double sine = pel_kernel_sine(k);
        mu[k] = sqrt(1.0 - sine * sine);
    }
    for (int k = 0; k < ROWS; k++) {
        view_mu[k] = pel_under_row(k);
    }
    for (int k = 0; k < LEVELS; k++) {
        double least = 1e-4 * u->step_m; /* no way has no light */
        depth[k] = fmax(fmin(pel_under_level(u, k), medium->depth_m), least);
        scale[k] = exp(fmin(u->fall[i] * depth[k], 600.0));
    }
    enum pel_err err =
        pel_ordinates_inside(o, medium, mu, NODES, depth, LEVELS, view_mu, ROWS,
                             MODES, w->many, w->once, w->flux);
    pel_ordinates_destroy(o);
    if (err != PEL_OK) {
        return err;
    }
    float *sun = &out->sun[0][0][0][0][0], *sky = &out->sky[0][0][0][0][0];
    for (int k = 0; k < LEVELS * MODES * NODES * 2 * ROWS; k++) {
        int level = k / (MODES * NODES * 2 * ROWS), row = k % (2 * ROWS);
        double by = scale[level];
        if (row < ROWS) {
            by /= -expm1(-u->scaled[i] * depth[level] / view_mu[row]);
        }
        sun[4 * k + i] = (float)(by * w->many[k]);
        sky[4 * k + i] = (float)(by * (w->many[k] + w->once[k]));
    }
    for (int k = 0; k < LEVELS * NODES; k++) {
        int level = k / NODES, b = k % NODES;
        double beam = mu[b] * exp(-u->scaled[i] * depth[level] / mu[b]);
        for (int side = 0; side < 2; side++) {
            double flux = w->flux[2 * k + side];
            out->flux[level][b][side][i] = (float)(scale[level] * flux);
            out->flux_sky[level][b][side][i] =
                (float)(scale[level] * (flux + (side ? 0.0 : beam)));
        }
    }
    return PEL_OK;
}

enum pel_err pel_under_kernel_build(const struct pel_water_body *body,
                                    const struct pel_under_medium *medium,
                                    double depth_m,
                                    struct pel_under_kernel *out)
{
    struct work *w = malloc(sizeof *w);
    enum pel_err err = w ? PEL_OK : PEL_ERR_NO_MEMORY;
    memset(out, 0, sizeof *out);
    for (int i = 0; i < PEL_WATER_WAVELENGTHS && err == PEL_OK; i++) {
        struct pel_medium m = pel_water_medium(body, i);
        m.depth_m = depth_m;
        err = build_one(&m, medium, i, w, out);
    }
    free(w);
    return err;
}
