#include "optics/waterkernel.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/vec.h"
#include "optics/brdf.h"
#include "optics/linear.h"
#include "optics/ordinates.h"

#define N PEL_KERNEL_NODES
#define M PEL_KERNEL_MODES
#define ORDINATES 20
#define N2 (PEL_WATER_INDEX * PEL_WATER_INDEX)

const struct pel_water_sampling pel_water_sampling_default = {
    PEL_SAMPLING_PLANES, PEL_SAMPLING_ZENITHS, PEL_SAMPLING_AZIMUTHS
};

double pel_kernel_sine(int i)
{
    return 0.5 * (1.0 - cos(PEL_PI * i / (N - 1))) / PEL_WATER_INDEX;
}

void pel_kernel_weights(double sine, double weights[N])
{
    /* Barycentric, with the weights of Chebyshev's extremes. */
    double sum = 0.0;
    for (int i = 0; i < N; i++) {
        double apart = sine - pel_kernel_sine(i);
        if (fabs(apart) < 1e-12) {
            memset(weights, 0, N * sizeof *weights);
            weights[i] = 1.0;
            return;
        }
        double end = i == 0 || i == N - 1 ? 0.5 : 1.0;
        weights[i] = (i % 2 ? -end : end) / apart;
        sum += weights[i];
    }
    for (int i = 0; i < N; i++) {
        weights[i] /= sum;
    }
}

static void node_cosines(double mu[N])
{
    for (int i = 0; i < N; i++) {
        double sine = pel_kernel_sine(i);
        mu[i] = sqrt(1.0 - sine * sine);
    }
}

/* Modes of p at a scattering angle of cosine `level` + `across` cos φ, as the
 * midpoint rule on half a circle finds them. */
static void phase_modes(const struct pel_phase_split *p, double level,
                        double across, int azimuths, double out[M])
{
    memset(out, 0, M * sizeof *out);
    for (int j = 0; j < azimuths; j++) {
        double x = cos(PEL_PI * (j + 0.5) / azimuths);
        double value = pel_phase_rest(p, level + across * x) / azimuths;
        double before = x, now = 1.0;
        for (int m = 0; m < M; m++) {
            out[m] += (m ? 2.0 : 1.0) * value * now;
            double next = 2.0 * x * now - before;
            before = now;
            now = next;
        }
    }
}

/* Single scattering below the surface over b p, for extinction c. */
static double single_path(double c, double depth, double sun_mu, double view_mu)
{
    double rate = c * (1.0 / sun_mu + 1.0 / view_mu);
    return -expm1(-rate * depth) / (rate * view_mu);
}

struct work {
    double mu[N];
    double phase[N][N][M]; /* back from beam to view */
    double dark[PEL_WATER_LEVELS_MAX * M * N * N];
    double bottom[PEL_WATER_LEVELS_MAX * N * N];
    double raman[PEL_WATER_LEVELS_MAX * PEL_RAMAN_MODES * N * N];
};

/* Adds single scattering to `single`, and to `beyond` what the solver's way
 * of it has over the true one. */
static void put_single(const struct pel_medium *m, const struct work *w,
                       double scaled, enum pel_water_orders orders,
                       int wavelength, struct pel_water_kernel *out)
{
    double c = m->absorption + m->scattering, true_c = c;
    if (pel_orders_extinction(orders) == PEL_EXTINCTION_REDUCED) {
        true_c -= m->scattering * pel_medium_forward(m);
    }
    for (int i = 0; i < N * N; i++) {
        int b = i / N, v = i % N;
        double path = single_path(true_c, m->depth_m, w->mu[b], w->mu[v]);
        double more =
            single_path(scaled, m->depth_m, w->mu[b], w->mu[v]) - path;
        for (int k = 0; k < M; k++) {
            double beta = m->scattering * w->phase[b][v][k] / N2;
            out->response[PEL_KERNEL_SINGLE][k][b][v][wavelength] =
                (float)(beta * path);
            if (orders == PEL_ORDERS_ALL) {
                out->response[PEL_KERNEL_BEYOND][k][b][v][wavelength] +=
                    (float)(beta * more);
            }
        }
    }
}

/* Sunlight straight to the bottom and back, which the solver's answer holds as
 * well: it falls too steeply for the nodes where little is left of the light.
 */
static void put_straight(const struct pel_medium *m, const struct work *w,
                         enum pel_water_orders orders, int wavelength,
                         struct pel_water_kernel *out)
{
    double c = m->absorption + m->scattering;
    for (int i = 0; i < N * N; i++) {
        int b = i / N, v = i % N;
        double way = 1.0 / w->mu[b] + 1.0 / w->mu[v];
        double light =
            m->albedo / PEL_PI * w->mu[b] * exp(-c * m->depth_m * way) / N2;
        float *all = &out->response[PEL_KERNEL_BOTTOM][0][b][v][wavelength];
        if (orders == PEL_ORDERS_ALL) {
            *all = (float)fmax((double)*all - light, 0.0);
        }
        out->response[PEL_KERNEL_STRAIGHT][0][b][v][wavelength] = (float)light;
    }
}

static enum pel_err put_orders(struct pel_ordinates *o,
                               const struct pel_medium *m, const double *depths,
                               int levels, struct work *w, int wavelength,
                               struct pel_water_kernel *out)
{
    enum pel_err err = pel_ordinates_respond(o, m, depths, levels, w->mu, N, M,
                                             w->dark, w->bottom);
    for (int k = 0; k < levels && !err; k++) {
        float(*beyond)[N][N][4] = out[k].response[PEL_KERNEL_BEYOND];
        float(*bottom)[N][4] = out[k].response[PEL_KERNEL_BOTTOM][0];
        for (int i = 0; i < N * N; i++) {
            for (int mode = 0; mode < M; mode++) {
                beyond[mode][i / N][i % N][wavelength] =
                    (float)(w->dark[(k * M + mode) * N * N + i] / N2);
            }
            bottom[i / N][i % N][wavelength] =
                (float)(w->bottom[k * N * N + i] / N2);
        }
    }
    return err;
}

/* Light of a shorter wave goes with that of the higher orders. */
static enum pel_err put_raman(struct pel_ordinates *o,
                              const struct pel_medium *m,
                              const struct pel_raman *raman,
                              const double *depths, int levels, struct work *w,
                              int wavelength, struct pel_water_kernel *out)
{
    if (raman->strength == 0.0) {
        return PEL_OK;
    }
    enum pel_err err = pel_raman_respond(o, m, raman, depths, levels, w->mu, N,
                                         w->mu, N, w->raman);
    for (int i = 0; i < levels * PEL_RAMAN_MODES * N * N && !err; i++) {
        int k = i / (PEL_RAMAN_MODES * N * N),
            mode = i / (N * N) % PEL_RAMAN_MODES;
        out[k]
            .response[PEL_KERNEL_BEYOND][mode][i / N % N][i % N][wavelength] +=
            (float)(w->raman[i] / N2);
    }
    return err;
}

static enum pel_err build(struct pel_ordinates *o,
                          const struct pel_water_body *body,
                          const struct pel_water_depths *depths,
                          enum pel_water_orders orders, int wavelength,
                          struct work *w, struct pel_water_kernel *out)
{
    double at[PEL_WATER_LEVELS_MAX];
    struct pel_medium m = pel_water_medium(body, wavelength);
    struct pel_phase whole = pel_medium_phase(&m);
    struct pel_phase_split split = pel_phase_split(&whole);
    for (int b = 0; b < N; b++) {
        for (int v = 0; v <= b; v++) {
            phase_modes(&split, -w->mu[b] * w->mu[v],
                        pel_kernel_sine(b) * pel_kernel_sine(v), 24,
                        w->phase[b][v]);
            memcpy(w->phase[v][b], w->phase[b][v], sizeof w->phase[b][v]);
        }
    }
    for (int k = 0; k < depths->levels; k++) {
        at[k] = pel_water_depth(depths, k);
    }
    enum pel_err err = PEL_OK;
    if (orders == PEL_ORDERS_ALL) {
        err = put_orders(o, &m, at, depths->levels, w, wavelength, out);
    }
    if (orders == PEL_ORDERS_ALL && !err) {
        err = put_raman(o, &m, &body->raman[wavelength], at, depths->levels, w,
                        wavelength, out);
    }
    double scaled = pel_ordinates_extinction(o, &m);
    for (int k = 0; k < depths->levels && !err; k++) {
        m.depth_m = at[k];
        put_single(&m, w, scaled, orders, wavelength, &out[k]);
        put_straight(&m, w, orders, wavelength, &out[k]);
    }
    return err;
}

enum pel_err pel_water_kernel_build(const struct pel_water_body *body,
                                    const struct pel_water_depths *depths,
                                    enum pel_water_orders orders,
                                    struct pel_water_kernel *out)
{
    struct pel_ordinates *o = pel_ordinates_create(ORDINATES, 1e-5);
    struct work *w = malloc(sizeof *w);
    enum pel_err err = o && w ? PEL_OK : PEL_ERR_NO_MEMORY;
    memset(out, 0, (size_t)depths->levels * sizeof *out);
    if (!err) {
        node_cosines(w->mu);
    }
    for (int i = 0; i < PEL_WATER_WAVELENGTHS && !err; i++) {
        err = build(o, body, depths, orders, i, w, out);
    }
    pel_ordinates_destroy(o);
    free(w);
    return err;
}

/* --- second order --------------------------------------------------------- */

double pel_sampling_plane(const struct pel_medium *m, int planes, int k,
                          double *weight)
{
    double node[PEL_SAMPLING_PLANES_MAX], part[PEL_SAMPLING_PLANES_MAX];
    pel_gauss_legendre(planes, 0.0, 1.0, node, part);
    /* Light that travels all but level changes within a thin layer under the
     * surface and above the bottom: the planes gather there. */
    double t = node[k], u = t * t * (3.0 - 2.0 * t);
    /* Half way between the straightest and the longest way in and out. */
    double rate = 2.4 * (m->absorption + m->scattering);
    double reach = -expm1(-rate * m->depth_m);
    *weight =
        part[k] * 6.0 * t * (1.0 - t) * reach / (rate * (1.0 - u * reach));
    return -log1p(-u * reach) / rate;
}

/* Σ over the planes of attenuation towards the view and first order from
 * direction mu (> 0 downward), over β E [m²]. */
static double planes_sum(const struct pel_medium *m, const double *depth,
                         const double *weight, int planes, double sun_mu,
                         double view_mu, double mu)
{
    double c = m->absorption + m->scattering, sum = 0.0;
    for (int k = 0; k < planes; k++) {
        sum += weight[k] * exp(-c * depth[k] / view_mu) *
               pel_transport_first_path(m, sun_mu, depth[k], mu);
    }
    return sum;
}

/* Depth integral of the second order for light that the first scattering
 * sends in a direction of cosine `mu`. */
static double second_path(const struct pel_medium *m,
                          const struct pel_water_sampling *s,
                          const double *depth, const double *part,
                          double sun_mu, double view_mu, double mu)
{
    return s->planes
               ? planes_sum(m, depth, part, s->planes, sun_mu, view_mu, mu)
               : pel_transport_second_path(m, sun_mu, view_mu, mu);
}

/* Once by the phase function's peak, before or after: straight on. */
static void add_peak(const struct pel_medium *m,
                     const struct pel_water_sampling *s,
                     const struct pel_phase_split *split, const double mu[N],
                     const double *depth, const double *part,
                     double out[M][N][N])
{
    for (int n = 0; n < N * N && split->peak > 0.0; n++) {
        int b = n / N, v = n % N;
        double phase[M];
        phase_modes(split, -mu[b] * mu[v],
                    pel_kernel_sine(b) * pel_kernel_sine(v), s->azimuths,
                    phase);
        double sum = second_path(m, s, depth, part, mu[b], mu[v], mu[b]) +
                     second_path(m, s, depth, part, mu[b], mu[v], -mu[v]);
        sum *= split->peak * m->scattering * m->scattering / (N2 * mu[v]);
        for (int k = 0; k < M; k++) {
            out[k][b][v] += sum * phase[k];
        }
    }
}

void pel_kernel_second(const struct pel_medium *m,
                       const struct pel_water_sampling *s, double out[M][N][N])
{
    struct pel_phase whole = pel_medium_phase(m);
    struct pel_phase_split split = pel_phase_split(&whole);
    double mu[N], zenith[PEL_SAMPLING_ZENITHS_MAX];
    double weight[PEL_SAMPLING_ZENITHS_MAX];
    double depth[PEL_SAMPLING_PLANES_MAX], part[PEL_SAMPLING_PLANES_MAX];
    node_cosines(mu);
    pel_gauss_legendre(s->zeniths, 0.0, 1.0, zenith, weight);
    for (int k = 0; k < s->planes; k++) {
        depth[k] = pel_sampling_plane(m, s->planes, k, &part[k]);
    }
    memset(out, 0, M * sizeof *out);
    add_peak(m, s, &split, mu, depth, part, out);
    for (int i = 0; i < s->zeniths; i++) {
        /* Phase from the beams into a direction that goes down, and its
         * mirror image; the views see them the other way about. */
        double phase[2][N][M];
        double sine = sqrt(1.0 - zenith[i] * zenith[i]);
        for (int n = 0; n < 2 * N; n++) {
            double level = (n / N ? -1.0 : 1.0) * zenith[i] * mu[n % N];
            phase_modes(&split, level, sine * pel_kernel_sine(n % N),
                        s->azimuths, phase[n / N][n % N]);
        }
        for (int n = 0; n < 2 * N * N; n++) {
            int up = n / (N * N), b = n / N % N, v = n % N;
            double down = up ? -zenith[i] : zenith[i];
            double sum = second_path(m, s, depth, part, mu[b], mu[v], down);
            sum *= weight[i] * m->scattering * m->scattering / (N2 * mu[v]);
            for (int k = 0; k < M; k++) {
                out[k][b][v] += (k ? 1.0 : 2.0) * PEL_PI * sum *
                                phase[up][b][k] * phase[!up][v][k];
            }
        }
    }
}
