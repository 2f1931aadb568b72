/* The waves of the ships of a snapshot, of any moment: from the tracks of its
 * entities and their poses reckoned on. Any thread but the control thread's,
 * which must not wait for them. */
#pragma once

#include <stdbool.h>
#include <stddef.h>

#include "ocean/wake.h"
#include "pelagos.pb-c.h"
#include "scene/snapshot.h"

/* Ships whose waves a picture has: the first of the state. */
#define PEL_WAKES 8

/* What of the state their waves are made from; reference counted. NULL: no
 * entity makes waves. */
struct pel_wakes *pel_wakes_of(const Pelagos__State *state,
                               const struct pel_snapshot *snapshot);
struct pel_wakes *pel_wakes_ref(struct pel_wakes *wakes);
void pel_wakes_unref(struct pel_wakes *wakes);

/* The waves of one moment; the last few are kept for all who ask. */
struct pel_wake_moment {
    size_t count;
    struct pel_wake *wake[PEL_WAKES];
};

/* The waves at time_s, or NULL: none. A few milliseconds a ship, or some tens
 * where a second begins. pel_wake_moment_unref. */
const struct pel_wake_moment *pel_snapshot_wakes(const struct pel_snapshot *s,
                                                 double time_s);
void pel_wake_moment_unref(const struct pel_wake_moment *moment);

/* Where what is above a place comes from: the wakes carry water sideways. */
struct pel_vec2 pel_wakes_before(const struct pel_wake_moment *moment,
                                 struct pel_vec2 place,
                                 struct pel_wake_shift *there);

/* Adds the wakes to what the sea has at pel_wakes_before. */
void pel_wakes_onto(const struct pel_wake_shift *there,
                    struct pel_surface_sample *sample);
