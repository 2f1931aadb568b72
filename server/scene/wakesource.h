/* Where an entity that makes waves was and will be: its track of the state,
 * then its pose reckoned on, or its helm's motion, at moments that do not
 * depend on who asks when. */
#pragma once

#include <pthread.h>
#include <stdbool.h>
#include <stdint.h>

#include "ocean/wake.h"
#include "pelagos.pb-c.h"
#include "scene/snapshot.h"

struct pel_wake_knots; /* of a helm's motion, as far as it was asked for */

struct pel_wake_source {
    uint32_t id;
    struct pel_hull hull;
    struct pel_wake_bow bow;
    struct pel_entity_state pose;
    double reckoning_s;
    struct pel_wake_knots *knots; /* NULL: no helm moves it */
    int count;                    /* of what the state keeps */
    struct pel_wake_point point[PEL_WAKE_POINTS];
};

/* Reads entity `index`, which has a model. */
void pel_wake_source_read(const Pelagos__State *state,
                          const struct pel_snapshot *snapshot, size_t index,
                          struct pel_wake_source *out);
void pel_wake_source_finish(struct pel_wake_source *source);

/* The track from what can still be seen at time_s to a point after it. */
void pel_wake_source_track(const struct pel_wake_source *source, double time_s,
                           struct pel_wake_track *out);

/* A moment up to which that track is the same for whoever asks a little later,
 * also after the pose was edited: from it on the ship goes no farther than a
 * tenth of its shortest tile. It lies PEL_WAKE_EPOCH_LAG_S or more before
 * time_s, of a ship too fast for that less, so that what the track has left up
 * to it can be summed before it is wanted; the first point's at least. */
#define PEL_WAKE_EPOCH_LAG_S 1.0
double pel_wake_source_epoch(const struct pel_wake_source *source,
                             const struct pel_wake_track *track, double time_s);

/* Writes the track of an entity under its helm, up to time_s, to the state. */
void pel_wake_source_keep(const struct pel_wake_source *source,
                          const Pelagos__State *state, double time_s,
                          Pelagos__Entity *entity);
