/* Own ship's steps, done ahead by a thread: each looks up a moment of the sea,
 * which takes milliseconds where that is of FFT. The motion is a function of
 * its start and of time, so it does not matter who takes a step. */
#include <math.h>

#include "scene/scene_parts.h"
#include "scene/sharedsea.h"

/* Of real time: what the clock goes on by while a busy thread is late. */
#define LEAD_S 2.0

struct sail {
    struct pel_task task;
    struct pel_scene *scene;
    uint64_t era;
    struct pel_shared_sea *sea;
    struct pel_ship ship;
    double until_s;
};

static void work(struct pel_task *task)
{
    struct sail *sail = (struct sail *)task;
    (void)pel_ship_advance(&sail->ship, sail->until_s,
                           pel_shared_sea_value(sail->sea));
}

static void arrived(struct pel_task *task, bool dropped)
{
    struct sail *sail = (struct sail *)task;
    struct pel_scene *scene = sail->scene;
    scene->ship_ahead = false;
    if (!dropped && sail->era == scene->ship_era &&
        sail->ship.count > scene->snapshot->ship.count) {
        const struct pel_snapshot *next =
            pel_snapshot_with_ship(scene->snapshot, &sail->ship);
        pel_snapshot_unref(scene->snapshot);
        scene->snapshot = next;
    }
    pel_shared_sea_unref(sail->sea);
    g_free(sail);
    if (!dropped) {
        pel_scene_sail(scene, pel_scene_time(scene));
    }
}

void pel_scene_sail(struct pel_scene *scene, double time_s)
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
    struct sail *sail = g_new(struct sail, 1);
    *sail = (struct sail){
        .task = { .work = work, .done = arrived },
        .scene = scene,
        .era = scene->ship_era,
        .sea = pel_shared_sea_ref(s->sea),
        .ship = s->ship,
        .until_s = time_s + lead_s,
    };
    scene->ship_ahead = true;
    pel_worker_push(scene->sailing, &sail->task);
}
