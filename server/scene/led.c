#include "scene/led.h"

#include <math.h>

#include "base/clock.h"
#include "scene/scene_parts.h"

enum pel_err pel_scene_refuse_led(const struct pel_scene *scene,
                                  struct pel_fault *fault)
{
    return scene->led.on && !scene->led.playing
               ? pel_fault_set(fault, PEL_ERR_CONFLICT, "%s", scene->led.cure)
               : PEL_OK;
}

static void tell(struct pel_scene *scene)
{
    for (int i = 0; i < PEL_MAX_ACTS; i++) {
        if (scene->acts[i].led) {
            scene->acts[i].led(scene->acts[i].user, scene->led.on);
        }
    }
}

void pel_scene_lead(struct pel_scene *scene, const char *cure)
{
    bool begins = !scene->led.on;
    if (begins) {
        pel_scene_refresh(scene, pel_scene_time(scene));
        scene->led.on = true;
        pel_simclock_set(&scene->clock, PEL_CLOCK_STEPPED,
                         scene->state->clock->rate, scene->state->clock->time,
                         pel_now_ns());
    }
    g_free(scene->led.cure);
    scene->led.cure = g_strdup(cure);
    if (begins) {
        tell(scene);
    }
}

void pel_scene_unlead(struct pel_scene *scene)
{
    const Pelagos__Clock *clock = scene->state->clock;
    if (scene->led.on) {
        scene->led.on = false;
        pel_simclock_set(&scene->clock, (enum pel_clock_mode)clock->mode,
                         clock->rate, scene->clock.base_s, pel_now_ns());
        tell(scene);
    }
}

enum pel_err pel_scene_play_to(struct pel_scene *scene, double time_s,
                               struct pel_fault *fault)
{
    if (!(time_s >= scene->clock.base_s && time_s <= PEL_MAX_TIME_S)) {
        return pel_fault_set(fault, PEL_ERR_CONFLICT,
                             "the log leads to %.17g s, and it is %.17g s",
                             time_s, scene->clock.base_s);
    }
    scene->clock.base_s = time_s;
    pel_scene_refresh(scene, time_s);
    return PEL_OK;
}

enum pel_err pel_scene_play(struct pel_scene *scene,
                            const Pelagos__LogEntry *entry,
                            struct pel_fault *fault)
{
    enum pel_err err = pel_scene_play_to(scene, entry->time, fault);
    if (!err && entry->command_case == PELAGOS__LOG_ENTRY__COMMAND_PATCH) {
        scene->led.playing = true;
        err = pel_scene_patch(scene, entry->patch, fault);
        scene->led.playing = false;
    }
    return err;
}

double pel_scene_moment(struct pel_scene *scene)
{
    int64_t now_ns = pel_now_ns();
    if (!scene->led.on && scene->clock.mode == PEL_CLOCK_FREE) {
        pel_scene_act_until(scene, pel_simclock_at(&scene->clock, now_ns));
    }
    /* What acted may have set the clock, later than now_ns. */
    return fmax(pel_simclock_at(&scene->clock, now_ns), scene->clock.base_s);
}

const Pelagos__State *pel_scene_state_at(struct pel_scene *scene, double time_s)
{
    pel_scene_refresh(scene, time_s);
    return scene->state;
}

const struct pel_snapshot *pel_scene_snapshot_at(struct pel_scene *scene,
                                                 double time_s)
{
    pel_scene_refresh(scene, time_s);
    return pel_snapshot_ref(scene->snapshot);
}

void pel_scene_anew(struct pel_scene *scene, double time_s)
{
    pel_scene_refresh(scene, time_s);
    if (scene->snapshot->ship_count > 0) {
        const struct pel_snapshot *anew = pel_snapshot_build_going(
            scene->state, scene->has.sea, scene->has.ground.bed,
            scene->has.sky.picture, &scene->has.fleet, scene->has.weather.field,
            NULL);
        pel_snapshot_unref(scene->snapshot);
        scene->snapshot = anew;
    }
}
