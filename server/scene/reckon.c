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
