#include "optics/wet.h"

#include <math.h>

#include "base/vec.h"
#include "shaders/lib/blocks.h"

#define PHILLIPS 0.0081

double pel_wet_deviation(double m0, double length_m)
{
    double per_turn = length_m / (2 * PEL_PI);
    return m0 > 0 ? sqrt(m0 * -expm1(-PHILLIPS * per_turn * per_turn / m0)) : 0;
}

double pel_wet_share(double above_m, double deviation_m)
{
    double h = above_m / fmax(deviation_m, 1e-6);
    return h <= 0 ? 1 : 1 - pow(-expm1(-0.5 * h * h), PEL_WET_WAVES);
}

double pel_wet_reflectance(double dry)
{
    return (1 - PEL_WET_OUTSIDE) * (1 - PEL_WET_INSIDE) * dry /
           (1 - PEL_WET_INSIDE * dry);
}
