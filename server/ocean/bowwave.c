#include "ocean/bowwave.h"

#include <math.h>

#include "base/vec.h"
#include "ocean/sea.h"

#define HEIGHT 2.2
#define PLACE 1.1
#define STEEPEST 0.443
#define HIGH_M 0.5 /* 1 − 1/e of what breaks is white */

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
