/* Dead reckoning on a circular arc. Pure functions, any thread. */
#pragma once

/* Seconds to reckon from pose_time_s to time_s, at most most_s
 * (clock.reckoning) either way: farther from its time the pose is held. */
double pel_reckon_seconds(double pose_time_s, double time_s, double most_s);

/* Displacement after seconds at speed_mps on a course that turns steadily:
 * a chord of the circle, length v t sin(x)/x, bearing course + x, x = ω t / 2.
 * Radians, metres; negative seconds go back. */
void pel_reckon_move(double speed_mps, double course_rad, double turn_rate_rps,
                     double seconds, double *east_m, double *north_m);
