/* The lamps of a snapshot's entities: lights of navigation, of marks, on decks,
 * searchlights, signal lamps. What they are made of is a plan, made with the
 * snapshot; which are lit is a function of it and the moment. Any thread. */
#pragma once

#include "base/err.h"
#include "optics/lamp.h"
#include "pelagos.pb-c.h"
#include "scene/snapshot.h"

/* In visibility below this lamps are lit by day too (AUTO): 2 nautical miles.
 */
#define PEL_LAMPS_VISIBILITY_M 3704.0
/* They are lit from sunset on: the Sun's centre is lower than this. */
#define PEL_LAMPS_SUNSET_DEG (-0.833)

/* An entity's light, sectors, signal: INVALID or CONFLICT with path, value and
 * what it must be. */
PEL_CHECK enum pel_err pel_lamps_check(const Pelagos__Entity *entity,
                                       struct pel_fault *fault);

/* Which entities of a tested state have lamps, and what lamps; reference
 * counted. NULL: none has any. The snapshot's entities have their models. */
struct pel_lamp_plan *pel_lamps_of(const Pelagos__State *state,
                                   const struct pel_snapshot *snapshot);
struct pel_lamp_plan *pel_lamps_ref(struct pel_lamp_plan *plan);
void pel_lamps_unref(struct pel_lamp_plan *plan); /* NULL allowed */

/* The lamps lit at time_s, in the order of the entities, deck lights last;
 * their number, at most PEL_MAX_LAMPS. objects: those of that moment
 * (pel_snapshot_objects). Asks the sea where an entity without a model is
 * afloat: not the control thread. */
struct pel_place; /* whence, NULL: the map */
size_t pel_snapshot_lamps(const struct pel_snapshot *s, double time_s,
                          const struct pel_place *from,
                          const struct pel_object *objects, size_t object_count,
                          struct pel_lamp out[PEL_MAX_LAMPS]);

/* Colour of a kind of light, the middle of its region in Annex I, section 7:
 * linear Rec. 709 of luminance 1. */
void pel_lamp_colour_of(int colour, double out[3]);
