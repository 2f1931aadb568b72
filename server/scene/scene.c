#include "scene/scene.h"

#include <glib.h>
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/log.h"
#include "base/reserve.h"
#include "base/sandbox.h"
#include "base/trial.h"
#include "base/watch.h"
#include "fault.h"
#include "json.h"
#include "message.h"
#include "ocean/foam.h"
#include "scene/build.h"
#include "scene/check.h"
#include "scene/edit.h"
#include "scene/helm.h"
#include "scene/led.h"
#include "scene/scene_parts.h"
#include "scene/sharedsea.h"
#include "scene/store.h"
#include "scene/weatherlead.h"

#define MAX_STEP_S 3600.0
#define SHIP_MS 100
#define DEFAULT_WAVES 60

double pel_scene_time(struct pel_scene *scene)
{
    return pel_simclock_at(&scene->clock, pel_now_ns());
}

void pel_scene_take_ships(struct pel_scene *scene,
                          const struct pel_sailing *ships)
{
    const struct pel_snapshot *next =
        pel_snapshot_with_ships(scene->snapshot, ships);
    pel_snapshot_unref(scene->snapshot);
    scene->snapshot = next;
}

static bool ships_ask(const struct pel_snapshot *s, double time_s)
{
    for (size_t i = 0; i < s->ship_count; i++) {
        if (pel_ship_asks(&s->ships[i].ship, time_s)) {
            return true;
        }
    }
    return false;
}

/* Takes the ships' steps up to time_s. */
static void advance_ships(struct pel_scene *scene, double time_s)
{
    const struct pel_snapshot *s = scene->snapshot;
    if (ships_ask(s, time_s)) {
        PEL_WATCH("own ship");
        struct pel_sailing ships[PEL_MAX_SHIPS];
        memcpy(ships, s->ships, s->ship_count * sizeof *ships);
        for (size_t i = 0; i < s->ship_count; i++) {
            (void)pel_ship_advance(&ships[i].ship, time_s, pel_snapshot_sea(s));
        }
        pel_scene_take_ships(scene, ships);
    }
    pel_scene_step_ahead(scene, time_s);
}

void pel_scene_refresh(struct pel_scene *scene, double time_s)
{
    scene->state->clock->time = time_s;
    if (scene->snapshot->ship_count > 0) {
        advance_ships(scene, time_s);
        pel_snapshot_ships_to_state(scene->snapshot, time_s, scene->state);
    }
}

bool pel_scene_has_spectra(const struct pel_scene *scene)
{
    return scene->spectra != NULL;
}

const Pelagos__State *pel_scene_state(struct pel_scene *scene)
{
    pel_scene_refresh(scene, pel_scene_time(scene));
    return scene->state;
}

const struct pel_snapshot *pel_scene_snapshot(struct pel_scene *scene)
{
    advance_ships(scene, pel_scene_time(scene));
    return pel_snapshot_ref(scene->snapshot);
}

/* Ships are advanced also while no client asks, so that the next snapshot has
 * few steps to catch up on. */
static gboolean on_ship_timer(gpointer user)
{
    PEL_WATCH("ship timer");
    struct pel_scene *scene = user;
    if (scene->snapshot->ship_count == 0) {
        scene->ship_timer = 0;
        return G_SOURCE_REMOVE;
    }
    advance_ships(scene, pel_scene_time(scene));
    return G_SOURCE_CONTINUE;
}

void pel_scene_on_commit(struct pel_scene *scene, void (*callback)(void *user),
                         void *user)
{
    if (scene->callback_count == PEL_MAX_CALLBACKS) {
        pel_error("SCN-004", "more than %d callbacks for commits of the scene",
                  PEL_MAX_CALLBACKS);
        return;
    }
    scene->callbacks[scene->callback_count].call = callback;
    scene->callbacks[scene->callback_count].user = user;
    scene->callback_count++;
}

const Pelagos__State *pel_scene_listen(struct pel_scene *scene,
                                       pel_scene_listener listener, void *user)
{
    double time_s = pel_scene_time(scene);
    scene->listener = listener;
    scene->listener_user = user;
    if (listener) {
        /* Whoever begins with this state begins the ships' steps here. */
        pel_scene_anew(scene, time_s);
    }
    return pel_scene_state_at(scene, time_s);
}

static void notify(struct pel_scene *scene, double time_s,
                   const Pelagos__Patch *patch)
{
    pel_scene_kept(scene);
    if (scene->listener) {
        scene->listener(scene->listener_user, time_s, patch);
    }
    for (int i = 0; i < PEL_MAX_ACTS; i++) {
        if (scene->acts[i].heard) {
            scene->acts[i].heard(scene->acts[i].user, time_s, patch);
        }
    }
}

void pel_scene_add_acts(struct pel_scene *scene,
                        const struct pel_scene_acts *acts)
{
    for (int i = 0; i < PEL_MAX_ACTS; i++) {
        if (!scene->acts[i].next) {
            scene->acts[i] = *acts;
            return;
        }
    }
}

void pel_scene_remove_acts(struct pel_scene *scene, const void *user)
{
    for (int i = 0; i < PEL_MAX_ACTS; i++) {
        if (scene->acts[i].user == user) {
            scene->acts[i] = (struct pel_scene_acts){ 0 };
        }
    }
}

bool pel_scene_acts_by(const struct pel_scene *scene, const void *source)
{
    bool by = false;
    for (int i = 0; i < PEL_MAX_ACTS; i++) {
        by = by || (scene->acts[i].next && scene->acts[i].user == source);
    }
    return by;
}

void pel_scene_repeat(struct pel_scene *scene, bool begin)
{
    scene->repeats = begin;
}

bool pel_scene_repeats(const struct pel_scene *scene)
{
    return scene->repeats;
}

/* Whose moment is the next; NULL: nobody acts. */
static const struct pel_scene_acts *next_to_act(const struct pel_scene *scene,
                                                double until_s, double *at_s)
{
    const struct pel_scene_acts *first = NULL;
    *at_s = INFINITY;
    for (int i = 0; i < PEL_MAX_ACTS && !scene->repeats; i++) {
        const struct pel_scene_acts *a = &scene->acts[i];
        double at = a->next ? a->next(a->user, until_s) : INFINITY;
        if (at < *at_s) {
            *at_s = at;
            first = a;
        }
    }
    return first;
}

/* Whether simulated time goes by steps, and what somebody did waits for its sea
 * or its file. */
static bool waits(const struct pel_scene *scene)
{
    bool any = false;
    for (int i = 0; i < PEL_MAX_ACTS; i++) {
        any = any || (scene->acts[i].next &&
                      scene->acts[i].waits(scene->acts[i].user));
    }
    return any;
}

static bool goes_by_steps(const struct pel_scene *scene)
{
    return scene->clock.mode == PEL_CLOCK_STEPPED ||
           scene->clock.mode == PEL_CLOCK_PACED;
}

/* Up to time_s: a clock that is stepped stops at each moment. */
void pel_scene_act_until(struct pel_scene *scene, double time_s)
{
    const struct pel_scene_acts *who;
    double at;
    if (scene->acting || scene->led.on) {
        return;
    }
    scene->acting = true;
    while (!(goes_by_steps(scene) && waits(scene)) &&
           (who = next_to_act(scene, time_s, &at)) && at <= time_s) {
        if (scene->clock.mode != PEL_CLOCK_FREE) {
            scene->clock.base_s = fmax(at, scene->clock.base_s);
        }
        advance_ships(scene, at);
        who->act(who->user, at);
    }
    scene->acting = false;
}

void pel_scene_catch_up(struct pel_scene *scene)
{
    if (scene->clock.mode == PEL_CLOCK_FREE) {
        pel_scene_act_until(scene, pel_scene_time(scene));
    }
}

void pel_scene_set_host_frame(struct pel_scene *scene, uint32_t number)
{
    scene->host_frame = number;
}

uint32_t pel_scene_host_frame(const struct pel_scene *scene)
{
    return scene->host_frame;
}

void pel_scene_set_stale(struct pel_scene *scene, enum pel_stale source,
                         bool stale)
{
    Pelagos__Sources sources = PELAGOS__SOURCES__INIT;
    Pelagos__State state = PELAGOS__STATE__INIT;
    Pelagos__Patch patch = PELAGOS__PATCH__INIT;
    struct pel_fault fault;
    if (scene->led.on || stale == ((scene->snapshot->stale & source) != 0)) {
        return;
    }
    sources.has_cigi_stale = source == PEL_STALE_CIGI;
    sources.has_modbus_stale = source == PEL_STALE_MODBUS;
    sources.has_nmea_stale = source == PEL_STALE_NMEA;
    sources.has_console_stale = source == PEL_STALE_CONSOLE;
    sources.has_other_stale = source == PEL_STALE_OTHER;
    sources.cigi_stale = sources.modbus_stale = sources.nmea_stale = stale;
    sources.console_stale = sources.other_stale = stale;
    state.sources = &sources;
    patch.state = &state;
    if (pel_scene_patch(scene, &patch, &fault) != PEL_OK) {
        pel_error("SCN-007", "a silent source could not be marked: %s",
                  fault.message);
    }
}

/* The clock goes on from the state's time where the edit changed it. */
static void set_clock(struct pel_scene *scene, const Pelagos__Clock *to,
                      double time_before_s, int64_t now_ns)
{
    enum pel_clock_mode mode = (enum pel_clock_mode)to->mode;
    mode = scene->led.on ? PEL_CLOCK_STEPPED : mode;
    if (mode != scene->clock.mode || to->rate != scene->clock.rate ||
        to->time != time_before_s) {
        pel_simclock_set(&scene->clock, mode, to->rate, to->time, now_ns);
    }
}

void pel_scene_put_by(struct pel_scene *scene, Pelagos__State *state)
{
    if (scene->former && state) {
        pelagos__state__free_unpacked(state, NULL);
    } else if (state) {
        scene->former = state;
    }
}

/* Takes `state`, which is tested, over or leaves it to the caller. `patch`, of
 * time_s, is kept before it takes effect; NULL: the state is a beginning.
 * `ready` (NULL allowed): what was prepared for it. */
static enum pel_err commit(struct pel_scene *scene, Pelagos__State *state,
                           const Pelagos__Patch *patch, double time_s,
                           const struct pel_sailing *const *going,
                           const struct pel_resources *ready,
                           struct pel_fault *fault)
{
    struct pel_resources next;
    bool fits = ready && pel_resources_fits(ready, state, &scene->means);
    enum pel_err err =
        pel_resources_get(state, &scene->means, &scene->files,
                          fits ? ready : &scene->has, &next, fault);
    if (err) {
        return err;
    }
    err = patch ? pel_scene_keep(scene, time_s, patch, state, fault) : PEL_OK;
    if (err) {
        pel_resources_finish(&next);
        return err;
    }
    const struct pel_snapshot *snapshot = pel_snapshot_build_going(
        state, next.sea, next.ground.bed, next.sky.picture, &next.fleet,
        next.weather.field, next.sea == scene->has.sea ? going : NULL);
    pel_resources_finish(&scene->has);
    pel_snapshot_unref(scene->snapshot);
    pel_scene_put_by(scene, scene->state);
    scene->has = next;
    scene->snapshot = snapshot;
    scene->state = state;
    if (snapshot->ship_count > 0 && scene->ship_timer == 0 && !scene->apart) {
        scene->ship_timer = g_timeout_add(SHIP_MS, on_ship_timer, scene);
    }
    return PEL_OK;
}

/* The ships that the edit leaves alone, by the index of their entity in `next`,
 * so that their steps go on; what the patch says was tested before. (The sea is
 * compared when it is made.) */
static void ships_going_on(const struct pel_scene *scene,
                           const Pelagos__State *next,
                           const struct pel_sailing *out[PEL_MAX_ENTITIES])
{
    const Pelagos__State *now = scene->state;
    memset(out, 0, PEL_MAX_ENTITIES * sizeof *out);
    if (scene->snapshot->ship_count == 0 ||
        !pel_message_same(&now->origin->base, &next->origin->base) ||
        now->clock->time != next->clock->time ||
        now->clock->rate != next->clock->rate ||
        now->exercise->mark != next->exercise->mark) {
        return;
    }
    for (size_t k = 0; k < scene->snapshot->ship_count; k++) {
        const struct pel_sailing *ship = &scene->snapshot->ships[k];
        const Pelagos__Entity *e = now->entities[ship->entity];
        const Pelagos__OwnShip *before = pel_helm_on(now, e);
        for (size_t i = 0; i < next->n_entities && before; i++) {
            const Pelagos__Entity *n = next->entities[i];
            const Pelagos__OwnShip *after = pel_helm_on(next, n);
            if (n->id == e->id && after &&
                pel_message_same(&e->base, &n->base) &&
                pel_message_same(&before->base, &after->base)) {
                out[i] = ship;
            }
        }
    }
}

enum pel_err pel_scene_edited(struct pel_scene *scene,
                              const Pelagos__Patch *patch, double time_s,
                              Pelagos__State **out, struct pel_fault *fault)
{
    if (!pel_reserve_whole()) {
        return pel_fault_set(fault, PEL_ERR_NO_MEMORY, "out of memory");
    }
    pel_scene_refresh(scene, time_s);
    Pelagos__State *former = scene->former;
    scene->former = NULL;
    enum pel_err err =
        pel_state_apply_onto(former, scene->state, patch, out, fault);
    if (err) {
        return err;
    }
    (*out)->revision = scene->state->revision + 1;
    err = pel_state_check(*out, fault);
    if (!err) {
        err = pel_sea_settle(*out, fault);
    }
    if (!err) {
        err = pel_weather_lead_check(scene->state, *out, patch, fault);
    }
    if (err) {
        pel_scene_put_by(scene, *out);
    }
    return err;
}

void pel_scene_tries(struct pel_scene *scene, bool begin)
{
    scene->tries += begin ? 1 : -1U;
    if (scene->tries == 0) {
        pel_shared_sea_unref(scene->tried);
        scene->tried = NULL;
    }
}

/* The sea of a state that is tried: the one in force, the last that was tried,
 * or another. */
static enum pel_err tried_sea(struct pel_scene *scene,
                              const Pelagos__State *state,
                              struct pel_shared_sea **out,
                              struct pel_fault *fault)
{
    enum pel_err err = pel_shared_sea_get(state, &scene->means, NULL,
                                          scene->has.sea, out, fault);
    if (err || scene->tries == 0 || *out == scene->has.sea) {
        return err;
    }
    struct pel_shared_sea *again = NULL;
    if (scene->tried) {
        err = pel_shared_sea_get(state, &scene->means, NULL, scene->tried,
                                 &again, fault);
    }
    if (!err && again == scene->tried && again) {
        pel_shared_sea_unref(*out);
        *out = again;
        return PEL_OK;
    }
    pel_shared_sea_unref(again);
    pel_shared_sea_unref(scene->tried);
    scene->tried = pel_shared_sea_ref(*out);
    return PEL_OK;
}

enum pel_err pel_scene_try_snapshot(struct pel_scene *scene,
                                    const Pelagos__Patch *patch,
                                    const struct pel_snapshot **out,
                                    struct pel_fault *fault)
{
    if (!patch) {
        *out = pel_scene_snapshot(scene);
        return PEL_OK;
    }
    Pelagos__State *next;
    struct pel_shared_sea *sea = NULL;
    enum pel_err err =
        pel_scene_edited(scene, patch, pel_scene_time(scene), &next, fault);
    if (err) {
        return err;
    }
    err = tried_sea(scene, next, &sea, fault);
    if (!err) {
        /* Light as numbers is of the water, wherever its bottom is. */
        *out = pel_snapshot_build(next, sea, NULL);
        pel_shared_sea_unref(sea);
    }
    pel_scene_put_by(scene, next);
    return err;
}

enum pel_err pel_scene_commit(struct pel_scene *scene, Pelagos__State *next,
                              const Pelagos__Patch *patch,
                              const struct pel_resources *ready, double time_s,
                              int64_t now_ns, struct pel_fault *fault)
{
    const struct pel_sailing *going[PEL_MAX_ENTITIES];
    char notice[PEL_NOTICE];
    ships_going_on(scene, next, going);
    pel_state_notice(scene->state, patch, notice);
    enum pel_err err = pel_scene_refuse_led(scene, fault);
    if (!err) {
        err = commit(scene, next, patch, time_s, going, ready, fault);
    }
    if (err) {
        pel_scene_put_by(scene, next);
        return err;
    }
    if (notice[0]) {
        static struct pel_log_limit limit;
        pel_log_limited(&limit, PEL_LOG_INFO, "SCN-035", "%s", notice);
    }
    pel_missing_edited(&scene->missing, patch);
    set_clock(scene, next->clock, time_s, now_ns);
    notify(scene, time_s, patch);
    return PEL_OK;
}

void pel_scene_notify_commit(struct pel_scene *scene)
{
    pel_scene_save_soon(scene);
    for (size_t i = 0; i < scene->callback_count; i++) {
        scene->callbacks[i].call(scene->callbacks[i].user);
    }
}

enum pel_err pel_scene_patch(struct pel_scene *scene,
                             const Pelagos__Patch *patch,
                             struct pel_fault *fault)
{
    Pelagos__State *next;
    pel_scene_catch_up(scene);
    int64_t now_ns = pel_now_ns();
    double time_s = pel_simclock_at(&scene->clock, now_ns);
    enum pel_err err = pel_scene_refuse_led(scene, fault);
    if (!err) {
        err = pel_scene_edited(scene, patch, time_s, &next, fault);
    }
    if (!err) {
        err = pel_scene_commit(scene, next, patch, NULL, time_s, now_ns, fault);
    }
    if (!err) {
        pel_scene_notify_commit(scene);
    }
    return err;
}

static enum pel_err refuse_step(const char *path, double value, double minimum,
                                double maximum, struct pel_fault *fault)
{
    pel_fault_set(fault, PEL_ERR_OUT_OF_RANGE, "%s must be %.17g to %g s", path,
                  minimum, maximum);
    if (fault) {
        g_strlcpy(fault->path, path, sizeof fault->path);
        fault->unit = "s";
        fault->minimum = minimum;
        fault->maximum = maximum;
    }
    if (fault && isfinite(value)) {
        pel_json_number(value, fault->value);
    }
    return PEL_ERR_OUT_OF_RANGE;
}

enum pel_err pel_scene_test(struct pel_scene *scene,
                            const Pelagos__Patch *patch,
                            struct pel_fault *fault)
{
    Pelagos__State *next;
    enum pel_err err =
        pel_scene_edited(scene, patch, pel_scene_time(scene), &next, fault);
    if (!err) {
        pel_scene_put_by(scene, next);
    }
    return err;
}

/* The clock stands where a step may move it. */
static enum pel_err steps(const struct pel_scene *scene,
                          struct pel_fault *fault)
{
    if (scene->held.on) {
        return pel_fault_set(fault, PEL_ERR_BUSY,
                             "a step waits for the sea of an exercise's event "
                             "or of the weather; a little later");
    }
    enum pel_err err = pel_scene_refuse_led(scene, fault);
    return err ? err
           : scene->clock.mode == PEL_CLOCK_FREE
               ? pel_fault_set(fault, PEL_ERR_CONFLICT,
                               "the clock runs freely; set clock.mode to "
                               "STEPPED before a step")
               : PEL_OK;
}

/* A ship takes each of its steps through the sea, and somebody may act often:
 * not too many at once. */
static double longest_step(const struct pel_scene *scene)
{
    double at;
    bool acts = next_to_act(scene, PEL_MAX_TIME_S, &at);
    return scene->snapshot->ship_count > 0 || acts ? PEL_SHIP_AHEAD_S
                                                   : MAX_STEP_S;
}

/* Or it is held at a moment on the way. FULL: the clock is stepped, and the
 * step cannot be kept. */
static enum pel_err go_to(struct pel_scene *scene, double time_s,
                          struct pel_fault *fault)
{
    enum pel_clock_mode mode = scene->clock.mode;
    pel_scene_act_until(scene, time_s);
    if (goes_by_steps(scene) && waits(scene)) {
        scene->held.on = true;
        scene->held.mode = mode;
        scene->held.at_s = scene->clock.base_s;
        scene->held.to_s = time_s;
        return PEL_OK;
    }
    enum pel_err err = pel_scene_keep(scene, time_s, NULL, scene->state, fault);
    if (err && scene->clock.mode == PEL_CLOCK_STEPPED) {
        return err; /* frames and hosts go on, whatever the disk does */
    }
    scene->clock.base_s = time_s;
    advance_ships(scene, time_s);
    pel_scene_save_soon(scene);
    notify(scene, time_s, NULL);
    return PEL_OK;
}

void pel_scene_go_on(struct pel_scene *scene, bool over)
{
    pel_scene_done done = scene->held.done;
    void *user = scene->held.user;
    struct pel_fault fault = { 0 };
    enum pel_err err = PEL_OK;
    if (!scene->held.on || (!over && waits(scene))) {
        return;
    }
    scene->held.on = false;
    if (over) {
        err = pel_fault_set(&fault, PEL_ERR_CONFLICT, "the daemon is stopping");
    } else if (scene->clock.mode != scene->held.mode ||
               scene->clock.base_s != scene->held.at_s) {
        err = pel_fault_set(&fault, PEL_ERR_CONFLICT,
                            "the clock was set while the step waited for the "
                            "sea of an exercise's event or of the weather");
    } else {
        err = go_to(scene, scene->held.to_s, &fault);
        if (scene->held.on) {
            return;
        }
    }
    scene->held.done = NULL;
    pel_scene_notify_commit(scene);
    (void)pel_scene_answer(scene, NULL, done, user, err, &fault);
}

bool pel_scene_holds(const struct pel_scene *scene)
{
    return scene->held.on;
}

enum pel_err pel_scene_step(struct pel_scene *scene, double seconds,
                            struct pel_fault *fault)
{
    enum pel_err err = steps(scene, fault);
    if (err) {
        return err;
    }
    double most_s = longest_step(scene);
    if (!(seconds >= 0 && seconds <= most_s)) {
        return refuse_step("step.seconds", seconds, 0, most_s, fault);
    }
    return go_to(scene, fmin(scene->clock.base_s + seconds, PEL_MAX_TIME_S),
                 fault);
}

enum pel_err pel_scene_step_to(struct pel_scene *scene, double time_s,
                               struct pel_fault *fault)
{
    enum pel_err err = steps(scene, fault);
    if (err) {
        return err;
    }
    double longest_s = longest_step(scene);
    double most_s = longest_s < MAX_STEP_S
                        ? fmin(scene->clock.base_s + longest_s, PEL_MAX_TIME_S)
                        : PEL_MAX_TIME_S;
    if (!(time_s >= scene->clock.base_s && time_s <= most_s)) {
        return refuse_step("step.until", time_s, scene->clock.base_s, most_s,
                           fault);
    }
    return go_to(scene, time_s, fault);
}

enum pel_err pel_scene_command_step(struct pel_scene *scene,
                                    const Pelagos__ClockStep *step,
                                    struct pel_fault *fault)
{
    return step->has_until ? pel_scene_step_to(scene, step->until, fault)
                           : pel_scene_step(scene, step->seconds, fault);
}

bool pel_scene_submit_step(struct pel_scene *scene,
                           const Pelagos__ClockStep *step, pel_scene_done done,
                           void *user)
{
    struct pel_fault fault = { 0 };
    enum pel_err err = pel_scene_command_step(scene, step, &fault);
    if (!err && scene->held.on) {
        scene->held.done = done;
        scene->held.user = user;
        return true;
    }
    return pel_scene_answer(scene, NULL, done, user, err, &fault);
}

/* Who was silent when the file was written may speak now, and who led time has
 * to come again. */
static void nobody_yet(Pelagos__State *state)
{
    Pelagos__Sources *s = state->sources;
    if (state->clock->mode == PELAGOS__CLOCK_MODE__HOST) {
        state->clock->mode = PELAGOS__CLOCK_MODE__FREE;
    }
    s->cigi_stale = s->modbus_stale = s->nmea_stale = false;
    s->console_stale = s->other_stale = false;
}

/* Who waits is told; the snapshot may not be there. */
static void scene_free(struct pel_scene *scene)
{
    struct pel_fault over;
    pel_fault_set(&over, PEL_ERR_CONFLICT, "the daemon is stopping");
    pel_scene_end_waiting(scene);
    pel_scene_ungate(scene, &over);
    g_free(scene->led.cure);
    pel_snapshot_unref(scene->snapshot);
    pel_resources_finish(&scene->has);
    if (scene->state) {
        pelagos__state__free_unpacked(scene->state, NULL);
    }
    if (scene->former) {
        pelagos__state__free_unpacked(scene->former, NULL);
    }
    g_free((char *)scene->files.bathymetry);
    g_free((char *)scene->files.models);
    g_free((char *)scene->files.panoramas);
    g_free((char *)scene->files.weather);
    g_free(scene->spectra);
    pel_missing_finish(&scene->missing);
    for (size_t i = 0; i < scene->loss_count; i++) {
        g_free(scene->losses[i].kept);
    }
    pel_store_close(scene->store);
    g_free(scene);
}

/* The first commit, without the files that are gone. */
static enum pel_err begin(struct pel_scene *scene, Pelagos__State *state,
                          struct pel_fault *fault)
{
    enum pel_err err = pel_sea_settle(state, fault);
    struct pel_fault why;
    if (err) {
        return err;
    }
    err = commit(scene, state, NULL, 0, NULL, NULL, &why);
    for (int i = 0; err && i < PEL_MISSING_COUNT; i++) {
        enum pel_missing_kind kind =
            strcmp(why.path, pel_missing_path(PEL_MISSING_SEABED)) == 0
                ? PEL_MISSING_SEABED
                : PEL_MISSING_SPECTRUM;
        if (pel_missing_may(kind, state)) {
            pel_missing_note(&scene->missing, kind, state, &why);
            err = commit(scene, state, NULL, 0, NULL, NULL, &why);
        }
    }
    if (err && fault) {
        *fault = why;
    }
    return err;
}

static enum pel_err need_directory(const char *option, const char *path,
                                   struct pel_fault *fault)
{
    if (!path || g_file_test(path, G_FILE_TEST_IS_DIR)) {
        return PEL_OK;
    }
    return pel_fault_set(fault, PEL_ERR_NOT_FOUND,
                         "%s: %.140s is no directory; make it, name another, "
                         "or say off",
                         option, path);
}

enum pel_err pel_scene_create(const struct pel_scene_options *options,
                              struct pel_scene **out, struct pel_fault *fault)
{
    Pelagos__State *state = NULL;
    struct pel_store *store = NULL;
    struct pel_loaded loaded = { 0 };
    *out = NULL;
    enum pel_err err = need_directory("--spectra", options->spectra, fault);
    if (!err) {
        err = need_directory("--bathymetry", options->bathymetry, fault);
    }
    if (!err) {
        err = need_directory("--models", options->models, fault);
    }
    if (!err) {
        err = need_directory("--panoramas", options->panoramas, fault);
    }
    if (!err) {
        err = need_directory("--weather", options->weather, fault);
    }
    if (!err && options->state_path) {
        err = pel_store_open(options->state_path, &store, fault);
    }
    if (!err) {
        err = pel_scene_load(store, options, &state, &loaded, fault);
    }
    if (err || pel_trial()) {
        pel_store_close(store);
        store = NULL;
    }
    if (err) {
        return err;
    }
    struct pel_scene *scene = g_new0(struct pel_scene, 1);
    scene->store = store;
    scene->loss_count = loaded.loss_count;
    memcpy(scene->losses, loaded.losses, sizeof scene->losses);
    scene->apart = options->apart;
    scene->means.wave_count =
        options->wave_count > 0 ? options->wave_count : DEFAULT_WAVES;
    scene->means.spectra = scene->spectra = g_strdup(options->spectra);
    scene->files.bathymetry = g_strdup(options->bathymetry);
    scene->files.models = g_strdup(options->models);
    scene->files.panoramas = g_strdup(options->panoramas);
    scene->files.weather = g_strdup(options->weather);
    if ((options->bathymetry || options->models || options->panoramas ||
         options->weather) &&
        pel_sandbox_lack(pel_sandbox_walls())) {
        pel_warn("SCN-010", "files of others are read in a process with %s",
                 pel_sandbox_lack(pel_sandbox_walls()));
    }
    pel_scene_begin_waiting(scene);
    nobody_yet(state);
    scene->files.forgiving = true;
    err = begin(scene, state, fault);
    scene->files.forgiving = false;
    if (err) {
        pelagos__state__free_unpacked(state, NULL);
        scene_free(scene);
        return err;
    }
    pel_simclock_set(&scene->clock, (enum pel_clock_mode)state->clock->mode,
                     state->clock->rate, state->clock->time, pel_now_ns());
    if (store) {
        pel_scene_begin_keeping(scene, options, &loaded);
    }
    *out = scene;
    return PEL_OK;
}

enum pel_err pel_scene_begin_anew(struct pel_scene *scene,
                                  Pelagos__State *state,
                                  struct pel_fault *fault)
{
    pel_state_fill(state, state->clock ? state->clock->time : 0);
    if (!scene->led.on) {
        state->clock->mode = PELAGOS__CLOCK_MODE__STEPPED;
    }
    enum pel_err err = pel_state_check(state, fault);
    if (!err) {
        err = pel_sea_settle(state, fault);
    }
    if (!err) {
        err = commit(scene, state, NULL, 0, NULL, NULL, fault);
    }
    if (err) {
        pelagos__state__free_unpacked(state, NULL);
        return err;
    }
    pel_simclock_set(&scene->clock, PEL_CLOCK_STEPPED, state->clock->rate,
                     state->clock->time, pel_now_ns());
    pel_scene_notify_commit(scene);
    return PEL_OK;
}

const struct pel_missing *pel_scene_missing(const struct pel_scene *scene)
{
    return &scene->missing;
}

bool pel_scene_destroy(struct pel_scene *scene)
{
    if (!scene) {
        return true;
    }
    bool kept = pel_scene_end_keeping(scene);
    if (scene->ship_timer != 0) {
        g_source_remove(scene->ship_timer);
    }
    scene_free(scene);
    return kept;
}

void pel_scene_collect(void *user, struct pel_metrics_page *page)
{
    const struct pel_scene *scene = user;
    pel_metric(page, "pelagos_scene_saves_total", PEL_METRIC_COUNTER,
               "Times the state file was written.", NULL, (double)scene->saves);
    pel_metric(page, "pelagos_scene_save_errors_total", PEL_METRIC_COUNTER,
               "Times the state file could not be written.", NULL,
               (double)scene->failed_saves);
    if (scene->journal) {
        pel_journal_collect(scene->journal, page);
    }
    pel_metric(page, "pelagos_scene_prepared_total", PEL_METRIC_COUNTER,
               "Seas built and files read before a patch was committed.", NULL,
               (double)scene->prepared);
    pel_metric(page, "pelagos_scene_waiting", PEL_METRIC_GAUGE,
               "Patches that wait for a sea or a file.", NULL,
               (double)scene->waiting->len);
    /* A sea that nobody asked for yet is not built for a number. */
    if (pel_shared_sea_built(scene->snapshot->sea)) {
        const struct pel_sea *sea = pel_snapshot_sea(scene->snapshot);
        pel_metric(
            page, "pelagos_sea_whitecaps_ratio", PEL_METRIC_GAUGE,
            "Share of the sea under whitecaps, as photographs count them.",
            NULL, sea->foam ? sea->foam->coverage : 0);
    }
}
