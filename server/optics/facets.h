/* The facets of a rough sea that an eye sees: Gauss quadrature over their
 * slopes. Any thread. */
#pragma once

#define PEL_FACET_NODES 3

/* Facets are seen in proportion to (μ + z)⁺ p(z), where z is their slope
 * towards the eye in standard deviations, p the normal density and μ the
 * cotangent of the view's zenith angle over the standard deviation of slopes
 * (Ross et al. 2005; eq. 10 of Bruneton et al. 2010 in the view's azimuth).
 * Fills nodes (ascending) and weights (they sum to 1) that integrate any
 * polynomial of degree 5 exactly over that distribution; mu ≥ 0, infinity for
 * the Gauss–Hermite rule. */
void pel_facet_quadrature(double mu, double node[PEL_FACET_NODES],
                          double weight[PEL_FACET_NODES]);
