/* Newton's step towards the rest position of a place on a choppy surface. */
#pragma once

#include "base/vec.h"

/* For the derivative ((a, b), (c, d)) of x0 → x0 + D(x0) and the way (rx, ry)
 * still to go. The map is all but the gradient of a convex function wherever it
 * does not fold, and its derivative all but symmetric: Newton's step, with the
 * eigenvalues of its symmetric part kept from zero, always leads downhill. */
static inline struct pel_vec2 pel_newton_step(double a, double b, double c,
                                              double d, double rx, double ry)
{
    double half = 0.5 * (a + d), mean = 0.5 * (b + c);
    double least = half - sqrt(0.25 * (a - d) * (a - d) + mean * mean);
    if (least < 0.02) {
        a += 0.02 - least;
        d += 0.02 - least;
    }
    double det = a * d - b * c;
    return (struct pel_vec2){ (d * rx - b * ry) / det,
                              (a * ry - c * rx) / det };
}
