/* The ships' steps, done ahead by a thread: each looks up a moment of the sea,
 * which takes milliseconds where that is of FFT. A motion is a function of its
 * start and of time, so it does not matter who takes a step. The moments about
 * now and next stay there, since orders begin a motion anew: then the control
 * thread has all that it asks for. */
#include <math.h>
#include <string.h>

#include "scene/scene_parts.h"
#include "scene/sharedsea.h"
#include "scene/ship_ahead.h"
#include "scene/wakes.h"

/* Of real time: what the clock goes on by while a busy thread is late; the
 * moments that are held last so long. */
#define LEAD_S ((PEL_SEA_HELD - 2) * PEL_SHIP_STEP_S)

struct ahead {
    struct pel_task task;
    struct pel_scene *scene;
    struct pel_shared_sea *sea;
    struct pel_wakes *wakes;
    size_t count;
    struct pel_sailing ships[PEL_MAX_SHIPS];
    double from_s, until_s;
};

static bool always(void *user)
{
    (void)user;
    return true;
}

void pel_ships_hold_sea(const struct pel_sea *sea, double time_s, double step_s)
{
    double times_s[PEL_SEA_HELD], first = pel_ship_whole(time_s, step_s);
    for (int i = 0; i < PEL_SEA_HELD; i++) {
        times_s[i] = (first + i) * step_s;
    }
    pel_sea_hold(sea, times_s);
    for (int i = 0; i < PEL_SEA_HELD; i++) {
        (void)pel_sea_prepare(sea, times_s[i], false, always, NULL);
    }
}

static void work(struct pel_task *task)
{
    struct ahead *ahead = (struct ahead *)task;
    pel_ships_hold_sea(pel_shared_sea_value(ahead->sea), ahead->from_s,
                       ahead->ships[0].ship.step_s);
    /* Together, so that those in step look up the same moments. */
    for (double t = ahead->from_s; t < ahead->until_s + PEL_SHIP_STEP_S;
         t += PEL_SHIP_STEP_S) {
        for (size_t i = 0; i < ahead->count; i++) {
            (void)pel_ship_advance(&ahead->ships[i].ship,
                                   fmin(t, ahead->until_s),
                                   pel_shared_sea_value(ahead->sea));
        }
    }
}

/* Those that have not begun anew meanwhile, and are not as far by themselves.
 */
static void take(struct pel_scene *scene, const struct ahead *ahead)
{
    struct pel_sailing ships[PEL_MAX_SHIPS];
    size_t count = scene->snapshot->ship_count;
    bool any = false;
    if (count == 0 || ahead->wakes != scene->snapshot->wakes) {
        return; /* there are none any more, or it has met other waves */
    }
    memcpy(ships, scene->snapshot->ships, count * sizeof *ships);
    for (size_t i = 0; i < count; i++) {
        for (size_t k = 0; k < ahead->count; k++) {
            if (ahead->ships[k].run == ships[i].run &&
                ahead->ships[k].ship.count > ships[i].ship.count) {
                ships[i].ship = ahead->ships[k].ship;
                any = true;
            }
        }
    }
    if (any) {
        pel_scene_take_ships(scene, ships);
    }
}

static void arrived(struct pel_task *task, bool dropped)
{
    struct ahead *ahead = (struct ahead *)task;
    struct pel_scene *scene = ahead->scene;
    scene->ship_ahead = false;
    if (!dropped) {
        take(scene, ahead);
    }
    pel_shared_sea_unref(ahead->sea);
    pel_wakes_unref(ahead->wakes);
    g_free(ahead);
    if (!dropped) {
        pel_scene_step_ahead(scene, pel_scene_time(scene));
    }
}

static bool due(const struct pel_snapshot *s, double time_s)
{
    for (size_t i = 0; i < s->ship_count; i++) {
        if (pel_ship_steps(&s->ships[i].ship, time_s)) {
            return true;
        }
    }
    return false;
}

void pel_scene_step_ahead(struct pel_scene *scene, double time_s)
{
    const struct pel_snapshot *s = scene->snapshot;
    double lead_s =
        s->mode == PEL_CLOCK_FREE
            ? fmin(LEAD_S * fmax(fabs(s->rate), 1), PEL_SHIP_AHEAD_S)
            : PEL_SHIP_AHEAD_S;
    if (scene->apart || scene->ship_ahead || !pel_snapshot_transforms(s) ||
        !due(s, time_s + 0.5 * lead_s)) {
        return;
    }
    struct ahead *ahead = g_new(struct ahead, 1);
    ahead->task = (struct pel_task){ .work = work, .done = arrived };
    ahead->scene = scene;
    ahead->sea = pel_shared_sea_ref(s->sea);
    ahead->wakes = pel_wakes_ref(s->wakes);
    ahead->count = s->ship_count;
    memcpy(ahead->ships, s->ships, s->ship_count * sizeof *s->ships);
    ahead->from_s = time_s;
    ahead->until_s = time_s + lead_s;
    scene->ship_ahead = true;
    pel_worker_push(scene->ship_worker, &ahead->task);
}
