/* A camera's way through waypoints. Pure functions of time, any thread. */
#pragma once

#include <stddef.h>

#include "base/vec.h"
#include "pelagos.pb-c.h"

#define PEL_WAYPOINTS_MOST 64

struct pel_way;

/* Where it is: degrees, height above altitude 0 [m], true heading, pitch and
 * roll [rad]. */
struct pel_way_pose {
    double latitude, longitude, height_m;
    double heading_rad, pitch_rad, roll_rad;
};

/* Of 1 to PEL_WAYPOINTS_MOST waypoints in the order of their times. Referenced
 * once; aborts without memory. */
struct pel_way *pel_way_of(Pelagos__Waypoint *const *points, size_t count);
struct pel_way *pel_way_ref(struct pel_way *way); /* NULL allowed */
void pel_way_unref(struct pel_way *way);          /* NULL allowed */

/* At simulated time time_s; before the first and after the last it stands
 * there. The normal of the ellipsoid is a cubic of time through the waypoints'
 * (Catmull and Rom), so that no place is singular; asinh(height / 1 m), which
 * is the logarithm above some metres and passes through the surface, and the
 * angles, each the shorter way round, are cubics that go no further than their
 * ends (Fritsch and Butland, SIAM J. Sci. Stat. Comput. 5, 1984). With two
 * waypoints all are straight. */
void pel_way_at(const struct pel_way *way, double time_s,
                struct pel_way_pose *out);
