#include "bridges/cigi_shapes.h"

#include <stdio.h>
#include <stdlib.h>

#include <glib.h>

#include "base/file.h"
#include "base/log.h"
#include "bridges/cigi_types.h"
#include "scene/scene.h"

/* Models of one edit: what asks for another sea may wait behind it. */
#define AN_EDIT 8

/* An entity and the type that the host gave it last. */
struct memo {
    bool used, waits, shaped;
    uint32_t id;
    unsigned type;
};

struct pel_cigi_shapes {
    struct pel_scene *scene;
    struct pel_cigi_types types;
    struct pel_cigi_shape_counters counters;
    struct memo memos[PEL_MAX_ENTITIES];
    bool making;
    size_t made_count;
    uint32_t made[AN_EDIT]; /* ids in the edit that is being made */
};

enum pel_err pel_cigi_shapes_create(const char *path, struct pel_scene *scene,
                                    struct pel_cigi_shapes **out,
                                    struct pel_fault *fault)
{
    char *text = NULL;
    size_t size;
    struct pel_fault why;
    *out = NULL;
    enum pel_err err =
        pel_file_read(path, PEL_CIGI_TYPES_FILE, &text, &size, &why);
    if (err) {
        return pel_fault_set(fault, err, "--cigi-entities: %s", why.message);
    }
    struct pel_cigi_shapes *shapes = g_new0(struct pel_cigi_shapes, 1);
    shapes->scene = scene;
    err = pel_cigi_types_read(text, size, &shapes->types, &why);
    free(text);
    if (err) {
        g_free(shapes);
        return pel_fault_set(fault, err, "--cigi-entities: %s: %s", path,
                             why.message);
    }
    *out = shapes;
    return PEL_OK;
}

void pel_cigi_shapes_destroy(struct pel_cigi_shapes *shapes)
{
    if (shapes) {
        pel_scene_forget(shapes->scene, shapes);
        pel_cigi_types_finish(&shapes->types);
        g_free(shapes);
    }
}

static struct memo *memo_of(struct pel_cigi_shapes *shapes, uint32_t id,
                            bool make)
{
    struct memo *spare = NULL;
    for (size_t i = 0; i < PEL_MAX_ENTITIES; i++) {
        struct memo *m = &shapes->memos[i];
        if (m->used && m->id == id) {
            return m;
        }
        spare = !m->used && !spare ? m : spare;
    }
    return make ? spare : NULL;
}

void pel_cigi_shapes_take(struct pel_cigi_shapes *shapes, uint32_t id,
                          unsigned type, bool removed)
{
    struct memo *m = shapes ? memo_of(shapes, id, !removed) : NULL;
    if (!m || (m->used && !removed && m->type == type)) {
        return;
    }
    bool shaped = m->used && m->shaped;
    *m = (struct memo){ .used = !removed,
                        .waits = !removed,
                        .shaped = shaped,
                        .id = id,
                        .type = type };
    if (!removed && !pel_cigi_types_find(&shapes->types, type)) {
        static struct pel_log_limit limit;
        pel_log_limited(&limit, PEL_LOG_WARNING, "CIG-013",
                        "entity %u is of type %u, which --cigi-entities does "
                        "not name: it has no model",
                        id, type);
        shapes->counters.unknown++;
    }
}

static const Pelagos__Entity *entity_of(const Pelagos__State *state,
                                        uint32_t id)
{
    for (size_t i = 0; i < state->n_entities; i++) {
        if (state->entities[i]->id == id) {
            return state->entities[i];
        }
    }
    return NULL;
}

static void remove_entity(struct pel_cigi_shapes *shapes, uint32_t id)
{
    char path[32], *paths = path;
    Pelagos__Patch what = PELAGOS__PATCH__INIT;
    snprintf(path, sizeof path, "entities.%u", id);
    what.n_remove = 1;
    what.remove = &paths;
    if (pel_scene_patch(shapes->scene, &what, NULL) != PEL_OK) {
        shapes->counters.refused_edits++;
    }
}

/* Entities that went meanwhile must not come back with their models. */
static void on_made(void *user, enum pel_err err, const struct pel_fault *fault)
{
    struct pel_cigi_shapes *shapes = user;
    shapes->making = false;
    if (err) {
        static struct pel_log_limit limit;
        pel_log_limited(&limit, PEL_LOG_WARNING, "CIG-014",
                        "models of entities were refused: %s %s", fault->path,
                        fault->message);
        shapes->counters.refused_edits++;
        return;
    }
    shapes->counters.edits++;
    for (size_t i = 0; i < shapes->made_count; i++) {
        if (!memo_of(shapes, shapes->made[i], false)) {
            remove_entity(shapes, shapes->made[i]);
        }
    }
    pel_cigi_shapes_commit(shapes);
}

void pel_cigi_shapes_commit(struct pel_cigi_shapes *shapes)
{
    if (!shapes || shapes->making) {
        return;
    }
    const Pelagos__State *now = pel_scene_state(shapes->scene);
    Pelagos__Patch patch = PELAGOS__PATCH__INIT;
    Pelagos__State state = PELAGOS__STATE__INIT;
    Pelagos__Entity entities[AN_EDIT], *list[AN_EDIT];
    char paths[AN_EDIT][32], *removals[AN_EDIT];
    size_t count = 0;
    patch.state = &state;
    patch.remove = removals;
    state.entities = list;
    for (size_t i = 0; i < PEL_MAX_ENTITIES && count < AN_EDIT; i++) {
        struct memo *m = &shapes->memos[i];
        const Pelagos__Entity *old =
            m->used && m->waits ? entity_of(now, m->id) : NULL;
        if (!old) {
            continue;
        }
        const Pelagos__Model *model =
            pel_cigi_types_find(&shapes->types, m->type);
        m->waits = false;
        if (!model && !(m->shaped && old->model)) {
            continue; /* a model of somebody else's stays */
        }
        if (old->model) { /* else the new one keeps its sizes */
            removals[patch.n_remove] = paths[patch.n_remove];
            snprintf(paths[patch.n_remove++], sizeof paths[0],
                     "entities.%u.model", m->id);
        }
        pelagos__entity__init(&entities[count]);
        entities[count].has_id = 1;
        entities[count].id = m->id;
        entities[count].model = (Pelagos__Model *)model;
        list[count] = &entities[count];
        shapes->made[count++] = m->id;
        m->shaped = model != NULL;
    }
    shapes->made_count = state.n_entities = count;
    if (count > 0) {
        const struct pel_scene_wish wish = { .patch = &patch,
                                             .source = shapes };
        shapes->making = true;
        pel_scene_submit(shapes->scene, &wish, on_made, shapes);
    }
}

struct pel_cigi_shape_counters
pel_cigi_shapes_counters(const struct pel_cigi_shapes *shapes)
{
    return shapes ? shapes->counters : (struct pel_cigi_shape_counters){ 0 };
}
