/* Patches that wait for a sea to be built or a file to be read. */
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "fault.h"
#include "message.h"
#include "scene/check.h"
#include "scene/edit.h"
#include "scene/helm.h"
#include "scene/scene_parts.h"

#define MAX_WAITING 256

/* A patch that waits for its sea or its bottom. */
struct waiting {
    Pelagos__Patch *patch; /* ours */
    const void *source;
    bool withdrawn;
    bool has_revision;
    uint64_t revision;
    pel_scene_done done; /* may be NULL */
    void *user;
};

static void waiting_free(gpointer data)
{
    struct waiting *w = data;
    pelagos__patch__free_unpacked(w->patch, NULL);
    g_free(w);
}

static bool is_waiting(const struct pel_scene *scene, const void *source)
{
    for (guint i = 0; source && i < scene->waiting->len; i++) {
        const struct waiting *w = g_ptr_array_index(scene->waiting, i);
        if (w->source == source) {
            return true;
        }
    }
    return false;
}

/* Whether a patch says what those that wait may say too. */
static bool touches_sea(const Pelagos__Patch *patch)
{
    const Pelagos__State *to = patch->state;
    bool touches = to && (to->sea || to->seabed || to->origin ||
                          (to->sky && to->sky->file));
    for (size_t i = 0; to && i < to->n_entities && !touches; i++) {
        touches = to->entities[i]->model;
    }
    for (size_t i = 0; i < patch->n_remove && !touches; i++) {
        touches = strncmp(patch->remove[i], "sea", 3) == 0 ||
                  strcmp(patch->remove[i], "sky") == 0 ||
                  strcmp(patch->remove[i], "sky.file") == 0 ||
                  strncmp(patch->remove[i], "origin", 6) == 0;
    }
    return touches;
}

/* Whether the state needs a file that is not read yet. */
static bool reads(const struct pel_scene *scene, const Pelagos__State *state)
{
    return !pel_ground_is(&scene->has.ground, state) ||
           !pel_fleet_has(&scene->has.fleet, state) ||
           !pel_sky_file_is(&scene->has.sky, state) ||
           !pel_weather_file_is(&scene->has.weather, state) ||
           !pel_shared_sea_same_record(scene->has.sea, state);
}

/* How many patches are tested and committed in one turn of the control thread,
 * for a millisecond: each copies the state, so the more is in it, the fewer. */
static guint most_at_once(const Pelagos__State *state)
{
    size_t items = 10 + state->n_entities + state->n_views;
    return (guint)MAX(1, 400 / items);
}

static void prepared(void *user, struct pel_preparation *ready);

/* Prepares the state that the oldest patches lead to: as many as change no more
 * than the sea's numbers, or one that names a file, whose refusal is its own.
 */
static void prepare_next(struct pel_scene *scene)
{
    struct pel_fault fault;
    Pelagos__State *state = NULL;
    if (scene->batch > 0 || scene->waiting->len == 0) {
        return;
    }
    pel_scene_refresh(scene, pel_scene_time(scene));
    guint most = MIN(scene->waiting->len, most_at_once(scene->state));
    for (guint i = 0; i < most; i++) {
        const struct waiting *w = g_ptr_array_index(scene->waiting, i);
        Pelagos__State *next;
        if (!w->withdrawn &&
            pel_state_apply(state ? state : scene->state, w->patch, &next,
                            &fault) == PEL_OK) {
            bool good = pel_sea_settle(next, &fault) == PEL_OK &&
                        pel_state_check(next, &fault) == PEL_OK;
            bool file = good && reads(scene, next);
            if (file && i > 0) {
                pelagos__state__free_unpacked(next, NULL);
                break;
            }
            if (good && state) {
                pelagos__state__free_unpacked(state, NULL);
            }
            if (good) {
                state = next;
            } else {
                pelagos__state__free_unpacked(next, NULL);
            }
            if (file) {
                scene->batch = 1;
                break;
            }
        }
        scene->batch = i + 1; /* what became bad is refused with its batch */
    }
    if (!state) {
        state = (Pelagos__State *)pel_message_copy(&scene->state->base);
    }
    scene->prepared++;
    pel_preparation_begin(scene->worker, state, &scene->means, &scene->files,
                          &scene->has, prepared, scene);
}

static enum pel_err commit_one(struct pel_scene *scene, const struct waiting *w,
                               struct pel_preparation *ready, int64_t now_ns,
                               struct pel_fault *fault)
{
    Pelagos__State *next;
    double time_s = pel_simclock_at(&scene->clock, now_ns);
    enum pel_err err = pel_scene_refuse_led(scene, fault);
    if (err) {
        return err;
    }
    if (ready->dropped) {
        return pel_fault_set(fault, PEL_ERR_CONFLICT, "the daemon is stopping");
    }
    if (w->withdrawn) {
        return pel_fault_set(fault, PEL_ERR_CONFLICT, "nobody asks any more");
    }
    if (w->has_revision && w->revision != scene->state->revision) {
        pel_fault_set(fault, PEL_ERR_CONFLICT,
                      "the state is at revision %llu, not %llu",
                      (unsigned long long)scene->state->revision,
                      (unsigned long long)w->revision);
        pel_fault_at(fault, PEL_SCENE_REVISION, NULL);
        return PEL_ERR_CONFLICT;
    }
    if (ready->err) {
        *fault = ready->fault;
        return ready->err;
    }
    err = pel_scene_edited(scene, w->patch, time_s, &next, fault);
    return err ? err
               : pel_scene_commit(scene, next, w->patch, &ready->got, time_s,
                                  now_ns, fault);
}

/* All of a batch at one moment: the seas between are never
 * drawn. */
static void prepared(void *user, struct pel_preparation *ready)
{
    struct pel_scene *scene = user;
    if (!ready->dropped) {
        pel_scene_catch_up(scene);
    }
    guint count = ready->dropped ? scene->waiting->len : scene->batch;
    int64_t now_ns = pel_now_ns();
    bool any = false;
    enum pel_err *errs = g_new0(enum pel_err, count);
    struct pel_fault *faults = g_new0(struct pel_fault, count);
    for (guint i = 0; i < count; i++) {
        const struct waiting *w = g_ptr_array_index(scene->waiting, i);
        errs[i] = commit_one(scene, w, ready, now_ns, &faults[i]);
        any = any || !errs[i];
    }
    bool dropped = ready->dropped;
    pel_preparation_free(ready);
    if (any) {
        pel_scene_notify_commit(scene);
    }
    /* Each is in the list until its own turn: what one of them does may make
     * another be forgotten. */
    for (guint i = 0; i < count; i++) {
        struct waiting *w = g_ptr_array_steal_index(scene->waiting, 0);
        (void)pel_scene_answer(scene, w->source, w->done, w->user, errs[i],
                               &faults[i]);
        waiting_free(w);
    }
    g_free(faults);
    g_free(errs);
    scene->batch = 0;
    if (!dropped) {
        prepare_next(scene);
    }
    pel_scene_go_on(scene, dropped);
}

/* Whether it puts a ship to sea where none is: moments of it are computed
 * before. */
static bool puts_to_sea(const struct pel_scene *scene,
                        const Pelagos__State *next)
{
    return scene->snapshot->ship_count == 0 &&
           next->clock->mode == PELAGOS__CLOCK_MODE__FREE &&
           pel_snapshot_transforms(scene->snapshot) && pel_helm_any(next);
}

/* Adds it to those that wait; false: there are too many. */
static bool wait_for(struct pel_scene *scene, const struct pel_scene_wish *wish,
                     pel_scene_done done, void *user)
{
    if (scene->waiting->len >= MAX_WAITING) {
        return false;
    }
    struct waiting *w = g_new(struct waiting, 1);
    *w = (struct waiting){
        .patch = (Pelagos__Patch *)pel_message_copy(&wish->patch->base),
        .source = wish->source,
        .has_revision = wish->if_unchanged,
        .revision = scene->state->revision,
        .done = done,
        .user = user,
    };
    g_ptr_array_add(scene->waiting, w);
    prepare_next(scene);
    return true;
}

/* time_s: when it takes effect; at_once: without waiting for its sea. */
static bool submit(struct pel_scene *scene, const struct pel_scene_wish *wish,
                   int64_t now_ns, double time_s, bool at_once,
                   pel_scene_done done, void *user)
{
    Pelagos__State *next = NULL;
    struct pel_fault fault = { 0 };
    enum pel_err err = pel_scene_refuse_led(scene, &fault);
    bool behind = !err && !at_once &&
                  (is_waiting(scene, wish->source) ||
                   (scene->waiting->len > 0 && touches_sea(wish->patch)));
    if (!err && !behind) {
        err = pel_scene_edited(scene, wish->patch, time_s, &next, &fault);
    }
    if (!err && !behind &&
        (at_once || (pel_resources_fits(&scene->has, next, &scene->means) &&
                     !puts_to_sea(scene, next)))) {
        err = pel_scene_commit(scene, next, wish->patch, NULL, time_s, now_ns,
                               &fault);
        if (!err) {
            pel_scene_notify_commit(scene);
        }
    } else if (!err) {
        pel_scene_put_by(scene, next);
        if (wait_for(scene, wish, done, user)) {
            return true;
        }
        err = pel_fault_set(&fault, PEL_ERR_BUSY,
                            "%d patches wait for a sea or a file already",
                            MAX_WAITING);
    }
    return pel_scene_answer(scene, wish->source, done, user, err, &fault);
}

bool pel_scene_submit(struct pel_scene *scene,
                      const struct pel_scene_wish *wish, pel_scene_done done,
                      void *user)
{
    pel_scene_catch_up(scene);
    int64_t now_ns = pel_now_ns();
    return submit(scene, wish, now_ns, pel_simclock_at(&scene->clock, now_ns),
                  false, done, user);
}

bool pel_scene_act_patch(struct pel_scene *scene, const Pelagos__Patch *patch,
                         double time_s, bool at_once, pel_scene_done done,
                         void *user)
{
    const struct pel_scene_wish wish = { .patch = patch, .source = user };
    bool stepped = scene->clock.mode == PEL_CLOCK_STEPPED ||
                   scene->clock.mode == PEL_CLOCK_PACED;
    return submit(scene, &wish, pel_now_ns(), time_s, at_once && stepped, done,
                  user);
}

void pel_scene_forget(struct pel_scene *scene, const void *source)
{
    pel_scene_gate_forget(scene, source);
    for (guint i = 0; i < scene->waiting->len; i++) {
        struct waiting *w = g_ptr_array_index(scene->waiting, i);
        if (w->source == source) {
            w->done = NULL;
        }
    }
}

void pel_scene_withdraw(struct pel_scene *scene, const void *source)
{
    pel_scene_forget(scene, source);
    for (guint i = 0; i < scene->waiting->len; i++) {
        struct waiting *w = g_ptr_array_index(scene->waiting, i);
        w->withdrawn = w->withdrawn || w->source == source;
    }
}

uint64_t pel_scene_prepared(const struct pel_scene *scene)
{
    return scene->prepared;
}

void pel_scene_settle(struct pel_scene *scene)
{
    while (pel_worker_wait(scene->worker)) {
    }
}

void pel_scene_begin_waiting(struct pel_scene *scene)
{
    scene->waiting = g_ptr_array_new();
    scene->worker = pel_worker_create("preparing");
    scene->numbers = pel_worker_create("spectra");
    scene->shapes = pel_worker_create("models");
    scene->ship_worker = pel_worker_create("own ship ahead");
}

void pel_scene_end_waiting(struct pel_scene *scene)
{
    pel_worker_destroy(scene->worker);
    scene->worker = NULL;
    pel_worker_destroy(scene->numbers);
    scene->numbers = NULL;
    pel_worker_destroy(scene->shapes);
    scene->shapes = NULL;
    pel_catalogue_free(scene->catalogue);
    scene->catalogue = NULL;
    pel_worker_destroy(scene->ship_worker);
    scene->ship_worker = NULL;
    g_ptr_array_free(scene->waiting, TRUE);
}
