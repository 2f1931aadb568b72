/* The tracks of entities that make waves: of the state, kept as their poses are
 * edited. Control thread. */
#pragma once

#include "pelagos.pb-c.h"

#define PEL_TRACK_MOST 240 /* points that are kept */

/* Where an entity was and how it moved before an edit. */
struct pel_track_pose {
    double time_s, latitude, longitude;
    double speed_mps, course_deg, turn_rate_dps;
};
struct pel_track_pose pel_track_pose_of(const Pelagos__Entity *entity);

/* Forgets where it was. */
void pel_track_drop(Pelagos__Entity *entity);

/* Goes on from `before` to the entity's pose after an edit: points where the
 * straight piece between the last two, gone on with, is PEL_TRACK_WITHIN_M off.
 * An entity that was placed elsewhere, or makes no waves, has none. */
#define PEL_TRACK_WITHIN_M 0.5
void pel_track_go_on(const struct pel_track_pose *before,
                     Pelagos__Entity *entity, double reckoning_s);
