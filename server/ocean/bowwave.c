#include "ocean/bowwave.h"

#include <math.h>

#include "base/vec.h"
#include "ocean/sea.h"

#define HEIGHT 2.2
#define PLACE 1.1
#define STEEPEST 0.443
#define BLUNTEST 1.2 /* rad */
#define HIGH_M 0.5   /* 1 − 1/e of what breaks is white */

static double smooth(double lo, double hi, double x)
{
    double t = pel_clamp((x - lo) / (hi - lo), 0, 1);
    return t * t * (3 - 2 * t);
}

struct pel_bow_wave pel_bow_wave_of(double speed_mps, double draught_m,
                                    double alpha_rad)
{
    if (!(speed_mps > 0)) {
        return (struct pel_bow_wave){ 0 };
    }
    double head = speed_mps * speed_mps / PEL_GRAVITY;
    double deep = 1 + speed_mps / sqrt(PEL_GRAVITY * draught_m);
    double steep = tan(alpha_rad) / cos(alpha_rad);
    struct pel_bow_wave w = { .crest_m = PLACE * head / deep,
                              .excess = 2 * HEIGHT * steep / deep };
    double z = HEIGHT * head * steep / deep;
    w.height_m = fmin(z, 0.5 * head);
    /* Its crest is steep in any case where the bound holds. */
    double steepness = 0.5 * PEL_PI * z / w.crest_m / STEEPEST;
    double high = w.height_m / HIGH_M;
    w.breaks = smooth(1, 1.5, steepness) * (1 - exp(-high * high)) *
               smooth(PEL_BOW_SLOW_MPS, PEL_BOW_QUICK_MPS, speed_mps);
    return w;
}

double pel_bow_half_m(const double half_m[PEL_BOW_STATIONS], double long_m,
                      double aft_m)
{
    double at = aft_m / long_m * PEL_BOW_STATIONS - 0.5;
    if (at < 0) {
        return half_m[0] * fmax(1 + 2 * at, 0);
    }
    int i = (int)fmin(at, PEL_BOW_STATIONS - 2);
    double f = fmin(at - i, 1);
    return half_m[i] + f * (half_m[i + 1] - half_m[i]);
}

struct pel_bow_wave pel_bow_wave_at(const double half_m[PEL_BOW_STATIONS],
                                    double long_m, double draught_m,
                                    double speed_mps, double *alpha_rad)
{
    double to = pel_bow_wave_of(speed_mps, draught_m, 0).crest_m;
    to = pel_clamp(to, 0.5 * long_m / PEL_BOW_STATIONS, 0.5 * long_m);
    *alpha_rad = fmin(atan(pel_bow_half_m(half_m, long_m, to) / to), BLUNTEST);
    return pel_bow_wave_of(speed_mps, draught_m, *alpha_rad);
}
