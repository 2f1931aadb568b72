/* Making a snapshot from a tested, complete state. Control thread. */
#pragma once

#include "base/err.h"
#include "pelagos.pb-c.h"
#include "scene/snapshot.h"

/* A sea that several snapshots share. */
struct pel_shared_sea;

/* The sea that the state asks for: `present` (NULL allowed) with another
 * reference where it is the same, else a new one. */
PEL_CHECK enum pel_err pel_shared_sea_get(const Pelagos__State *state,
                                          int wave_count,
                                          struct pel_shared_sea *present,
                                          struct pel_shared_sea **out);
void pel_shared_sea_unref(struct pel_shared_sea *sea); /* NULL allowed */

/* A snapshot with one reference; takes its own of the sea. */
const struct pel_snapshot *pel_snapshot_build(const Pelagos__State *state,
                                              struct pel_shared_sea *sea);
