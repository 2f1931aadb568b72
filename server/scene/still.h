/* What a scene is at a moment, so that it can be shown by another one, or gone
 * back to: state, snapshot, and what they were made with. Any thread, one at a
 * time. */
#pragma once

#include "scene/prepare.h"
#include "scene/scene.h"

struct pel_still {
    Pelagos__State *state; /* NULL: none */
    const struct pel_snapshot *snapshot;
    struct pel_resources has;
};

/* The scene as it is at its present time; pel_still_finish. */
void pel_still_take(struct pel_scene *scene, struct pel_still *out);
struct pel_still pel_still_copy(const struct pel_still *still);
void pel_still_finish(struct pel_still *still);

/* The scene, of those apart, becomes what `still` is, which is taken over: the
 * same pictures, and what ships do from there on. Its clock stands. */
void pel_scene_show_still(struct pel_scene *scene, struct pel_still *still);
