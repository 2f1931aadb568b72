#include "scene/helm.h"

#include <stdio.h>

Pelagos__OwnShip *pel_helm_on(const Pelagos__State *state,
                              const Pelagos__Entity *entity)
{
    if (state->own_ship && state->own_ship->on &&
        state->own_ship->entity == entity->id) {
        return state->own_ship;
    }
    return entity->helm && entity->helm->on ? entity->helm : NULL;
}

bool pel_helm_any(const Pelagos__State *state)
{
    bool any = false;
    for (size_t i = 0; i < state->n_entities && !any; i++) {
        any = pel_helm_on(state, state->entities[i]) != NULL;
    }
    return any;
}

Pelagos__OwnShip *pel_helm_of(const Pelagos__State *state, uint32_t id)
{
    for (size_t i = 0; i < state->n_entities; i++) {
        if (state->entities[i]->id == id) {
            return pel_helm_on(state, state->entities[i]);
        }
    }
    return NULL;
}

const char *pel_helm_path(const Pelagos__State *state, uint32_t id,
                          char out[PEL_HELM_PATH])
{
    if (state->own_ship && state->own_ship->entity == id) {
        snprintf(out, PEL_HELM_PATH, "ownShip");
    } else {
        snprintf(out, PEL_HELM_PATH, "entities.%u.helm", id);
    }
    return out;
}
