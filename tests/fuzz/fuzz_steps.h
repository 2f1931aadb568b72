/* Inputs that are sequences: each step a byte that says what, a length, and as
 * many bytes. Time stands, from the same moment for every input, and passes by
 * steps; a scene lives for one input, so that a finding repeats. */
#pragma once

#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <glib.h>

#include "base/log.h"
#include "base/walk_testkit.h"
#include "scene/scene.h"

static inline void fuzz_demand(bool holds)
{
    if (!holds) {
        abort();
    }
}

struct fuzz_steps {
    const uint8_t *at, *end;
};

struct fuzz_step {
    uint8_t what;
    const uint8_t *data;
    size_t size; /* 254 and two bytes: up to 64 KiB */
};

static inline bool fuzz_next(struct fuzz_steps *steps, struct fuzz_step *out)
{
    size_t left = (size_t)(steps->end - steps->at);
    if (left < 2) {
        return false;
    }
    out->what = *steps->at++;
    out->size = *steps->at++;
    left -= 2;
    if (out->size == 255 && left >= 2) {
        out->size = steps->at[0] | (size_t)steps->at[1] << 8;
        steps->at += 2;
        left -= 2;
    }
    out->size = out->size < left ? out->size : left;
    out->data = steps->at;
    steps->at += out->size;
    return true;
}

static inline uint8_t fuzz_byte(const struct fuzz_step *s, size_t i)
{
    return i < s->size ? s->data[i] : 0;
}

static inline void fuzz_wait(const struct fuzz_step *s)
{
    static const double waits[] = { 0.001, 0.02, 0.1, 0.6, 1.5, 3,
                                    11,    70,   130, 400, 700 };
    walk_wait(waits[fuzz_byte(s, 0) % (sizeof waits / sizeof *waits)]);
}

/* Until nothing is left to do at this moment. */
static inline void fuzz_rest(void)
{
    int turns = 0;
    while (g_main_context_iteration(NULL, FALSE)) {
        fuzz_demand(++turns < 20000);
    }
}

/* Of trochoids: cascades take a sanitizer a second for each new wind. */
static inline struct pel_scene *fuzz_world(void)
{
    struct pel_scene_options options = { .wave_count = 20 };
    struct pel_scene *scene;
    Pelagos__Patch patch = PELAGOS__PATCH__INIT;
    Pelagos__State state = PELAGOS__STATE__INIT;
    Pelagos__Sea sea = PELAGOS__SEA__INIT;
    pel_log_set_level(PEL_LOG_ERROR);
    walk.stands = true;
    walk.now_ns = 1000000000000;
    sea.has_synthesiser = true;
    sea.synthesiser = PELAGOS__SYNTHESISER__TROCHOIDS;
    state.sea = &sea;
    patch.state = &state;
    if (pel_scene_create(&options, &scene, NULL) != PEL_OK ||
        pel_scene_patch(scene, &patch, NULL) != PEL_OK) {
        abort();
    }
    return scene;
}

/* Time that does not go back while nobody sets it, poses that are numbers. */
static inline void fuzz_look(struct pel_scene *scene, double *time_s)
{
    struct pel_camera camera;
    double now_s = pel_scene_time(scene);
    const struct pel_snapshot *s = pel_scene_snapshot(scene);
    fuzz_demand(now_s >= *time_s);
    *time_s = now_s;
    for (size_t i = 0; i < s->view_count; i++) {
        pel_snapshot_camera(s, i, 100, 0, 0, &camera);
        fuzz_demand(camera.east_m - camera.east_m == 0 &&
                    camera.world_from_camera.z.y ==
                        camera.world_from_camera.z.y);
    }
    pel_snapshot_unref(s);
}
