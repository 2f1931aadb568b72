/* Uniform cubic B-spline of the four texels around a place, twin of
 * shaders/lib/spline.glsl. */
#pragma once

#include "base/simd.h"

/* Weights of texels −1, 0, 1, 2 at the fraction f between 0 and 1, and their
 * derivatives, a texel. */
PEL_INLINE void pel_cubic_spline(double f, double w[4], double d[4])
{
    double g = 1.0 - f;
    w[0] = g * g * g / 6.0;
    w[1] = (4.0 - 6.0 * f * f + 3.0 * f * f * f) / 6.0;
    w[2] = (4.0 - 6.0 * g * g + 3.0 * g * g * g) / 6.0;
    w[3] = f * f * f / 6.0;
    d[0] = -0.5 * g * g;
    d[1] = f * (1.5 * f - 2.0);
    d[2] = g * (2.0 - 1.5 * g);
    d[3] = 0.5 * f * f;
}
