#include "scene/reckon.h"

#include <math.h>

#include "base/vec.h"

double pel_reckon_seconds(double pose_time_s, double time_s, double most_s)
{
    return pel_clamp(time_s - pose_time_s, -most_s, most_s);
}

void pel_reckon_move(double speed_mps, double course_rad, double turn_rate_rps,
                     double seconds, double *east_m, double *north_m)
{
    double x = 0.5 * turn_rate_rps * seconds;
    double chord = speed_mps * seconds * (fabs(x) > 1e-9 ? sin(x) / x : 1);
    *east_m = chord * sin(course_rad + x);
    *north_m = chord * cos(course_rad + x);
}

void pel_reckon_drift(const struct pel_adrift *what, double seconds,
                      double *east_m, double *north_m)
{
    double way_m = what->mooring_m > 0
                       ? 0
                       : what->leeway * what->wind_mps * fmax(seconds, 0);
    *east_m = way_m * cos(what->wind_to_rad);
    *north_m = way_m * sin(what->wind_to_rad);
}

/* -1..1, with a phase of its own for each seed. */
static double sway(uint32_t seed, int which, double time_s, double period_s)
{
    double phase = (double)((seed + 1) * UINT32_C(2654435761) >> (4 * which));
    return sin(2 * PEL_PI * (time_s / period_s + phase / 4096));
}

void pel_reckon_swing(const struct pel_adrift *what, double time_s,
                      double *east_m, double *north_m, double *bow_rad)
{
    double wind2 = what->wind_mps * what->wind_mps;
    double out_m = what->mooring_m * wind2 / (wind2 + 25) *
                   (1 + 0.1 * sway(what->seed, 0, time_s, 61)) / 1.1;
    double angle =
        what->wind_to_rad + PEL_DEG * (20 * sway(what->seed, 1, time_s, 240) +
                                       9 * sway(what->seed, 2, time_s, 97));
    *east_m = out_m * cos(angle);
    *north_m = out_m * sin(angle);
    *bow_rad = atan2(-cos(angle), -sin(angle));
}
