#include "optics/ordinates.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/vec.h"
#include "optics/brdf.h"
#include "optics/linear.h"

#define N_MAX (2 * PEL_ORDINATES_MAX) /* directions in each hemisphere */
#define BACK_CELLS 512 /* of the phase function from −1 to BACK_TO */
#define BACK_TO 0.25   /* turned by more than two critical angles */

struct pel_ordinates {
    int nodes; /* in each range */
    int n;     /* directions in each hemisphere; the first `nodes` leave */
    int terms; /* of the phase function */
    double tolerance;
    double mu[N_MAX], weight[N_MAX];
    double reflected[N_MAX]; /* by the surface, from below */
    double air_mu[PEL_ORDINATES_MAX];
    /* The phase function last met. */
    struct pel_phase phase;
    double chi[N_MAX + 1];
    double back[BACK_CELLS + 2];
    /* One mode's work. */
    double moment[N_MAX];          /* (2l + 1) χ_l */
    double legendre[N_MAX][N_MAX]; /* [l][direction] */
    double odd[N_MAX * N_MAX], even[N_MAX * N_MAX];
    double vectors[N_MAX * N_MAX];
    double k[N_MAX];
    double sum[N_MAX * N_MAX], difference[N_MAX * N_MAX]; /* S and D */
    double matrix[4 * N_MAX * N_MAX], right[2 * N_MAX];
    int pivot[2 * N_MAX];
    /* e^(−λτ) times these solves the equation with the Sun's source. */
    double beam_sum[N_MAX], beam_difference[N_MAX];
};

/* One medium and light in the scaled problem. */
struct problem {
    double omega, tau; /* scaled albedo and depth */
    double peak;
    double albedo;
    double sun_mu, rate; /* rate = 1 / sun_mu, moved off every eigenvalue */
    double beam;
    const struct pel_ordinates_light *light;
    int mode;
};

/* Λ_l^m(μ) = √((l−m)!/(l+m)!) P_l^m for l < terms. */
static void legendre(int m, int terms, double mu, double *out, int stride)
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

/* Delta-M: the peak f = χ_terms is taken as not scattered at all. */
static void scale(struct pel_ordinates *o, const struct pel_medium *medium,
                  struct problem *p)
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

/* Eigenvalues k and the matrices that lead from the eigenmodes (σ, δ) to sum
 * and difference of upward and downward radiance: with P and Q the
 * symmetrised operators of the odd and even terms, P = C Cᵀ,
 * Cᵀ Q C = V k² Vᵀ, S = T⁻¹ C V, D = T⁻¹ C⁻ᵀ V, T = √(μ w). Then
 * σ' = δ − V ᵀC⁻¹ q_d, δ' = k² σ − VᵀCᵀ q_s. */
static void eigenmodes(struct pel_ordinates *o, const struct problem *p)
{
    int n = o->n;
    double scaled[N_MAX];
    for (int i = 0; i < n; i++) {
        legendre(p->mode, o->terms, o->mu[i], &o->legendre[0][i], N_MAX);
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

/* The particular solution for the Sun's beam, ∝ e^(−λτ), in eigenmodes. */
static void beam_modes(struct pel_ordinates *o, struct problem *p)
{
    int n = o->n;
    double at_sun[N_MAX], qs[N_MAX], qd[N_MAX];
    legendre(p->mode, o->terms, p->sun_mu, at_sun, 1);
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

/* λ = 1/μ0 may meet an eigenvalue, where the particular solution has a pole
 * that the homogeneous one takes away: a millionth aside both are finite. */
static void leave_resonance(const struct pel_ordinates *o, struct problem *p)
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

/* The 2n equations for what decays from above (first n unknowns) and from
 * below: L₋ = R L₊ + L_in at the surface, a Lambertian bottom. */
static void boundary_matrix(struct pel_ordinates *o, const struct problem *p,
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
static double incoming(const struct pel_ordinates *o, const struct problem *p,
                       int i)
{
    const struct pel_ordinates_light *light = p->light;
    if (!light->sky || i >= o->nodes || p->mode >= light->sky_modes) {
        return 0.0;
    }
    return PEL_WATER_INDEX * PEL_WATER_INDEX * (1.0 - o->reflected[i]) *
           light->sky[p->mode * o->nodes + i];
}

static void boundary_right(struct pel_ordinates *o, const struct problem *p,
                           double albedo)
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

/* ∫₀^τ e^(−k(τ−t)) e^(−t/μ) dt/μ. */
static double from_below(double k, double mu, double tau)
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
                             const struct problem *p, double mu,
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
                            const struct problem *p, double albedo, double mu,
                            const double *moments_s, const double *moments_d)
{
    int n = o->n;
    double at_view[N_MAX];
    legendre(p->mode, o->terms, mu, at_view, 1);
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
        double bottom = from_below(k, mu, p->tau);
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

static void solve_mode(struct pel_ordinates *o, const struct problem *p,
                       double albedo, const double *view_mu, int views,
                       double *out)
{
    int n = o->n;
    boundary_matrix(o, p, albedo);
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

static double largest(const double *v, int count)
{
    double most = 0.0;
    for (int i = 0; i < count; i++) {
        most = fmax(most, fabs(v[i]));
    }
    return most;
}

void pel_ordinates_solve(struct pel_ordinates *o,
                         const struct pel_medium *medium,
                         const struct pel_ordinates_light *light,
                         const double *view_mu, int views, double *out,
                         int *modes, double *dark_bottom)
{
    struct problem p = { .light = light };
    struct pel_geometry geometry = { .sun_zenith_rad = light->sun_zenith_rad };
    struct pel_interface face = pel_interface_at(&geometry);
    scale(o, medium, &p);
    p.sun_mu = face.sun_mu;
    p.beam = light->sun * face.beam;
    int quiet = 0;
    for (p.mode = 0; p.mode < o->terms && quiet < 2; p.mode++) {
        p.rate = 1.0 / p.sun_mu;
        eigenmodes(o, &p);
        leave_resonance(o, &p);
        beam_modes(o, &p);
        if (p.mode == 0 && dark_bottom) {
            solve_mode(o, &p, 0.0, view_mu, views, dark_bottom);
        }
        double *row = out + p.mode * views;
        solve_mode(o, &p, p.albedo, view_mu, views, row);
        /* Modes fall off geometrically; two small ones end the series. */
        quiet = largest(row, views) < o->tolerance * largest(out, views)
                    ? quiet + 1
                    : 0;
        *modes = p.mode + 1;
    }
}

/* Radiance at node i at scaled depth t, of what mode 0's solution holds:
 * eigenmodes from above and from below, and the Sun's particular one. */
static void at_node(const struct pel_ordinates *o, const struct problem *p,
                    double t, int i, double *down, double *up)
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
static double nadir_from(struct pel_ordinates *o, const struct problem *p,
                         double t)
{
    double right[2 * N_MAX], sum[N_MAX], difference[N_MAX];
    struct problem below = *p;
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
    struct problem p = { .light = &light };
    struct pel_geometry geometry = { .sun_zenith_rad = sun_zenith_rad };
    struct pel_interface face = pel_interface_at(&geometry);
    const double straight_up = 1.0;
    double surface;
    scale(o, medium, &p);
    p.sun_mu = face.sun_mu;
    p.beam = face.beam;
    p.rate = 1.0 / p.sun_mu;
    eigenmodes(o, &p);
    leave_resonance(o, &p);
    beam_modes(o, &p);
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

#define BEAMS PEL_ORDINATES_BEAMS

/* What the beams and views of a response share in one mode. */
struct response {
    int beams;
    double rate[BEAMS];               /* 1 / μ, off every eigenvalue */
    double sum[BEAMS][N_MAX];         /* beam_sum and beam_difference */
    double difference[BEAMS][N_MAX];  /* of each beam */
    double total_s[BEAMS][N_MAX];     /* at the nodes, halved */
    double total_d[BEAMS][N_MAX];     /* */
    double view_s[BEAMS][N_MAX];      /* eigenmodes' source at a view */
    double view_d[BEAMS][N_MAX];      /* */
    double beam_source[BEAMS][BEAMS]; /* [beam][view], the beams' own */
    double top[BEAMS][N_MAX];         /* [view][eigenmode] */
    double bottom[BEAMS][N_MAX];      /* */
    double right[2 * N_MAX];
};

static void respond_beams(struct pel_ordinates *o, struct problem *p,
                          const double *mu, struct response *r)
{
    int n = o->n;
    for (int b = 0; b < r->beams; b++) {
        p->sun_mu = mu[b];
        p->rate = 1.0 / mu[b];
        leave_resonance(o, p);
        beam_modes(o, p);
        r->rate[b] = p->rate;
        memcpy(r->sum[b], o->beam_sum, (size_t)n * sizeof(double));
        memcpy(r->difference[b], o->beam_difference,
               (size_t)n * sizeof(double));
        for (int i = 0; i < n; i++) {
            double s = 0.0, d = 0.0;
            for (int j = 0; j < n; j++) {
                s += o->sum[i * n + j] * o->beam_sum[j];
                d += o->difference[i * n + j] * o->beam_difference[j];
            }
            r->total_s[b][i] = 0.5 * s;
            r->total_d[b][i] = 0.5 * d;
        }
    }
}

/* Sources of eigenmodes and beams towards each view; uses up `even`, `odd`. */
static void respond_views(struct pel_ordinates *o, const struct problem *p,
                          const double *mu, struct response *r)
{
    int n = o->n;
    for (int v = 0; v < r->beams; v++) {
        double at_view[N_MAX], weight_s[N_MAX], weight_d[N_MAX];
        legendre(p->mode, o->terms, mu[v], at_view, 1);
        for (int i = 0; i < n; i++) {
            double sum[2] = { 0.0, 0.0 };
            for (int l = p->mode; l < o->terms; l++) {
                sum[(l + p->mode) & 1] +=
                    o->moment[l] * at_view[l] * o->legendre[l][i];
            }
            weight_s[i] = o->weight[i] * sum[0];
            weight_d[i] = o->weight[i] * sum[1];
        }
        memset(r->view_s[v], 0, sizeof r->view_s[v]);
        memset(r->view_d[v], 0, sizeof r->view_d[v]);
        for (int i = 0; i < n; i++) {
            for (int j = 0; j < n; j++) {
                r->view_s[v][j] += weight_s[i] * o->sum[i * n + j];
                r->view_d[v][j] += weight_d[i] * o->difference[i * n + j];
            }
        }
        for (int b = 0; b < r->beams; b++) {
            double source = 0.0;
            for (int j = 0; j < n; j++) {
                source += r->view_s[v][j] * r->sum[b][j] +
                          r->view_d[v][j] * r->difference[b][j];
            }
            r->beam_source[b][v] = source;
        }
    }
}

/* Right side for one beam, as boundary_right without a sky. */
static void respond_right(const struct pel_ordinates *o,
                          const struct problem *p, double albedo, double mu,
                          const struct response *from, int beam, double *right)
{
    int n = o->n;
    double e = exp(-from->rate[beam] * p->tau), down = 0.0;
    for (int i = 0; i < n; i++) {
        double s = from->total_s[beam][i], d = from->total_d[beam][i];
        double r = o->reflected[i];
        right[i] = -((1.0 - r) * s - (1.0 + r) * d);
        right[n + i] = -e * (s + d);
        down += 2.0 * o->weight[i] * o->mu[i] * e * (s - d);
    }
    if (p->mode == 0) {
        down += mu * exp(-p->tau / mu) / PEL_PI;
        for (int i = 0; i < n; i++) {
            right[n + i] += albedo * down;
        }
    }
}

/* What a bottom, equally bright everywhere, sends up. */
static double respond_bottom(const struct pel_ordinates *o,
                             const struct problem *p,
                             const struct response *from, int beam,
                             const double *right)
{
    int n = o->n;
    const double *a = right, *b = right + n;
    double e_beam = exp(-from->rate[beam] * p->tau), up = 0.0;
    for (int j = 0; j < n; j++) {
        double k = o->k[j], e = exp(-k * p->tau);
        up +=
            0.5 * o->sum[j] * (a[j] * e + b[j] + from->sum[beam][j] * e_beam) +
            0.5 * o->difference[j] *
                (k * (b[j] - a[j] * e) + from->difference[beam][j] * e_beam);
    }
    return up;
}

/* Every beam to every view at one depth: out[beam][view]. */
static void respond(struct pel_ordinates *o, const struct problem *p,
                    double albedo, const double *mu, struct response *r,
                    double *out)
{
    int n = o->n;
    for (int v = 0; v < r->beams; v++) {
        for (int j = 0; j < n; j++) {
            double k = o->k[j];
            double s = r->view_s[v][j], d = k * r->view_d[v][j];
            r->top[v][j] = (s - d) * -expm1(-p->tau * (k + 1.0 / mu[v])) /
                           (1.0 + k * mu[v]);
            r->bottom[v][j] = (s + d) * from_below(k, mu[v], p->tau);
        }
    }
    boundary_matrix(o, p, albedo);
    pel_lu_factor(o->matrix, 2 * n, o->pivot);
    for (int b = 0; b < r->beams; b++) {
        respond_right(o, p, albedo, mu[b], r, b, r->right);
        pel_lu_apply(o->matrix, 2 * n, o->pivot, r->right);
        double up = p->mode == 0 && albedo > 0.0
                        ? respond_bottom(o, p, r, b, r->right)
                        : 0.0;
        for (int v = 0; v < r->beams; v++) {
            double total = 0.0, rate = r->rate[b];
            for (int j = 0; j < n; j++) {
                total += r->right[j] * r->top[v][j] +
                         r->right[n + j] * r->bottom[v][j];
            }
            total += r->beam_source[b][v] *
                     -expm1(-p->tau * (rate + 1.0 / mu[v])) /
                     (1.0 + rate * mu[v]);
            out[b * r->beams + v] =
                0.5 * p->omega * total + up * exp(-p->tau / mu[v]);
        }
    }
}

enum pel_err pel_ordinates_respond(struct pel_ordinates *o,
                                   const struct pel_medium *medium,
                                   const double *depths, int levels,
                                   const double *mu, int beams, int modes,
                                   double *dark, double *bottom)
{
    struct response *r = calloc(1, sizeof *r);
    if (!r) {
        return PEL_ERR_NO_MEMORY;
    }
    struct problem p = { .beam = 1.0 };
    struct pel_medium unit = *medium;
    unit.depth_m = 1.0;
    scale(o, &unit, &p);
    double extinction = p.tau, first = 0.0;
    int block = beams * beams, quiet = 0;
    r->beams = beams;
    memset(dark, 0, (size_t)(levels * modes * block) * sizeof *dark);
    memset(bottom, 0, (size_t)(levels * block) * sizeof *bottom);
    for (p.mode = 0; p.mode < modes && p.mode < o->terms && quiet < 2;
         p.mode++) {
        double most = 0.0;
        eigenmodes(o, &p);
        respond_beams(o, &p, mu, r);
        respond_views(o, &p, mu, r);
        for (int i = 0; i < levels; i++) {
            double *to = dark + (i * modes + p.mode) * block;
            p.tau = extinction * depths[i];
            respond(o, &p, 0.0, mu, r, to);
            most = fmax(most, largest(to, block));
            if (p.mode == 0 && p.albedo > 0.0) {
                double *lit = bottom + i * block;
                respond(o, &p, p.albedo, mu, r, lit);
                for (int k = 0; k < block; k++) {
                    lit[k] -= to[k];
                }
            }
        }
        first = p.mode == 0 ? most : first;
        quiet = most < o->tolerance * first ? quiet + 1 : 0;
    }
    free(r);
    return PEL_OK;
}
