#include "optics/moon.h"

#include <math.h>

#include "base/vec.h"
#include "optics/atmosphere.h"

double pel_moon_strength(double alpha, double distance_m)
{
    double degrees = fabs(alpha) / PEL_DEG;
    double magnitudes = 0.026 * degrees + 4e-9 * pow(degrees, 4.0);
    double near = PEL_MOON_DISTANCE / distance_m;
    return pow(10.0, -0.4 * magnitudes) * near * near;
}

double pel_moon_alpha(double lit)
{
    return acos(pel_clamp(2.0 * lit - 1.0, -1.0, 1.0));
}

double pel_moon_disc(double alpha)
{
    double half = 0.5 * pel_clamp(alpha, 0.0, PEL_PI);
    if (half < 1e-4) {
        return 1.0;
    }
    if (half > 0.5 * PEL_PI - 1e-4) {
        return 0.0;
    }
    return 1.0 - sin(half) * tan(half) * log(1.0 / tan(0.5 * half));
}

double pel_moon_earthlight(double alpha)
{
    double beta = PEL_PI - pel_clamp(alpha, 0.0, PEL_PI);
    double phase = (sin(beta) + (PEL_PI - beta) * cos(beta)) / PEL_PI;
    double across = 6371e3 / PEL_MOON_DISTANCE;
    return 0.5 * 0.367 * across * across * phase;
}
