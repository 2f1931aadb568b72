/* The wash of the ships of a snapshot, of any moment: from the tracks of its
 * entities, their poses reckoned on, and their helms. Any thread. */
#pragma once

#include "ocean/wash.h"
#include "pelagos.pb-c.h"
#include "scene/snapshot.h"

/* Ships whose wash a picture has: the first of the state. */
#define PEL_WASHES 16

/* What of the state it is made from; reference counted. NULL: no entity has
 * any. */
struct pel_washes *pel_washes_of(const Pelagos__State *state,
                                 const struct pel_snapshot *snapshot);
struct pel_washes *pel_washes_ref(struct pel_washes *washes);
void pel_washes_unref(struct pel_washes *washes);

/* The wash at time_s, or NULL: none. Some tens of microseconds a ship.
 * pel_wash_destroy. */
struct pel_wash *pel_snapshot_wash(const struct pel_snapshot *s, double time_s);
