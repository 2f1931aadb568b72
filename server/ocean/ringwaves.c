#include "ocean/ringwaves.h"

#include <math.h>

#include "base/vec.h"
#include "ocean/directional.h"

#define EDDY_VISCOSITY 1e-5 /* m²/s */
#define EVEN_FROM_MM_H 40.0
#define STIRRED_M 0.1
#define WHITECAPS_MM_H 20.0

double pel_ring_density(double rain_mm_h, double frequency_hz)
{
    if (!(rain_mm_h > 0)) {
        return 0;
    }
    double peak = 5.772 - 0.0018 * rain_mm_h;
    double width = (4.42 + 0.0028 * rain_mm_h) / peak;
    double at = log(frequency_hz / peak) / width;
    return 6e-8 * pow(rain_mm_h, 0.53) * exp(-PEL_PI * at * at);
}

double pel_rain_leaves(double rain_mm_h, double k, double wind_mps)
{
    if (!(rain_mm_h > 0)) {
        return 1;
    }
    double viscosity = EDDY_VISCOSITY * fmin(rain_mm_h / EVEN_FROM_MM_H, 1);
    double decay = 4.0 * viscosity * k * k * -expm1(-2.0 * k * STIRRED_M);
    double growth = wind_mps > 0 ? pel_wind_growth(k, wind_mps) : 0;
    double sustained = growth > decay ? 1.0 - decay / growth : 0;
    return fmax(exp(-decay * PEL_RAIN_LASTING_S), sustained);
}

double pel_rain_whitecaps(double rain_mm_h)
{
    return exp(-rain_mm_h / WHITECAPS_MM_H);
}
