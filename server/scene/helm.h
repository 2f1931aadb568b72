/* Who sails which entity: `ownShip` the one that it names, `entities.*.helm`
 * the one that has it. Of the state alone: any thread that has it. */
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "pelagos.pb-c.h"

#define PEL_HELM_PATH 32

/* Whether any is on. Of a complete state. */
bool pel_helm_any(const Pelagos__State *state);

/* The helm that is on for the entity; NULL: none. Of a complete state. */
Pelagos__OwnShip *pel_helm_on(const Pelagos__State *state,
                              const Pelagos__Entity *entity);
/* The same by the entity's id. */
Pelagos__OwnShip *pel_helm_of(const Pelagos__State *state, uint32_t id);

/* Where the helm of entity `id` is in the schema, whether it is there or not:
 * `ownShip` if that names it, else `entities.7.helm`. */
const char *pel_helm_path(const Pelagos__State *state, uint32_t id,
                          char out[PEL_HELM_PATH]);
