#include "optics/facets.h"

#include <math.h>

#include "optics/brdf.h"

#define NODES (PEL_FACET_NODES - 1)
#define SAMPLES 1024
#define REACH 9.0   /* p(9) is 1e-18 */
#define TILTED 0.01 /* mean-square slope, for reflections of tilted facets */

/* Value of the monic orthogonal polynomial of degree n at z by its
 * recurrence p_{j+1} = (z − α_j) p_j − β_j p_{j−1}. */
static double polynomial(int n, double z, const double alpha[3],
                         const double beta[3])
{
    double before = 0.0, here = 1.0;
    for (int j = 0; j < n; j++) {
        double next = (z - alpha[j]) * here - beta[j] * before;
        before = here;
        here = next;
    }
    return here;
}

/* A density of slopes, sampled: z and its weight. */
struct density {
    double from, step;
    double weight[SAMPLES];
};

double pel_facets_fall(double mu)
{
    return 1.2 / (1.0 + mu * mu / 36.0);
}

double pel_facets_escape(double mu, double z)
{
    if (isinf(mu)) {
        return 1.0;
    }
    double eta = mu + 2.0 * z - 2.0 * TILTED * (mu + z) * (1.0 + z * z);
    return pel_escape(eta, mu);
}

static double place(const struct density *d, int i)
{
    return d->from + (i + 0.5) * d->step;
}

/* Stieltjes' procedure. */
static void recurrence(const struct density *d, double alpha[3], double beta[3],
                       double *mass)
{
    double norm_before = 1.0;
    for (int n = 0; n < NODES; n++) {
        double norm = 0.0, first = 0.0;
        for (int i = 0; i < SAMPLES; i++) {
            double z = place(d, i), p = polynomial(n, z, alpha, beta);
            norm += d->weight[i] * p * p;
            first += d->weight[i] * z * p * p;
        }
        alpha[n] = first / norm;
        beta[n] = n > 0 ? norm / norm_before : 0.0;
        norm_before = norm;
        if (n == 0) {
            *mass = norm;
        }
    }
}

static void quadrature(const struct density *d, double node[NODES],
                       double weight[NODES])
{
    double alpha[3], beta[3], mass = 0.0;
    recurrence(d, alpha, beta, &mass);
    /* Roots of the cubic p_3 = z³ + a z² + b z + c, all real. */
    double a = -(alpha[0] + alpha[1] + alpha[2]);
    double b = alpha[0] * alpha[1] + alpha[0] * alpha[2] + alpha[1] * alpha[2] -
               beta[1] - beta[2];
    double c = -alpha[0] * alpha[1] * alpha[2] + beta[1] * alpha[2] +
               beta[2] * alpha[0];
    double q = fmax((a * a - 3.0 * b) / 9.0, 0.0);
    double r = (2.0 * a * a * a - 9.0 * a * b + 27.0 * c) / 54.0;
    double angle = acos(pel_clamp(r / sqrt(q * q * q), -1.0, 1.0));
    for (int k = 0; k < 3; k++) {
        node[k] = -2.0 * sqrt(q) * cos((angle + 2.0 * PEL_PI * (k - 2)) / 3.0) -
                  a / 3.0;
    }
    for (int k = 0; k < 2; k++) {
        for (int j = 0; j < 2 - k; j++) {
            if (node[j] > node[j + 1]) {
                double t = node[j];
                node[j] = node[j + 1];
                node[j + 1] = t;
            }
        }
    }
    /* Christoffel numbers: 1 / Σ p_j² / |p_j|², with |p_0|² = 1. */
    for (int k = 0; k < 3; k++) {
        double sum = 0.0, norm = 1.0;
        for (int j = 0; j < 3; j++) {
            norm *= j > 0 ? beta[j] : 1.0;
            double p = polynomial(j, node[k], alpha, beta);
            sum += p * p / norm;
        }
        weight[k] = mass / sum;
    }
}

/* The density of facets seen at mu; returns its sum. */
static double seen(double mu, struct density *d)
{
    double steeper = isinf(mu) ? 0.0 : pel_seen_steeper(mu), sum = 0.0;
    double narrower = isinf(mu) ? 0.0 : pel_seen_narrower(mu);
    d->from = fmax(steeper - mu, -REACH);
    d->step = (REACH - d->from) / SAMPLES;
    for (int i = 0; i < SAMPLES; i++) {
        double y = place(d, i) - steeper;
        d->weight[i] =
            (isinf(mu) ? 1.0 : mu + y) * exp(-0.5 * y * y * (1.0 + narrower));
        sum += d->weight[i];
    }
    return sum;
}

void pel_facets_seen(double mu, double node[PEL_FACET_NODES],
                     double weight[PEL_FACET_NODES])
{
    static _Thread_local struct density all, part;
    double sum = seen(mu, &all), fall = pel_facets_fall(mu);
    /* Mirrored light falls about as fast: nodes stand where it is. */
    part = all;
    for (int i = 0; i < SAMPLES; i++) {
        double z = place(&all, i);
        double light = all.weight[i] / sum * exp(-fall * z);
        part.weight[i] = light * pel_facets_escape(mu, z);
    }
    quadrature(&part, node, weight);
    for (int k = 0; k < NODES; k++) {
        weight[k] *= exp(fall * node[k]);
    }
    double mass = 0.0, first = 0.0;
    for (int i = 0; i < SAMPLES; i++) {
        double z = place(&all, i);
        double w = all.weight[i] / sum * exp(-fall * z) *
                   (1.0 - pel_facets_escape(mu, z));
        mass += w;
        first += w * z;
    }
    node[NODES] = mass > 1e-9 ? first / mass : -0.5 * fmin(mu, REACH);
    weight[NODES] = mass > 1e-9 ? mass * exp(fall * node[NODES]) : 0.0;
}

double pel_facet_fresnel(struct pel_vec3 view, double var_x, double var_y,
                         double n)
{
    double sine = sqrt(fmax(1.0 - view.z * view.z, 1e-8));
    double x = view.x / sine, y = view.y / sine;
    double along = var_x * x * x + var_y * y * y;
    double s = sqrt(along), across = var_x * var_y / along;
    double node[PEL_FACET_NODES], weight[PEL_FACET_NODES], sum = 0.0;
    pel_facets_seen(view.z / (sine * s), node, weight);
    for (int k = 0; k < PEL_FACET_NODES; k++) {
        double zx = var_x * x / s * node[k], zy = var_y * y / s * node[k];
        double facet2 = 1.0 + zx * zx + zy * zy;
        double facing = view.z + view.x * zx + view.y * zy;
        double cosine = facing / sqrt(facet2 * (1.0 + across / facet2));
        sum += weight[k] * pel_fresnel_exact(cosine, n);
    }
    return sum;
}

double pel_facets_entering(struct pel_vec3 to, double var_x, double var_y)
{
    if (fmin(var_x, var_y) < 1e-8) {
        return 1.0 - pel_fresnel_exact(to.z, PEL_WATER_INDEX);
    }
    if (to.x * to.x + to.y * to.y < 1e-8) {
        to.x = 1e-4; /* all azimuths are the same */
    }
    return 1.0 - pel_facet_fresnel(to, var_x, var_y, PEL_WATER_INDEX);
}
