/* The tracks of entities that make waves: of the state, kept as their poses are
 * edited. Control thread. */
#pragma once

#include "pelagos.pb-c.h"

#define PEL_TRACK_MOST 240 /* points that are kept */

/* Where an entity was and how it moved before an edit. */
struct pel_track_pose {
    double time_s, latitude, longitude;
    double speed_mps, course_deg, turn_rate_dps, heading_deg;
};
struct pel_track_pose pel_track_pose_of(const Pelagos__Entity *entity);

/* Forgets where it was. */
void pel_track_drop(Pelagos__Entity *entity);

/* A point after all others; past PEL_TRACK_MOST one on a straight piece goes,
 * else the oldest, which is logged. */
Pelagos__TrackPoint *pel_track_add(Pelagos__Entity *entity, double time_s,
                                   double latitude, double longitude);
/* The same with heading and push of the point, where it comes later. */
void pel_track_mark(Pelagos__Entity *entity, const Pelagos__TrackPoint *point);
/* Drops the points from a moment on. */
void pel_track_cut(Pelagos__Entity *entity, double from_s);

/* Goes on from `before` to the entity's pose after an edit: points where the
 * straight piece between the last two, gone on with, is PEL_TRACK_WITHIN_M off,
 * and after PEL_TRACK_STRIDE_M.
 * An entity that was placed elsewhere, or leaves neither wake nor wash, has
 * none. */
#define PEL_TRACK_WITHIN_M 0.5
#define PEL_TRACK_STRIDE_M 40.0
void pel_track_go_on(const struct pel_track_pose *before,
                     Pelagos__Entity *entity, double reckoning_s);
