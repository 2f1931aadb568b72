/* Own ship's steps, done ahead by a thread: each looks up a moment of the sea,
 * which takes milliseconds where that is of FFT. The motion is a function of
 * its start and of time, so it does not matter who takes a step. */
#include <math.h>

#include "scene/scene_parts.h"
#include "scene/sharedsea.h"

/* Of real time: what the clock goes on by while a busy thread is late. */
#define LEAD_S 2.0

struct ahead {
    struct pel_task task;
    struct pel_scene *scene;
    uint64_t era;
    struct pel_shared_sea *sea;
    struct pel_ship ship;
    double until_s;
};

static void work(struct pel_task *task)
{
    struct ahead *ahead = (struct ahead *)task;
    (void)pel_ship_advance(&ahead->ship, ahead->until_s,
                           pel_shared_sea_value(ahead->sea));
}

static void arrived(struct pel_task *task, bool dropped)
{
    struct ahead *ahead = (struct ahead *)task;
    struct pel_scene *scene = ahead->scene;
    scene->ship_ahead = false;
    if (!dropped && ahead->era == scene->ship_era &&
        ahead->ship.count > scene->snapshot->ship.count) {
        const struct pel_snapshot *next =
            pel_snapshot_with_ship(scene->snapshot, &ahead->ship);
        pel_snapshot_unref(scene->snapshot);
        scene->snapshot = next;
    }
    pel_shared_sea_unref(ahead->sea);
    g_free(ahead);
    if (!dropped) {
        pel_scene_step_ahead(scene, pel_scene_time(scene));
    }
}

void pel_scene_step_ahead(struct pel_scene *scene, double time_s)
{
    const struct pel_snapshot *s = scene->snapshot;
    double lead_s =
        s->mode == PEL_CLOCK_FREE
            ? fmin(LEAD_S * fmax(fabs(s->rate), 1), PEL_SHIP_AHEAD_S)
            : PEL_SHIP_AHEAD_S;
    if (s->ship_entity < 0 || scene->ship_ahead ||
        !pel_snapshot_transforms(s) ||
        !pel_ship_steps(&s->ship, time_s + 0.5 * lead_s)) {
        return;
    }
    struct ahead *ahead = g_new(struct ahead, 1);
    *ahead = (struct ahead){
        .task = { .work = work, .done = arrived },
        .scene = scene,
        .era = scene->ship_era,
        .sea = pel_shared_sea_ref(s->sea),
        .ship = s->ship,
        .until_s = time_s + lead_s,
    };
    scene->ship_ahead = true;
    pel_worker_push(scene->ship_worker, &ahead->task);
}
