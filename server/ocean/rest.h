/* Newton's step towards the rest position of a place on a choppy surface. */
#pragma once

#include "base/vec.h"

/* For the derivative ((a, b), (b, d)) of x0 → x0 + D(x0) and the way (rx, ry)
 * still to go. The map is the gradient of a convex function wherever it does
 * not fold, and its derivative is symmetric: Newton's step, with the
 * eigenvalues kept from zero, always leads downhill. */
static inline struct pel_vec2 pel_rest_step(double a, double b, double d,
                                            double rx, double ry)
{
    double half = 0.5 * (a + d);
    double least = half - sqrt(0.25 * (a - d) * (a - d) + b * b);
    if (least < 0.02) {
        a += 0.02 - least;
        d += 0.02 - least;
    }
    double det = a * d - b * b;
    return (struct pel_vec2){ (d * rx - b * ry) / det,
                              (a * ry - b * rx) / det };
}
