/* The facets of a rough sea that an eye sees: Gauss quadrature over their
 * slopes. Any thread. */
#pragma once

#include "base/vec.h"

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

/* The same with nodes that are steeper towards the eye by 0.3 / (1 + mu)
 * standard deviations: Ross takes heights and slopes as independent (Smith's
 * masking), but on ray-traced waves the facets seen at grazing angles lie on
 * the crests and are steeper. Fitted with `make validate`. */
void pel_facets_seen(double mu, double node[PEL_FACET_NODES],
                     double weight[PEL_FACET_NODES]);

/* Mean reflectance (index n) of the facets seen: eq. 24 by the
 * nodes of pel_facets_seen along the view, and one root-mean-square slope
 * across. `view` as in brdf.h. Twin of reflected_sky in shaders/lib/shade.glsl.
 */
double pel_facet_fresnel(struct pel_vec3 view, double var_x, double var_y,
                         double n);
