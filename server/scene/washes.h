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

/* The wash at time_s, or NULL: none. Up to a quarter of a millisecond a ship;
 * who asks for one of the last moments of a snapshot shares it.
 * pel_wash_destroy. */
const struct pel_wash *pel_snapshot_wash(const struct pel_snapshot *s,
                                         double time_s);

/* The last moments of one snapshot; NULL where it has no washes. */
struct pel_wash_moments *pel_wash_moments_of(const struct pel_washes *washes);
void pel_wash_moments_destroy(
    struct pel_wash_moments *moments); /* NULL: none */
