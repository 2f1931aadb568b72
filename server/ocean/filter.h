/* The sea as a footprint sees it: mean position, mean normal, and the variance
 * of the slopes that the mean leaves out (Bruneton et al. 2010, section 3.2),
 * in double precision, for either synthesiser. The shaders' twin is
 * shaders/lib/filtered.glsl.
 *
 * A footprint is a length on the mean plane, > 0 m, the same for waves of all
 * directions. */
#pragma once

#include "base/err.h"
#include "base/vec.h"
#include "ocean/sea.h"

/* Bounds of the filter in wavelengths a footprint, n_min < n_max: shorter
 * waves are gone, longer ones whole (section 7.1: 1 and 2.5). */
struct pel_filter {
    double n_min, n_max; /* 1..4, 1..8 */
};
#define PEL_FILTER_DEFAULT ((struct pel_filter){ 1.0, 2.5 })

/* w(n_min, n_max, wavelengths) of section 3.2. */
double pel_filter_weight(const struct pel_filter *filter, double wavelengths);

/* What of a wave's slope is left in the mean over a footprint:
 * the weight times sin(x)/x, x = π / wavelengths (to 0.2 % of where the weight
 * is 1). The paper leaves the second factor out, and with it counts slopes
 * twice once they stand in the variance too. */
double pel_filter_gain(const struct pel_filter *filter, double wavelengths);

/* Cascades are filtered by levels of detail instead (cascade.h): a length is
 * read at log2(length / texel) plus these, which bring their half-gain between
 * the bounds. Slopes are interpolated linearly over a texel, positions by a
 * spline over four. */
double pel_filter_slope_bias(const struct pel_filter *filter); /* −0.5 */
double pel_filter_shift_bias(const struct pel_filter *filter); /* −2 */

struct pel_filtered {
    struct pel_vec3 shift;  /* of the point at rest, metres */
    struct pel_vec3 normal; /* unit: of eq. 3 */
    struct pel_slopes left; /* to the BRDF, in wind axes */
};

/* The filtered surface where points[i] lies at rest, at time_s; out[i] answers
 * it. Position by eq. 2, normal by eq. 3, with the same footprint. For cascades
 * it takes about 10 ms once a call, and NO_MEMORY. Any thread. */
PEL_CHECK enum pel_err
pel_sea_filtered(const struct pel_sea *sea, const struct pel_filter *filter,
                 double footprint_m, const struct pel_vec2 *points, size_t n,
                 double time_s, struct pel_filtered *out);

/* pel_filtered.left alone: it does not depend on place and time. Total minus
 * resolved (eq. 4), a wave's resolved part by the square of pel_filter_gain. */
struct pel_slopes pel_sea_slopes_left(const struct pel_sea *sea,
                                      const struct pel_filter *filter,
                                      double footprint_m);
