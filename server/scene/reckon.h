/* Dead reckoning on a circular arc. Pure functions, any thread. */
#pragma once

#include <stdint.h>

/* Seconds to reckon from pose_time_s to time_s, at most most_s
 * (clock.reckoning) either way: farther from its time the pose is held. */
double pel_reckon_seconds(double pose_time_s, double time_s, double most_s);

/* What moves a thing afloat that nobody steers. wind_to_rad: mathematical
 * direction that the wind blows to; out: east, north. */
struct pel_adrift {
    double leeway;    /* share of the wind's speed */
    double mooring_m; /* radius of the watch circle; 0: it drifts */
    uint32_t seed;    /* of how it swings */
    double wind_mps, wind_to_rad;
};

/* Displacement from its pose, which is `seconds` old: leeway times wind,
 * without end; none where it is moored. */
void pel_reckon_drift(const struct pel_adrift *what, double seconds,
                      double *east_m, double *north_m);

/* Displacement from the anchor at time_s: downwind by mooring_m U² / (U² + 5²
 * m²/s²), the chain is the tauter the stronger the wind; to either side of it
 * by 20° in 4 minutes and 9° in 97 s, in and out by a tenth in a minute, in
 * phases of the seed. Ours, no measurement; never beyond mooring_m. *bow_rad:
 * compass direction to the anchor. */
void pel_reckon_swing(const struct pel_adrift *what, double time_s,
                      double *east_m, double *north_m, double *bow_rad);

/* Displacement after seconds at speed_mps on a course that turns steadily:
 * a chord of the circle, length v t sin(x)/x, bearing course + x, x = ω t / 2.
 * Radians, metres; negative seconds go back. */
void pel_reckon_move(double speed_mps, double course_rad, double turn_rate_rps,
                     double seconds, double *east_m, double *north_m);
