#include "optics/ordinates.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/vec.h"
#include "optics/brdf.h"
#include "optics/linear.h"
#include "optics/ordinatesparts.h"

void pel_ordinates_legendre(int m, int terms, double mu, double *out,
                            int stride)
{
    double sine = sqrt(fmax(1.0 - mu * mu, 0.0)), p = 1.0;
    for (int i = 1; i <= m; i++) {
        p *= sine * sqrt((2.0 * i - 1.0) / (2.0 * i));
    }
    double before = 0.0;
    for (int l = 0; l < terms; l++) {
        if (l < m) {
            out[l * stride] = 0.0;
            continue;
        }
        out[l * stride] = p;
        double l1 = l + 1.0;
        double next = ((2.0 * l + 1.0) * mu * p -
                       sqrt((double)l * l - (double)m * m) * before) /
                      sqrt(l1 * l1 - (double)m * m);
        before = p;
        p = next;
    }
}

struct pel_ordinates *pel_ordinates_create(int nodes, double tolerance)
{
    if (nodes < 2 || nodes > PEL_ORDINATES_MAX) {
        return NULL;
    }
    struct pel_ordinates *o = calloc(1, sizeof *o);
    if (!o) {
        return NULL;
    }
    const double n2 = PEL_WATER_INDEX * PEL_WATER_INDEX;
    double critical = sqrt(1.0 - 1.0 / n2);
    o->nodes = nodes;
    o->tolerance = tolerance;
    o->n = 2 * nodes;
    o->terms = 2 * nodes;
    pel_gauss_legendre(nodes, critical, 1.0, o->mu, o->weight);
    pel_gauss_legendre(nodes, 0.0, critical, o->mu + nodes, o->weight + nodes);
    for (int i = 0; i < o->n; i++) {
        o->reflected[i] = 1.0;
        if (i < nodes) {
            o->air_mu[i] = sqrt(1.0 - n2 * (1.0 - o->mu[i] * o->mu[i]));
            o->reflected[i] = pel_fresnel_exact(o->air_mu[i], PEL_WATER_INDEX);
        }
    }
    return o;
}

void pel_ordinates_destroy(struct pel_ordinates *o)
{
    free(o);
}

int pel_ordinates_sky_nodes(const struct pel_ordinates *o)
{
    return o->nodes;
}

double pel_ordinates_sky_node(const struct pel_ordinates *o, int i)
{
    return acos(o->air_mu[i]);
}

double pel_ordinates_sky_irradiance(const struct pel_ordinates *o,
                                    const double *mode0)
{
    /* μ_air dμ_air = n² μ dμ. */
    double sum = 0.0;
    for (int i = 0; i < o->nodes; i++) {
        sum += o->weight[i] * o->mu[i] * mode0[i];
    }
    return 2.0 * PEL_PI * PEL_WATER_INDEX * PEL_WATER_INDEX * sum;
}

/* Moments of a medium's phase function, found once; the share of its peak. */
static double meet(struct pel_ordinates *o, const struct pel_medium *m)
{
    if (o->chi[0] < 0.5 || o->phase.molecular != m->molecular ||
        o->phase.asymmetry != m->asymmetry || o->phase.back != m->back) {
        o->phase = pel_medium_phase(m);
        pel_phase_moments(&o->phase, o->terms + 1, o->chi);
        for (int i = 0; i <= BACK_CELLS + 1; i++) {
            o->back[i] = pel_phase_at(&o->phase,
                                      -1.0 + (1.0 + BACK_TO) * i / BACK_CELLS);
        }
    }
    return o->chi[o->terms];
}

/* The phase function past 80°, between its samples to 1e-5 of it. */
static double phase_back(const struct pel_ordinates *o, double nu)
{
    double at = fmax(nu + 1.0, 0.0) * (BACK_CELLS / (1.0 + BACK_TO));
    int i = (int)fmin(at, BACK_CELLS);
    return o->back[i] + (at - i) * (o->back[i + 1] - o->back[i]);
}

double pel_ordinates_extinction(struct pel_ordinates *o,
                                const struct pel_medium *medium)
{
    return medium->absorption + medium->scattering * (1.0 - meet(o, medium));
}

double pel_ordinates_single(struct pel_ordinates *o,
                            const struct pel_medium *medium, double beam,
                            double sun_mu, double view_mu, double scatter_nu)
{
    double c = pel_ordinates_extinction(o, medium);
    double rate = c * (1.0 / sun_mu + 1.0 / view_mu);
    return beam * medium->scattering * pel_phase_at(&o->phase, scatter_nu) *
           -expm1(-rate * medium->depth_m) / (rate * view_mu);
}

void pel_ordinates_scale(struct pel_ordinates *o,
                         const struct pel_medium *medium,
                         struct pel_ordinates_problem *p)
{
    double f = meet(o, medium);
    double a = medium->absorption, b = medium->scattering * (1.0 - f);
    p->peak = f;
    p->omega = b / (a + b);
    p->tau = (a + b) * medium->depth_m;
    p->albedo = medium->albedo;
    for (int l = 0; l < o->terms; l++) {
        o->moment[l] = (2.0 * l + 1.0) * (o->chi[l] - f) / (1.0 - f);
    }
}

void pel_ordinates_eigenmodes(struct pel_ordinates *o,
                              const struct pel_ordinates_problem *p)
{
    int n = o->n;
    double scaled[N_MAX];
    for (int i = 0; i < n; i++) {
        pel_ordinates_legendre(p->mode, o->terms, o->mu[i], &o->legendre[0][i],
                               N_MAX);
        scaled[i] = sqrt(o->weight[i] / o->mu[i]);
    }
    for (int i = 0; i < n; i++) {
        for (int j = 0; j <= i; j++) {
            double sum[2] = { 0.0, 0.0 };
            for (int l = p->mode; l < o->terms; l++) {
                sum[(l + p->mode) & 1] +=
                    o->moment[l] * o->legendre[l][i] * o->legendre[l][j];
            }
            double s = p->omega * scaled[i] * scaled[j];
            double one = i == j ? 1.0 / o->mu[i] : 0.0;
            o->even[i * n + j] = o->even[j * n + i] = one - s * sum[0];
            o->odd[i * n + j] = o->odd[j * n + i] = one - s * sum[1];
        }
    }
    pel_cholesky(o->odd, n);
    pel_congruence(o->even, o->odd, n, o->matrix);
    pel_symmetric_eigen(o->matrix, n, o->k, o->vectors);
    for (int i = 0; i < n; i++) {
        o->k[i] = sqrt(fmax(o->k[i], 1e-12));
    }
    pel_lower_times(o->odd, o->vectors, n, o->sum);
    pel_upper_solve(o->odd, o->vectors, n, o->difference);
    for (int i = 0; i < n; i++) {
        double t = 1.0 / sqrt(o->mu[i] * o->weight[i]);
        for (int j = 0; j < n; j++) {
            o->sum[i * n + j] *= t;
            o->difference[i * n + j] *= t;
        }
    }
}

void pel_ordinates_beam_modes(struct pel_ordinates *o,
                              struct pel_ordinates_problem *p)
{
    int n = o->n;
    double at_sun[N_MAX], qs[N_MAX], qd[N_MAX];
    pel_ordinates_legendre(p->mode, o->terms, p->sun_mu, at_sun, 1);
    double strength =
        p->omega * p->beam / (4.0 * PEL_PI) * (p->mode ? 2.0 : 1.0);
    for (int i = 0; i < n; i++) {
        double sum[2] = { 0.0, 0.0 };
        for (int l = p->mode; l < o->terms; l++) {
            sum[(l + p->mode) & 1] +=
                o->moment[l] * o->legendre[l][i] * at_sun[l];
        }
        double t = strength * sqrt(o->weight[i] / o->mu[i]);
        qs[i] = 2.0 * sum[0] * t;
        qd[i] = -2.0 * sum[1] * t;
    }
    /* ps = VᵀCᵀ qs = (S T)ᵀ qs, pd = VᵀC⁻¹ qd = (D T)ᵀ qd. */
    for (int j = 0; j < n; j++) {
        double ps = 0.0, pd = 0.0;
        for (int i = 0; i < n; i++) {
            double t = sqrt(o->mu[i] * o->weight[i]);
            ps += o->sum[i * n + j] * t * qs[i];
            pd += o->difference[i * n + j] * t * qd[i];
        }
        double apart = p->rate * p->rate - o->k[j] * o->k[j];
        o->beam_sum[j] = (p->rate * pd - ps) / apart;
        o->beam_difference[j] = pd - p->rate * o->beam_sum[j];
    }
}

void pel_ordinates_leave_resonance(const struct pel_ordinates *o,
                                   struct pel_ordinates_problem *p)
{
    for (int tries = 0; tries < 3; tries++) {
        bool near = false;
        for (int j = 0; j < o->n; j++) {
            near = near || fabs(p->rate - o->k[j]) < 1e-6 * p->rate;
        }
        if (!near) {
            return;
        }
        p->rate *= 1.0 + 3e-6;
    }
}

void pel_ordinates_boundary(struct pel_ordinates *o,
                            const struct pel_ordinates_problem *p,
                            double albedo)
{
    int n = o->n;
    double *m = o->matrix;
    for (int j = 0; j < n; j++) {
        double k = o->k[j], e = exp(-k * p->tau);
        double down_a = 0.0, down_b = 0.0; /* irradiance over π at the bottom */
        for (int i = 0; i < n; i++) {
            double s = 0.5 * o->sum[i * n + j];
            double d = 0.5 * k * o->difference[i * n + j];
            double r = o->reflected[i];
            m[i * 2 * n + j] = (1.0 - r) * s + (1.0 + r) * d;
            m[i * 2 * n + n + j] = e * ((1.0 - r) * s - (1.0 + r) * d);
            m[(n + i) * 2 * n + j] = e * (s - d);
            m[(n + i) * 2 * n + n + j] = s + d;
            double w = 2.0 * o->weight[i] * o->mu[i];
            down_a += w * e * (s + d);
            down_b += w * (s - d);
        }
        if (p->mode == 0) {
            for (int i = 0; i < n; i++) {
                m[(n + i) * 2 * n + j] -= albedo * down_a;
                m[(n + i) * 2 * n + n + j] -= albedo * down_b;
            }
        }
    }
}

/* Mode of the skylight that has come through the surface at node i. */
static double incoming(const struct pel_ordinates *o,
                       const struct pel_ordinates_problem *p, int i)
{
    const struct pel_ordinates_light *light = p->light;
    if (!light->sky || i >= o->nodes || p->mode >= light->sky_modes) {
        return 0.0;
    }
    return PEL_WATER_INDEX * PEL_WATER_INDEX * (1.0 - o->reflected[i]) *
           light->sky[p->mode * o->nodes + i];
}

static void boundary_right(struct pel_ordinates *o,
                           const struct pel_ordinates_problem *p, double albedo)
{
    int n = o->n;
    double e = exp(-p->rate * p->tau), down = 0.0;
    for (int i = 0; i < n; i++) {
        double s = 0.0, d = 0.0;
        for (int j = 0; j < n; j++) {
            s += 0.5 * o->sum[i * n + j] * o->beam_sum[j];
            d += 0.5 * o->difference[i * n + j] * o->beam_difference[j];
        }
        double r = o->reflected[i];
        o->right[i] = incoming(o, p, i) - ((1.0 - r) * s - (1.0 + r) * d);
        o->right[n + i] = -e * (s + d);
        down += 2.0 * o->weight[i] * o->mu[i] * e * (s - d);
    }
    if (p->mode == 0) {
        down += p->sun_mu * p->beam * exp(-p->tau / p->sun_mu) / PEL_PI;
        for (int i = 0; i < n; i++) {
            o->right[n + i] += albedo * down;
        }
    }
}

double pel_ordinates_from_below(double k, double mu, double tau)
{
    double x = tau * (k - 1.0 / mu);
    if (fabs(x) < 1e-5) {
        return tau / mu * exp(-tau / mu) * (1.0 - 0.5 * x);
    }
    return (exp(-tau / mu) - exp(-k * tau)) / (k * mu - 1.0);
}

/* Skylight scattered once, as pel_ordinates_single does it: the true phase
 * function instead of the terms the eigenmodes know, which ring where the
 * function is small. Light that goes on upwards has turned by more than 84°
 * (two critical angles), and there the function is smooth in azimuth. */
static double sky_correction(const struct pel_ordinates *o,
                             const struct pel_ordinates_problem *p, double mu,
                             const double *at_view)
{
    enum { AZIMUTHS = 24 };
    double total = 0.0, sine = sqrt(1.0 - mu * mu);
    for (int i = 0; i < o->nodes; i++) {
        double known = 0.0, whole = 0.0, sign = 1.0;
        for (int l = p->mode; l < o->terms; l++) {
            known += sign * o->moment[l] * at_view[l] * o->legendre[l][i];
            sign = -sign;
        }
        double m = o->mu[i], across = sine * sqrt(1.0 - m * m);
        for (int j = 0; j < AZIMUTHS; j++) {
            double azimuth = PEL_PI * (j + 0.5) / AZIMUTHS;
            whole += phase_back(o, across * cos(azimuth) - mu * m) *
                     cos(p->mode * azimuth);
        }
        whole *= 4.0 * PEL_PI / AZIMUTHS / (1.0 - p->peak);
        total += o->weight[i] * incoming(o, p, i) * (whole - known) *
                 -expm1(-p->tau * (1.0 / mu + 1.0 / m)) / (1.0 + mu / m);
    }
    return total;
}

/* Radiance up just below the surface at one view: the source function, a sum
 * of exponentials, integrated along the line of sight. */
static double view_radiance(const struct pel_ordinates *o,
                            const struct pel_ordinates_problem *p,
                            double albedo, double mu, const double *moments_s,
                            const double *moments_d)
{
    int n = o->n;
    double at_view[N_MAX];
    pel_ordinates_legendre(p->mode, o->terms, mu, at_view, 1);
    const double *a = o->right, *b = o->right + n;
    double beam = -expm1(-p->tau * (p->rate + 1.0 / mu)) / (1.0 + p->rate * mu);
    double total = 0.0;
    for (int j = 0; j < n; j++) {
        double s = 0.0, d = 0.0;
        for (int l = p->mode; l < o->terms; l++) {
            double v = o->moment[l] * at_view[l];
            if ((l + p->mode) & 1) {
                d += v * moments_d[l * n + j];
            } else {
                s += v * moments_s[l * n + j];
            }
        }
        double k = o->k[j];
        double top = -expm1(-p->tau * (k + 1.0 / mu)) / (1.0 + k * mu);
        double bottom = pel_ordinates_from_below(k, mu, p->tau);
        total += a[j] * (s - k * d) * top + b[j] * (s + k * d) * bottom +
                 (s * o->beam_sum[j] + d * o->beam_difference[j]) * beam;
    }
    if (p->light->sky) {
        total += sky_correction(o, p, mu, at_view);
    }
    total *= 0.5 * p->omega;
    if (p->mode == 0 && albedo > 0.0) {
        /* A Lambertian bottom is equally bright at every node. */
        double e_beam = exp(-p->rate * p->tau), up = 0.0;
        for (int j = 0; j < n; j++) {
            double k = o->k[j], e = exp(-k * p->tau);
            up +=
                0.5 * o->sum[j] * (a[j] * e + b[j] + o->beam_sum[j] * e_beam) +
                0.5 * o->difference[j] *
                    (k * (b[j] - a[j] * e) + o->beam_difference[j] * e_beam);
        }
        total += up * exp(-p->tau / mu);
    }
    return total;
}

static void solve_mode(struct pel_ordinates *o,
                       const struct pel_ordinates_problem *p, double albedo,
                       const double *view_mu, int views, double *out)
{
    int n = o->n;
    pel_ordinates_boundary(o, p, albedo);
    boundary_right(o, p, albedo);
    pel_lu_solve(o->matrix, 2 * n, o->pivot, o->right);
    /* Moments of the eigenmodes: even terms see the sum, odd the difference.
     * `even` and `odd` are free by now. */
    double *moments_s = o->even, *moments_d = o->odd;
    for (int l = p->mode; l < o->terms; l++) {
        const double *from = (l + p->mode) & 1 ? o->difference : o->sum;
        double *to = ((l + p->mode) & 1 ? moments_d : moments_s) + l * n;
        memset(to, 0, (size_t)n * sizeof *to);
        for (int i = 0; i < n; i++) {
            double w = o->weight[i] * o->legendre[l][i];
            for (int j = 0; j < n; j++) {
                to[j] += w * from[i * n + j];
            }
        }
    }
    for (int v = 0; v < views; v++) {
        out[v] = view_radiance(o, p, albedo, view_mu[v], moments_s, moments_d);
    }
}

void pel_ordinates_solve(struct pel_ordinates *o,
                         const struct pel_medium *medium,
                         const struct pel_ordinates_light *light,
                         const double *view_mu, int views, double *out,
                         int *modes, double *dark_bottom)
{
    struct pel_ordinates_problem p = { .light = light };
    struct pel_geometry geometry = { .sun_zenith_rad = light->sun_zenith_rad };
    struct pel_interface face = pel_interface_at(&geometry);
    pel_ordinates_scale(o, medium, &p);
    p.sun_mu = face.sun_mu;
    p.beam = light->sun * face.beam;
    int quiet = 0;
    for (p.mode = 0; p.mode < o->terms && quiet < 2; p.mode++) {
        p.rate = 1.0 / p.sun_mu;
        pel_ordinates_eigenmodes(o, &p);
        pel_ordinates_leave_resonance(o, &p);
        pel_ordinates_beam_modes(o, &p);
        if (p.mode == 0 && dark_bottom) {
            solve_mode(o, &p, 0.0, view_mu, views, dark_bottom);
        }
        double *row = out + p.mode * views;
        solve_mode(o, &p, p.albedo, view_mu, views, row);
        /* Modes fall off geometrically; two small ones end the series. */
        quiet = pel_ordinates_largest(row, views) <
                        o->tolerance * pel_ordinates_largest(out, views)
                    ? quiet + 1
                    : 0;
        *modes = p.mode + 1;
    }
}

/* Radiance at node i at scaled depth t, of what mode 0's solution holds:
 * eigenmodes from above and from below, and the Sun's particular one. */
static void at_node(const struct pel_ordinates *o,
                    const struct pel_ordinates_problem *p, double t, int i,
                    double *down, double *up)
{
    const double *a = o->right, *b = o->right + o->n;
    double e_beam = exp(-p->rate * t);
    *down = *up = 0.0;
    for (int j = 0; j < o->n; j++) {
        double k = o->k[j], s = 0.5 * o->sum[i * o->n + j];
        double d = 0.5 * o->difference[i * o->n + j];
        double from_a = a[j] * exp(-k * t);
        double from_b = b[j] * exp(-k * (p->tau - t));
        double beam_s = s * o->beam_sum[j] * e_beam;
        double beam_d = d * o->beam_difference[j] * e_beam;
        *down += from_a * (s + k * d) + from_b * (s - k * d) + beam_s - beam_d;
        *up += from_a * (s - k * d) + from_b * (s + k * d) + beam_s + beam_d;
    }
}

/* The solution seen from scaled depth t, as if the surface were there. */
static double nadir_from(struct pel_ordinates *o,
                         const struct pel_ordinates_problem *p, double t)
{
    double right[2 * N_MAX], sum[N_MAX], difference[N_MAX];
    struct pel_ordinates_problem below = *p;
    int n = o->n;
    memcpy(right, o->right, sizeof right);
    memcpy(sum, o->beam_sum, sizeof sum);
    memcpy(difference, o->beam_difference, sizeof difference);
    below.tau = p->tau - t;
    for (int j = 0; j < n; j++) {
        o->right[j] *= exp(-o->k[j] * t);
        o->beam_sum[j] *= exp(-p->rate * t);
        o->beam_difference[j] *= exp(-p->rate * t);
    }
    double seen = view_radiance(o, &below, p->albedo, 1.0, o->even, o->odd);
    memcpy(o->right, right, sizeof right);
    memcpy(o->beam_sum, sum, sizeof sum);
    memcpy(o->beam_difference, difference, sizeof difference);
    return seen;
}

void pel_ordinates_field(struct pel_ordinates *o,
                         const struct pel_medium *medium, double sun_zenith_rad,
                         const double *depths_m, int count,
                         struct pel_field *out)
{
    const struct pel_ordinates_light light = { .sun_zenith_rad =
                                                   sun_zenith_rad };
    struct pel_ordinates_problem p = { .light = &light };
    struct pel_geometry geometry = { .sun_zenith_rad = sun_zenith_rad };
    struct pel_interface face = pel_interface_at(&geometry);
    const double straight_up = 1.0;
    double surface;
    pel_ordinates_scale(o, medium, &p);
    p.sun_mu = face.sun_mu;
    p.beam = face.beam;
    p.rate = 1.0 / p.sun_mu;
    pel_ordinates_eigenmodes(o, &p);
    pel_ordinates_leave_resonance(o, &p);
    pel_ordinates_beam_modes(o, &p);
    solve_mode(o, &p, p.albedo, &straight_up, 1, &surface);
    double c = p.tau / medium->depth_m;
    for (int k = 0; k < count; k++) {
        double t = c * depths_m[k], sun = p.beam * exp(-t / p.sun_mu);
        struct pel_field f = { .down = p.sun_mu * sun };
        for (int i = 0; i < o->n; i++) {
            double down, up, ring = 2.0 * PEL_PI * o->weight[i];
            at_node(o, &p, t, i, &down, &up);
            f.down += ring * o->mu[i] * down;
            f.up += ring * o->mu[i] * up;
            f.scalar_up += ring * up;
        }
        struct pel_medium rest = *medium;
        rest.depth_m -= depths_m[k];
        f.nadir = nadir_from(o, &p, t) +
                  pel_ordinates_single(o, &rest, sun, p.sun_mu, 1.0, -p.sun_mu);
        out[k] = f;
    }
}
