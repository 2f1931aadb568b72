/* What the scene does with a patch, from the same state for every input, so
 * that a finding repeats. */
#pragma once

#include <math.h>
#include <stdlib.h>

#include "json.h"
#include "scene/build.h"
#include "scene/check.h"
#include "scene/edit.h"

static inline void fuzz_cameras(const struct pel_snapshot *s)
{
    struct pel_camera camera;
    for (size_t i = 0; i < s->view_count; i++) {
        pel_snapshot_camera(s, i, 100, 0, 0, &camera);
        if (!isfinite(camera.east_m) || !isfinite(camera.tan_top) ||
            !isfinite(camera.world_from_camera.z.y)) {
            abort();
        }
    }
}

static inline void fuzz_edit(const Pelagos__Patch *patch)
{
    static Pelagos__State *state;
    static struct pel_shared_sea *sea;
    struct pel_shared_sea *next_sea;
    static const struct pel_sea_means means = { 60, NULL };
    struct pel_fault fault;
    Pelagos__State *next;
    if (!state) {
        state = pel_state_default();
        if (pel_shared_sea_get(state, &means, NULL, NULL, &sea, NULL)) {
            abort();
        }
    }
    if (pel_state_apply(state, patch, &next, &fault)) {
        return;
    }
    if (pel_state_check(next, &fault) == PEL_OK &&
        pel_sea_settle(next, &fault) == PEL_OK &&
        next->sea->spectrum != PELAGOS__SPECTRUM_KIND__MEASURED) {
        if (pel_shared_sea_get(next, &means, NULL, sea, &next_sea, NULL)) {
            abort(); /* what is in range makes a sea */
        }
        const struct pel_snapshot *s = pel_snapshot_build(next, next_sea, NULL);
        pel_shared_sea_unref(next_sea);
        fuzz_cameras(s);
        pel_snapshot_unref(s);
        free(pel_json_from_message(&next->base, false));
    }
    pelagos__state__free_unpacked(next, NULL);
}
