/* The models that a state's entities have. Any thread. */
#pragma once

#include <stdbool.h>
#include <stddef.h>

#include "base/err.h"
#include "models/model.h"
#include "pelagos.pb-c.h"

struct pel_fleet_member;

/* Of each entity that has a model, in the state's order. Zeroed: none. */
struct pel_fleet {
    size_t count;
    struct pel_fleet_member *members; /* shared: pel_fleet_ref */
};

/* The models of a tested, complete state: those of `present` where they are the
 * same, else made, or read from `directory` (NULL: none is configured), which
 * waits for the file (models/modelload.h). All or none; on refusal *fault
 * (NULL allowed) says what is wrong with which entity's model. Forgiving: an
 * entity whose model cannot be had goes without, and the log says so. */
PEL_CHECK enum pel_err pel_fleet_get(const Pelagos__State *state,
                                     const char *directory, bool forgiving,
                                     const struct pel_fleet *present,
                                     struct pel_fleet *out,
                                     struct pel_fault *fault);

/* Whether `fleet` has every model that the state's entities have. */
bool pel_fleet_has(const struct pel_fleet *fleet, const Pelagos__State *state);

/* The model of an entity of the state that the fleet was got for; NULL: it has
 * none. *next, 0 at first, goes on with each entity in the state's order. */
const struct pel_model *pel_fleet_of(const struct pel_fleet *fleet,
                                     const Pelagos__Entity *entity,
                                     size_t *next);

/* The same members; pel_fleet_finish() for each. */
struct pel_fleet pel_fleet_ref(const struct pel_fleet *fleet);
void pel_fleet_finish(struct pel_fleet *fleet);

/* Leaves out the dimensions that a built-in model of this name cannot have. */
void pel_fleet_trim(Pelagos__Model *wish);

/* Whether a model may be had: a built-in one with sizes that it can have, or a
 * file by its ending, which is not read. Faults as below. */
PEL_CHECK enum pel_err pel_fleet_try(const Pelagos__Model *wish,
                                     struct pel_fault *fault);

/* A model by name and sizes, built in or from the directory. `notes`: what of a
 * file was left out. Waits. Faults name no path but "length", "beam", … of the
 * model. */
PEL_CHECK enum pel_err pel_fleet_make(const Pelagos__Model *wish,
                                      const char *directory,
                                      const struct pel_model **out,
                                      char notes[], struct pel_fault *fault);
