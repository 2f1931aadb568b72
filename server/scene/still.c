#include "scene/still.h"

#include "base/clock.h"
#include "message.h"
#include "scene/scene_parts.h"

void pel_still_take(struct pel_scene *scene, struct pel_still *out)
{
    out->state =
        (Pelagos__State *)pel_message_copy(&pel_scene_state(scene)->base);
    out->snapshot = pel_scene_snapshot(scene);
    out->has = pel_resources_ref(&scene->has);
}

struct pel_still pel_still_copy(const struct pel_still *still)
{
    return (struct pel_still){
        .state = (Pelagos__State *)pel_message_copy(&still->state->base),
        .snapshot = pel_snapshot_ref(still->snapshot),
        .has = pel_resources_ref(&still->has),
    };
}

void pel_still_finish(struct pel_still *still)
{
    if (still->state) {
        pelagos__state__free_unpacked(still->state, NULL);
        pel_snapshot_unref(still->snapshot);
        pel_resources_finish(&still->has);
    }
    *still = (struct pel_still){ 0 };
}

void pel_scene_show_still(struct pel_scene *scene, struct pel_still *still)
{
    struct pel_still before = { scene->state, scene->snapshot, scene->has };
    scene->state = still->state;
    scene->snapshot = still->snapshot;
    scene->has = still->has;
    *still = (struct pel_still){ 0 };
    pel_still_finish(&before);
    pel_simclock_set(&scene->clock, PEL_CLOCK_STEPPED,
                     scene->state->clock->rate, scene->state->clock->time,
                     pel_now_ns());
    pel_scene_notify_commit(scene);
}
