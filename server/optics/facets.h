/* The facets of a rough sea that an eye sees: Gauss quadrature over their
 * slopes. Any thread. */
#pragma once

#include "base/vec.h"

#define PEL_FACET_NODES 4

/* How fast the light that facets seen at μ mirror falls with their slope, by
 * which the nodes are placed: exp(-fall z). A reflectance falls as 0.5 where
 * waves hide waves, and the sky towards the zenith about as fast again. */
double pel_facets_fall(double mu);

/* Part of what facets of slope z mirror that no other wave meets: pel_escape at
 * the tangent of the reflection, μ + 2 z and its next order for a mean-square
 * slope of 0.01, along and across. */
double pel_facets_escape(double mu, double z);

/* Facets are seen in proportion to (μ + y)⁺ p(y), where y is their slope
 * towards the eye in standard deviations, p the normal density and μ the
 * cotangent of the view's zenith angle over the standard deviation of slopes
 * (Ross et al. 2005; eq. 10 of Bruneton et al. 2010 in the view's azimuth), all
 * steeper by pel_seen_steeper and less scattered by pel_seen_narrower. Fills
 * nodes and weights (they sum to 1 nearly) for what they mirror: three,
 * ascending, for those whose reflection escapes (pel_facets_escape) by Gauss'
 * rule, exact for polynomials of degree 5 times exp(-pel_facets_fall y); the
 * last for those whose reflection meets another wave, exact for degree 1 times
 * it. mu ≥ 0, infinity where all is seen. */
void pel_facets_seen(double mu, double node[PEL_FACET_NODES],
                     double weight[PEL_FACET_NODES]);

/* Mean reflectance (index n) of the facets seen: eq. 24 by the
 * nodes of pel_facets_seen along the view, and one root-mean-square slope
 * across. `view` as in brdf.h. Twin of reflected_sky in shaders/lib/shade.glsl.
 */
double pel_facet_fresnel(struct pel_vec3 view, double var_x, double var_y,
                         double n);

/* Part of the light from `to` (as `view`, above the horizon) that enters such a
 * sea: what its facets do not mirror, index PEL_WATER_INDEX. Where there are no
 * slopes as through a level surface. */
double pel_facets_entering(struct pel_vec3 to, double var_x, double var_y);
