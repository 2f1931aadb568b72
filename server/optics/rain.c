#include "optics/rain.h"

#include <math.h>

#include "base/vec.h"
#include "shaders/lib/blocks.h"

#define LEAST_VISIBILITY_M 200.0
#define PER_M3_MM2 1e-6 /* mm²/m³ in 1/m */

double pel_rain_extinction(double mm_per_h)
{
    if (!(mm_per_h > 0)) {
        return 0;
    }
    double lambda = 4.1 * pow(mm_per_h, -0.21);
    return PER_M3_MM2 * PEL_PI * 8000.0 / pow(lambda, 3);
}

double pel_snow_extinction(double mm_per_h)
{
    if (!(mm_per_h > 0)) {
        return 0;
    }
    double lambda = 2.29 * pow(mm_per_h, -0.45);
    double number = 2500.0 * pow(mm_per_h, -0.94);
    return PER_M3_MM2 * 3.0 * PEL_PI * number / (0.17 * pow(lambda, 4));
}

double pel_visibility_in_rain(double visibility_m, double rain_mm_h,
                              double snow_mm_h)
{
    double falling =
        pel_rain_extinction(rain_mm_h) + pel_snow_extinction(snow_mm_h);
    if (!(falling > 0)) {
        return visibility_m;
    }
    double left = PEL_KOSCHMIEDER / (PEL_KOSCHMIEDER / visibility_m + falling);
    return fmax(left, LEAST_VISIBILITY_M);
}

double pel_visibility_besides(double visibility_m, double *rain_mm_h,
                              double *snow_mm_h)
{
    const double most = 0.9;
    double seen = PEL_KOSCHMIEDER / visibility_m;
    double falling =
        pel_rain_extinction(*rain_mm_h) + pel_snow_extinction(*snow_mm_h);
    if (!(falling > 0)) {
        return visibility_m;
    }
    double share = fmin(most * seen / falling, 1.0);
    *rain_mm_h *= pow(share, 1.0 / 0.63); /* their powers of the rate */
    *snow_mm_h *= pow(share, 1.0 / 0.86);
    return PEL_KOSCHMIEDER / (seen - share * falling);
}
