/* Entities that leave something in the water: which of a state do, the first
 * so many. */
#pragma once

#include <stdbool.h>
#include <stddef.h>

#include "pelagos.pb-c.h"
#include "scene/snapshot.h"

/* Writes to `index` those of the state's entities of which does() is true, at
 * most `most`; returns their number. More are said in the log, as those that
 * `what`. */
size_t pel_leaving_choose(const Pelagos__State *state,
                          const struct pel_snapshot *snapshot, const char *what,
                          size_t most,
                          bool (*does)(const Pelagos__State *state,
                                       const struct pel_snapshot *snapshot,
                                       size_t index),
                          size_t *index);
