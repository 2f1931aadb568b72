#include "optics/lamp.h"

#include <math.h>

#define THRESHOLD_LX 2e-7
#define NAUTICAL_MILE_M 1852.0

static double bell(double x)
{
    return exp(-M_LN2 * x * x);
}

static double in_sector(const struct pel_lamp *lamp, double ahead, double right)
{
    if (lamp->arc_rad >= 2 * M_PI) {
        return 1;
    }
    double past = remainder(
        atan2(right, ahead) - lamp->from_rad - lamp->arc_rad / 2, 2 * M_PI);
    double beyond = fabs(past) - lamp->arc_rad / 2;
    return beyond <= 0                  ? 1
           : beyond >= lamp->cutoff_rad ? 0
                                        : 1 - beyond / lamp->cutoff_rad;
}

double pel_lamp_towards(const struct pel_lamp *lamp, struct pel_vec3 direction)
{
    double ahead = pel_vec3_dot(direction, lamp->ahead);
    if (lamp->beam_rad > 0) {
        return bell(acos(fmin(fmax(ahead, -1), 1)) / lamp->beam_rad);
    }
    double up = pel_vec3_dot(direction, lamp->up);
    double right =
        pel_vec3_dot(direction, pel_vec3_cross(lamp->ahead, lamp->up));
    double off = fabs(asin(fmin(fmax(up, -1), 1))) - lamp->spread_rad;
    double level = off <= 0 ? 1 : bell(off / lamp->spread_rad);
    return level * in_sector(lamp, ahead, right);
}

double pel_lamp_intensity(double range_nm, double per_mile)
{
    double range_m = range_nm * NAUTICAL_MILE_M;
    return THRESHOLD_LX * range_m * range_m * pow(per_mile, -range_nm);
}
