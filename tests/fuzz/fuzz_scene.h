/* What the scene does with a patch, from the same state for every input, so
 * that a finding repeats. */
#pragma once

#include <math.h>
#include <stdlib.h>

#include "json.h"
#include "scene/build.h"
#include "scene/check.h"
#include "scene/edit.h"

static inline bool fuzz_vector(struct pel_vec3 v)
{
    return isfinite(v.x) && isfinite(v.y) && isfinite(v.z);
}

/* Somewhere, and not bent, whenever it is asked. */
static inline void fuzz_cameras(const struct pel_snapshot *s)
{
    /* Helms are stepped, each step through a sea. */
    static const double all[][3] = { { 0, 100, 3e8 }, { 0, 0.5, 1 } };
    const double *times = all[s->ship_count > 0];
    for (size_t k = 0; k < 3 * s->view_count; k++) {
        struct pel_camera c;
        pel_snapshot_camera(s, k / 3, times[k % 3], 0, 0, &c);
        const struct pel_mat3 *axes = &c.world_from_camera;
        if (!isfinite(c.east_m) || !isfinite(c.north_m) ||
            !isfinite(c.altitude_m) || !isfinite(c.tan_top) ||
            !fuzz_vector(c.velocity_mps) || !fuzz_vector(axes->z) ||
            fabs(pel_vec3_dot(axes->x, axes->x) - 1) > 1e-9 ||
            fabs(pel_vec3_dot(axes->y, axes->z)) > 1e-9) {
            abort();
        }
        pel_snapshot_camera_in_wakes(s, k / 3, times[k % 3], &c);
        if (!isfinite(c.east_m) || !isfinite(c.altitude_m)) {
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
