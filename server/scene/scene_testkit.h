/* Scenes for tests, of any room that may see them: made, edited by JSON as a
 * client does it, looked into. What fails ends the test with its fault. */
#pragma once

#include <string.h>

#include "base/near.h"
#include "json.h"
#include "scene/scene.h"

static inline struct pel_scene *make_scene(struct pel_scene_options options)
{
    struct pel_scene *scene;
    struct pel_fault fault;
    if (pel_scene_create(&options, &scene, &fault)) {
        fail_msg("%s", fault.message);
    }
    return scene;
}

/* A patch that can be read; free it. */
static inline Pelagos__Patch *read_patch(const char *json)
{
    Pelagos__Patch *read;
    struct pel_fault fault;
    if (pel_json_merge_patch(json, strlen(json), &read, &fault)) {
        fail_msg("%s: %s", json, fault.message);
    }
    return read;
}

/* Refused as it is read, or by the scene, or done; fault: NULL allowed. */
static inline enum pel_err patch(struct pel_scene *scene, const char *json,
                                 struct pel_fault *fault)
{
    Pelagos__Patch *read;
    enum pel_err err = pel_json_merge_patch(json, strlen(json), &read, fault);
    if (err == PEL_OK) {
        err = pel_scene_patch(scene, read, fault);
        pelagos__patch__free_unpacked(read, NULL);
    }
    return err;
}

static inline void must(struct pel_scene *scene, const char *json)
{
    struct pel_fault fault;
    if (patch(scene, json, &fault)) {
        fail_msg("%s: %s", json, fault.message);
    }
}

/* NULL: there is none. */
static inline const Pelagos__Entity *entity_of(struct pel_scene *scene,
                                               uint32_t id)
{
    const Pelagos__State *s = pel_scene_state(scene);
    for (size_t i = 0; i < s->n_entities; i++) {
        if (s->entities[i]->id == id) {
            return s->entities[i];
        }
    }
    return NULL;
}
