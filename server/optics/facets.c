#include "optics/facets.h"

#include <math.h>

#include "optics/brdf.h"

#define SAMPLES 4096
#define REACH 9.0 /* p(9) is 1e-18 */

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

/* Stieltjes' procedure on the density, sampled densely. */
static void recurrence(double mu, double alpha[3], double beta[3], double *mass)
{
    double from = fmax(-mu, -REACH), step = (REACH - from) / SAMPLES;
    double norm_before = 1.0;
    for (int n = 0; n < PEL_FACET_NODES; n++) {
        double norm = 0.0, first = 0.0;
        for (int i = 0; i < SAMPLES; i++) {
            double z = from + (i + 0.5) * step;
            double seen = isinf(mu) ? 1.0 : mu + z;
            double w = seen * exp(-0.5 * z * z);
            double p = polynomial(n, z, alpha, beta);
            norm += w * p * p;
            first += w * z * p * p;
        }
        alpha[n] = first / norm;
        beta[n] = n > 0 ? norm / norm_before : 0.0;
        norm_before = norm;
        if (n == 0) {
            *mass = norm;
        }
    }
}

void pel_facet_quadrature(double mu, double node[PEL_FACET_NODES],
                          double weight[PEL_FACET_NODES])
{
    double alpha[3], beta[3], mass;
    recurrence(mu, alpha, beta, &mass);
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
        weight[k] = 1.0 / sum;
    }
}

void pel_facets_seen(double mu, double node[PEL_FACET_NODES],
                     double weight[PEL_FACET_NODES])
{
    pel_facet_quadrature(mu, node, weight);
    for (int k = 0; k < PEL_FACET_NODES; k++) {
        node[k] += 0.3 / (1.0 + mu);
    }
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
