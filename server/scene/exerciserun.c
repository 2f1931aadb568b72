#include "scene/exerciserun.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/log.h"
#include "base/watch.h"
#include "fault.h"
#include "message.h"
#include "scene/scene_parts.h"

#define TIMER_MS 20
#define ROW_TICKS 10   /* from one row of facts to the next */
#define MARK_TICKS 100 /* from one mark to the next */
#define SKIP_S 10.0    /* a clock that leapt farther leaves moments out */

const Pelagos__ExerciseRun *
pel_exercise_run_state(const struct pel_exercise_run *run)
{
    return run->scene->state->exercise;
}

static bool runs(const struct pel_exercise_run *run)
{
    return run->leads && pel_exercise_run_state(run)->phase ==
                             PELAGOS__EXERCISE_PHASE__RUNNING;
}

static double tick_clock(const struct pel_exercise_run *run, int64_t tick)
{
    return pel_exercise_run_state(run)->offset +
           (double)tick * PEL_EXERCISE_TICK_S;
}

/* Exercise time at simulated time clock_s. */
static double time_at(const struct pel_exercise_run *run, double clock_s)
{
    const Pelagos__ExerciseRun *now = pel_exercise_run_state(run);
    return now->phase == PELAGOS__EXERCISE_PHASE__RUNNING
               ? fmax(clock_s - now->offset, 0)
               : now->time;
}

double pel_exercise_run_time(const struct pel_exercise_run *run)
{
    return time_at(run, pel_scene_time(run->scene));
}

/* The last moment that is not after clock_s has been looked at. */
static void align(struct pel_exercise_run *run, double clock_s)
{
    double offset = pel_exercise_run_state(run)->offset;
    run->tick = (int64_t)floor((clock_s - offset) / PEL_EXERCISE_TICK_S);
    while (tick_clock(run, run->tick + 1) <= clock_s) {
        run->tick++;
    }
    while (tick_clock(run, run->tick) > clock_s) {
        run->tick--;
    }
}

/* --- edits of ours -------------------------------------------------------- */

/* A patch with a state and an exercise in it. */
static Pelagos__Patch *new_patch(const Pelagos__Patch *from)
{
    Pelagos__Patch *patch =
        (Pelagos__Patch *)(from ? pel_message_copy(&from->base)
                                : pel_message_new(&pelagos__patch__descriptor));
    if (!patch->state) {
        patch->state =
            (Pelagos__State *)pel_message_new(&pelagos__state__descriptor);
    }
    if (!patch->state->exercise) {
        patch->state->exercise = (Pelagos__ExerciseRun *)pel_message_new(
            &pelagos__exercise_run__descriptor);
    }
    return patch;
}

static Pelagos__Clock *clock_in(Pelagos__Patch *patch)
{
    if (!patch->state->clock) {
        patch->state->clock =
            (Pelagos__Clock *)pel_message_new(&pelagos__clock__descriptor);
    }
    return patch->state->clock;
}

/* Commits a patch that needs no file and no other sea, and frees it. */
static enum pel_err commit(struct pel_exercise_run *run, Pelagos__Patch *patch,
                           double clock_s, struct pel_fault *fault)
{
    Pelagos__State *next;
    run->own = true;
    enum pel_err err =
        pel_scene_edited(run->scene, patch, clock_s, &next, fault);
    if (!err) {
        err = pel_scene_commit(run->scene, next, patch, NULL, clock_s,
                               pel_now_ns(), fault);
    }
    run->own = false;
    pelagos__patch__free_unpacked(patch, NULL);
    if (!err) {
        pel_scene_notify_commit(run->scene);
    }
    return err;
}

/* What cannot be, as these edits are ours, unless the disk is full, which its
 * journal tells. */
static void failed(const struct pel_exercise_run *run,
                   const struct pel_fault *fault)
{
    if (fault->code == PEL_ERR_FULL) {
        return;
    }
    pel_error("EXR-001", "exercise %s: %s", run->name, fault->message);
}

static GBytes *pack(const Pelagos__Patch *patch)
{
    size_t size = pelagos__patch__get_packed_size(patch);
    uint8_t *data = g_malloc(size + 1);
    pelagos__patch__pack(patch, data);
    return g_bytes_new_take(data, size);
}

/* Hands over a patch that may have to wait, and frees it. */
static void submit(struct pel_exercise_run *run, Pelagos__Patch *patch,
                   double clock_s, bool at_once, pel_scene_done done)
{
    run->asked = pack(patch);
    run->own = true;
    (void)pel_scene_act_patch(run->scene, patch, clock_s, at_once, done, run);
    run->own = false;
    pelagos__patch__free_unpacked(patch, NULL);
}

static bool is_ours(const struct pel_exercise_run *run,
                    const Pelagos__Patch *patch)
{
    if (run->own || run->returning) {
        return true;
    }
    if (!run->asked) {
        return false;
    }
    g_autoptr(GBytes) bytes = pack(patch);
    return g_bytes_equal(bytes, run->asked);
}

static void settled(struct pel_exercise_run *run)
{
    g_clear_pointer(&run->asked, g_bytes_unref);
}

/* --- what everybody does -------------------------------------------------- */

static gboolean on_timer(gpointer user)
{
    PEL_WATCH("exercise");
    struct pel_exercise_run *run = user;
    if (!runs(run)) {
        run->timer = 0;
        return G_SOURCE_REMOVE;
    }
    pel_scene_catch_up(run->scene);
    return G_SOURCE_CONTINUE;
}

void pel_exercise_run_forget(struct pel_exercise_run *run)
{
    pel_scene_withdraw(run->scene, run);
    settled(run);
    run->leads = run->loading = run->start_then = false;
    g_clear_pointer(&run->past, pel_exercise_past_destroy);
    g_clear_pointer(&run->facts, pel_exercise_facts_destroy);
    if (run->exercise) {
        pelagos__exercise__free_unpacked(run->exercise, NULL);
        run->exercise = NULL;
    }
    g_clear_pointer(&run->name, g_free);
    g_clear_pointer(&run->digest, g_free);
}

static bool removes(const Pelagos__Patch *patch, const char *part,
                    const char *field)
{
    for (size_t i = 0; i < patch->n_remove; i++) {
        if (strcmp(patch->remove[i], part) == 0 ||
            g_str_has_prefix(patch->remove[i], field)) {
            return true;
        }
    }
    return false;
}

static void on_edit(void *user, double clock_s, const Pelagos__Patch *patch)
{
    struct pel_exercise_run *run = user;
    const Pelagos__State *to = patch ? patch->state : NULL;
    run->floor_s = clock_s;
    if (!patch) {
        return;
    }
    bool ours = is_ours(run, patch);
    bool touches =
        (to && to->exercise) || removes(patch, "exercise", "exercise.");
    bool leaps = (to && to->clock && to->clock->has_time) ||
                 removes(patch, "clock", "clock.time");
    if (leaps) {
        run->floor_s = run->scene->state->clock->time;
    }
    if (!run->leads) {
        return;
    }
    if (touches && !ours) {
        pel_warn("EXR-003",
                 "somebody else has edited `exercise`: exercise %s is left to "
                 "them",
                 run->name);
        pel_exercise_run_forget(run);
        return;
    }
    if (!run->returning) {
        pel_exercise_past_add(run->past, clock_s, time_at(run, clock_s), patch);
        if (leaps && runs(run)) {
            align(run, run->floor_s);
        }
    }
}

/* --- events --------------------------------------------------------------- */

static double next_moment(void *user, double until_s)
{
    struct pel_exercise_run *run = user;
    if (!runs(run) || run->returning || run->loading || run->asked) {
        return INFINITY;
    }
    double at = tick_clock(run, run->tick + 1);
    if (run->scene->clock.mode == PEL_CLOCK_FREE && until_s - at > SKIP_S) {
        align(run, until_s);
        at = tick_clock(run, run->tick);
        run->tick--;
    }
    return at;
}

static bool waits(void *user)
{
    const struct pel_exercise_run *run = user;
    return run->asked && !run->loading;
}

static void look(struct pel_exercise_run *run)
{
    const struct pel_snapshot *s = pel_scene_snapshot(run->scene);
    pel_exercise_moment_init(&run->moment, run->exercise, run->scene->state, s,
                             tick_clock(run, run->tick),
                             (double)run->tick * PEL_EXERCISE_TICK_S);
}

static void look_away(struct pel_exercise_run *run)
{
    pel_snapshot_unref(run->moment.snapshot);
    run->moment.snapshot = NULL;
}

/* What the event has done, in a patch that says it of all. */
static Pelagos__ExerciseDone *done_in(struct pel_exercise_run *run,
                                      Pelagos__Patch *patch, size_t index)
{
    Pelagos__ExerciseRun *to = patch->state->exercise;
    const Pelagos__ExerciseRun *now = pel_exercise_run_state(run);
    const char *name = run->exercise->events[index]->name;
    const ProtobufCFieldDescriptor *list =
        protobuf_c_message_descriptor_get_field_by_name(to->base.descriptor,
                                                        "events");
    Pelagos__ExerciseDone *mine = NULL;
    for (size_t i = 0; i < now->n_events; i++) {
        Pelagos__ExerciseDone *d =
            (Pelagos__ExerciseDone *)pel_message_append(&to->base, list);
        const Pelagos__ExerciseDone *was = now->events[i];
        d->event = strdup(was->event ? was->event : "");
        d->has_count = d->has_time = d->has_inside = true;
        d->count = was->count;
        d->time = was->time;
        d->inside = was->inside;
        mine = strcmp(d->event, name) == 0 ? d : mine;
    }
    if (!mine) {
        mine = (Pelagos__ExerciseDone *)pel_message_append(&to->base, list);
        mine->event = strdup(name);
        mine->has_count = mine->has_time = mine->has_inside = true;
    }
    return mine;
}

static void mark_fired(struct pel_exercise_run *run, Pelagos__Patch *patch,
                       size_t index)
{
    Pelagos__ExerciseDone *done = done_in(run, patch, index);
    done->count++;
    done->time = (double)run->tick * PEL_EXERCISE_TICK_S;
    done->inside = run->exercise->events[index]->each;
}

static double commit_clock(const struct pel_exercise_run *run)
{
    return fmax(tick_clock(run, run->tick), run->floor_s);
}

static void go_on(struct pel_exercise_run *run);

/* It is over for the event, whether the scene took its patch or not; where the
 * disk is full it stays due until there is room. */
static void fired(void *user, enum pel_err err, const struct pel_fault *fault)
{
    struct pel_exercise_run *run = user;
    struct pel_fault why;
    const char *name = run->exercise->events[run->event]->name;
    bool waited = !run->firing;
    settled(run);
    run->fired += !err;
    if (err && err != PEL_ERR_FULL) {
        run->refused++;
        pel_warn("EXR-006", "event %s of exercise %s changes nothing: %s %s",
                 name, run->name, fault->path, fault->message);
        Pelagos__Patch *patch = new_patch(NULL);
        mark_fired(run, patch, run->event);
        if (commit(run, patch, commit_clock(run), &why)) {
            failed(run, &why);
        }
    } else if (!err) {
        pel_info("EXR-007", "exercise %s, %.1f s: %s", run->name,
                 (double)run->tick * PEL_EXERCISE_TICK_S, name);
    }
    run->event++;
    if (waited) {
        go_on(run);
    }
}

static void fire(struct pel_exercise_run *run)
{
    Pelagos__Patch *patch = new_patch(run->exercise->events[run->event]->patch);
    mark_fired(run, patch, run->event);
    run->firing = true;
    submit(run, patch, commit_clock(run), false, fired);
    run->firing = false;
}

static void leave(struct pel_exercise_run *run)
{
    struct pel_fault why;
    Pelagos__Patch *patch = new_patch(NULL);
    done_in(run, patch, run->event)->inside = false;
    if (commit(run, patch, commit_clock(run), &why)) {
        failed(run, &why);
    }
    run->event++;
}

/* Where the ships' steps begin anew, with what a restart must know of them. */
static enum pel_err mark(struct pel_exercise_run *run, double clock_s,
                         double time_s, struct pel_fault *fault)
{
    Pelagos__Patch *patch = new_patch(NULL);
    pel_scene_refresh(run->scene, clock_s);
    pel_exercise_put_ships(run->scene->state, patch->state);
    patch->state->exercise->has_mark = true;
    patch->state->exercise->mark = time_s;
    enum pel_err err = commit(run, patch, clock_s, fault);
    if (!err) {
        pel_scene_refresh(run->scene, clock_s);
        pel_exercise_past_mark(run->past, time_s, run->scene->state);
    }
    return err;
}

static void finish_tick(struct pel_exercise_run *run)
{
    struct pel_fault why;
    if (run->tick % ROW_TICKS == 0) {
        look(run);
        pel_exercise_facts_add(run->facts, &run->moment);
        look_away(run);
    }
    if (run->tick > 0 && run->tick % MARK_TICKS == 0 &&
        mark(run, commit_clock(run), (double)run->tick * PEL_EXERCISE_TICK_S,
             &why)) {
        failed(run, &why);
    }
}

/* Carries out what is due at this moment, from run->event on. */
static void go_on(struct pel_exercise_run *run)
{
    while (run->leads && run->event < run->exercise->n_events) {
        switch (run->due[run->event]) {
        case PEL_DUE_FIRE:
            fire(run);
            break;
        case PEL_DUE_LEAVE:
            leave(run);
            break;
        default:
            run->event++;
        }
        if (run->asked) {
            return; /* `fired` goes on */
        }
    }
    if (run->leads) {
        finish_tick(run);
    }
}

static void on_moment(void *user, double clock_s)
{
    struct pel_exercise_run *run = user;
    (void)clock_s;
    run->tick++;
    run->event = 0;
    look(run);
    for (size_t i = 0; i < run->exercise->n_events; i++) {
        const Pelagos__ExerciseEvent *event = run->exercise->events[i];
        const Pelagos__ExerciseDone *done =
            pel_exercise_done(pel_exercise_run_state(run), event->name);
        bool over = !event->each && done && done->count > 0;
        bool inside = done && done->inside;
        bool holds = !over && pel_exercise_holds(&run->moment, event);
        run->due[i] = over || holds == inside ? PEL_DUE_NOT
                      : holds                 ? PEL_DUE_FIRE
                                              : PEL_DUE_LEAVE;
    }
    look_away(run);
    go_on(run);
}

/* --- life ----------------------------------------------------------------- */

void pel_exercise_run_init(struct pel_exercise_run *run,
                           struct pel_scene *scene,
                           struct pel_exercise_files *files,
                           const char *state_path)
{
    const struct pel_scene_acts acts = { next_moment, on_moment,
                                         waits,       on_edit,
                                         run,         pel_exercise_run_led };
    *run = (struct pel_exercise_run){ .scene = scene, .files = files };
    if (state_path) {
        run->kept_path = g_strconcat(state_path, ".exercise", NULL);
        run->facts_path = g_strconcat(state_path, ".exercise.csv", NULL);
    }
    pel_scene_add_acts(scene, &acts);
}

void pel_exercise_run_finish(struct pel_exercise_run *run)
{
    pel_exercise_run_forget(run);
    pel_scene_remove_acts(run->scene, run);
    if (run->timer) {
        g_source_remove(run->timer);
    }
    pel_exercise_heir_free(run);
    g_free(run->kept_path);
    g_free(run->facts_path);
}

/* Frees what was loaded and takes the exercise. */
static void take(struct pel_exercise_run *run, const char *name,
                 Pelagos__Exercise *exercise)
{
    size_t size = pelagos__exercise__get_packed_size(exercise);
    g_autofree uint8_t *bytes = g_malloc(size + 1);
    pelagos__exercise__pack(exercise, bytes);
    run->name = g_strdup(name);
    run->exercise = exercise;
    run->digest = pel_exercise_digest(exercise);
    if (run->kept_path && !pel_exercise_replace(run->kept_path, bytes, size)) {
        pel_warn("EXR-008",
                 "%s: a restart would not go on with exercise %s: %s",
                 run->kept_path, name, g_strerror(errno));
    }
}

static void begin(struct pel_exercise_run *run, double since_s)
{
    run->leads = true;
    run->past = pel_exercise_past_create();
    run->facts =
        pel_exercise_facts_create(run->exercise, run->facts_path, since_s);
    if (runs(run) && run->timer == 0) {
        run->timer = g_timeout_add(TIMER_MS, on_timer, run);
    }
}

static void loaded(void *user, enum pel_err err, const struct pel_fault *fault)
{
    struct pel_exercise_run *run = user;
    bool start = run->start_then;
    struct pel_fault why;
    settled(run);
    run->load_err = err;
    if (err) {
        run->load_fault = *fault;
        pel_warn("EXR-009", "exercise %s is not loaded: %s", run->name,
                 fault->message);
        pel_exercise_run_forget(run);
        return;
    }
    run->loading = run->start_then = false;
    begin(run, -1);
    run->tick = -1;
    pel_exercise_past_mark(run->past, 0, pel_scene_state(run->scene));
    if (start && pel_exercise_run_start(run, &why)) {
        pel_warn("EXR-010", "exercise %s is not started: %s", run->name,
                 why.message);
    }
}

static bool by_itself(const struct pel_exercise_run *run)
{
    return run->scene->clock.mode == PEL_CLOCK_FREE ||
           run->scene->clock.mode == PEL_CLOCK_PACED;
}

/* The rate that the scene's time has when nothing holds it. */
static double free_rate(const struct pel_exercise_run *run)
{
    const Pelagos__State *state = run->scene->state;
    Pelagos__ExercisePhase phase = state->exercise->phase;
    bool held = by_itself(run) && state->clock->rate == 0 &&
                (phase == PELAGOS__EXERCISE_PHASE__READY ||
                 phase == PELAGOS__EXERCISE_PHASE__PAUSED);
    return held ? state->exercise->rate : state->clock->rate;
}

/* Fields of `to` that a change of phase sets. */
static void set_phase(Pelagos__ExerciseRun *to, Pelagos__ExercisePhase phase,
                      double time_s, double since_s)
{
    to->has_phase = to->has_time = to->has_since = true;
    to->phase = phase;
    to->time = time_s;
    to->since = since_s;
}

enum pel_err pel_exercise_run_load(struct pel_exercise_run *run,
                                   const char *name,
                                   Pelagos__Exercise *exercise,
                                   struct pel_fault *fault)
{
    struct pel_exercise_beginning beginning;
    double now_s = pel_scene_time(run->scene);
    pel_exercise_run_forget(run);
    take(run, name, exercise);
    pel_scene_refresh(run->scene, now_s);
    pel_exercise_begin(exercise, run->scene->state, &beginning);
    Pelagos__Patch *patch = new_patch(&beginning.patch);
    pel_exercise_beginning_finish(&beginning);
    Pelagos__Clock *clock = clock_in(patch);
    Pelagos__ExerciseRun *to = patch->state->exercise;
    set_phase(to, PELAGOS__EXERCISE_PHASE__READY, 0, clock->time);
    to->name = strdup(name);
    to->digest = strdup(run->digest);
    to->has_offset = to->has_rate = true;
    to->offset = clock->time;
    to->rate = clock->has_rate ? clock->rate : free_rate(run);
    clock->has_rate = true;
    clock->rate = by_itself(run) ? 0 : to->rate;
    run->loading = true;
    run->load_err = PEL_OK;
    submit(run, patch, now_s, true, loaded);
    if (run->load_err && fault) {
        *fault = run->load_fault;
    }
    return run->load_err;
}

bool pel_exercise_run_resume(struct pel_exercise_run *run,
                             Pelagos__Exercise *exercise, double clock_s)
{
    const Pelagos__ExerciseRun *now = pel_exercise_run_state(run);
    struct pel_fault why;
    take(run, now->name, exercise);
    if (!now->digest || strcmp(now->digest, run->digest) != 0) {
        run->exercise = NULL;
        pel_exercise_run_forget(run);
        return false;
    }
    double time_s = time_at(run, clock_s);
    begin(run, time_s);
    align(run, clock_s);
    /* Its first moment is looked at by the step that leaves it. */
    if (now->phase == PELAGOS__EXERCISE_PHASE__READY ||
        (run->tick == 0 && tick_clock(run, 0) == clock_s &&
         now->n_events == 0)) {
        run->tick = -1;
    }
    if (mark(run, clock_s, time_s, &why)) {
        failed(run, &why);
    }
    pel_info("EXR-011", "exercise %s goes on at %.1f s", run->name, time_s);
    return true;
}

/* --- phases --------------------------------------------------------------- */

static enum pel_err need_loaded(const struct pel_exercise_run *run,
                                struct pel_fault *fault)
{
    return run->leads ? PEL_OK
                      : pel_fault_set(fault, PEL_ERR_CONFLICT, "%s",
                                      run->loading
                                          ? "the exercise is being loaded; a "
                                            "little later"
                                          : "no exercise is loaded; load one");
}

enum pel_err pel_exercise_run_start(struct pel_exercise_run *run,
                                    struct pel_fault *fault)
{
    if (run->loading) {
        run->start_then = true;
        return PEL_OK;
    }
    enum pel_err err = need_loaded(run, fault);
    if (err) {
        return err;
    }
    const Pelagos__ExerciseRun *now = pel_exercise_run_state(run);
    if (now->phase == PELAGOS__EXERCISE_PHASE__RUNNING) {
        return PEL_OK;
    }
    if (now->phase == PELAGOS__EXERCISE_PHASE__ENDED) {
        return pel_fault_set(fault, PEL_ERR_CONFLICT,
                             "the exercise has ended; load it again, or rewind "
                             "it");
    }
    double clock_s = pel_scene_time(run->scene);
    Pelagos__Patch *patch = new_patch(NULL);
    Pelagos__ExerciseRun *to = patch->state->exercise;
    set_phase(to, PELAGOS__EXERCISE_PHASE__RUNNING, now->time, clock_s);
    if (clock_s != now->since) { /* simulated time went on without it */
        to->has_offset = true;
        to->offset = clock_s - now->time;
    }
    clock_in(patch)->has_rate = true;
    patch->state->clock->rate = free_rate(run);
    err = commit(run, patch, clock_s, fault);
    if (!err && run->timer == 0) {
        run->timer = g_timeout_add(TIMER_MS, on_timer, run);
    }
    return err;
}

/* Another phase, in which exercise time stands; hold: simulated time too, where
 * it goes by itself. */
static enum pel_err stand(struct pel_exercise_run *run,
                          Pelagos__ExercisePhase phase, bool hold,
                          struct pel_fault *fault)
{
    double clock_s = pel_scene_time(run->scene);
    Pelagos__Patch *patch = new_patch(NULL);
    Pelagos__ExerciseRun *to = patch->state->exercise;
    pel_scene_refresh(run->scene, clock_s);
    double rate = free_rate(run);
    set_phase(to, phase, time_at(run, clock_s), clock_s);
    to->has_rate = true;
    to->rate = rate;
    clock_in(patch)->has_rate = true;
    patch->state->clock->rate = hold && by_itself(run) ? 0 : rate;
    return commit(run, patch, clock_s, fault);
}

enum pel_err pel_exercise_run_pause(struct pel_exercise_run *run,
                                    struct pel_fault *fault)
{
    enum pel_err err = need_loaded(run, fault);
    if (err ||
        pel_exercise_run_state(run)->phase == PELAGOS__EXERCISE_PHASE__PAUSED) {
        return err;
    }
    if (!runs(run)) {
        return pel_fault_set(fault, PEL_ERR_CONFLICT,
                             "the exercise does not run");
    }
    return stand(run, PELAGOS__EXERCISE_PHASE__PAUSED, true, fault);
}

enum pel_err pel_exercise_run_stop(struct pel_exercise_run *run,
                                   struct pel_fault *fault)
{
    enum pel_err err = need_loaded(run, fault);
    if (err ||
        pel_exercise_run_state(run)->phase == PELAGOS__EXERCISE_PHASE__ENDED) {
        return err;
    }
    return stand(run, PELAGOS__EXERCISE_PHASE__ENDED, false, fault);
}

/* --- rewinding ------------------------------------------------------------ */

static enum pel_err check_time(struct pel_exercise_run *run, double time_s,
                               struct pel_fault *fault)
{
    double first = pel_exercise_past_earliest(run->past);
    double last = pel_exercise_run_time(run);
    char value[G_ASCII_DTOSTR_BUF_SIZE], what[96];
    if (time_s >= first && time_s <= last) {
        return PEL_OK;
    }
    g_ascii_dtostr(value, sizeof value, time_s);
    snprintf(what, sizeof what, "must be %.1f to %.1f s: the exercise's past",
             first, last);
    pel_fault_refuse(PEL_ERR_OUT_OF_RANGE, "time", value, what, fault);
    if (fault) {
        fault->unit = "s";
        fault->minimum = first;
        fault->maximum = last;
    }
    return PEL_ERR_OUT_OF_RANGE;
}

/* Exercise time stands at time_s, the clock goes by `mode` again. */
static enum pel_err hold_at(struct pel_exercise_run *run, double time_s,
                            Pelagos__ClockMode mode, struct pel_fault *fault)
{
    double clock_s = pel_scene_time(run->scene);
    double rate = pel_scene_state(run->scene)->clock->rate;
    bool free =
        mode == PELAGOS__CLOCK_MODE__FREE || mode == PELAGOS__CLOCK_MODE__PACED;
    /* A moment at which it stood is not one at which nothing goes. */
    rate = rate > 0 ? rate : pel_exercise_run_state(run)->rate;
    Pelagos__Patch *patch = new_patch(NULL);
    Pelagos__ExerciseRun *to = patch->state->exercise;
    set_phase(to, PELAGOS__EXERCISE_PHASE__PAUSED, time_s, clock_s);
    to->has_rate = true;
    to->rate = rate;
    Pelagos__Clock *clock = clock_in(patch);
    clock->has_rate = clock->has_mode = true;
    clock->mode = mode;
    clock->rate = free ? 0 : rate;
    return commit(run, patch, clock_s, fault);
}

enum pel_err pel_exercise_run_rewind(struct pel_exercise_run *run,
                                     double time_s, struct pel_fault *fault)
{
    PEL_WATCH("exercise rewind");
    enum pel_err err = need_loaded(run, fault);
    if (!err && run->asked) {
        err = pel_fault_set(fault, PEL_ERR_BUSY,
                            "an event waits for its sea; a little later");
    }
    if (!err) {
        err = check_time(run, time_s, fault);
    }
    if (err) {
        return err;
    }
    Pelagos__ClockMode mode = run->scene->state->clock->mode;
    run->returning = true;
    pel_scene_repeat(run->scene, true);
    err = pel_exercise_past_return(run->past, run->scene, time_s, fault);
    pel_scene_repeat(run->scene, false);
    run->returning = false;
    double clock_s = pel_scene_time(run->scene);
    align(run, clock_s);
    if (pel_exercise_run_state(run)->phase == PELAGOS__EXERCISE_PHASE__READY) {
        run->tick = -1;
    }
    if (err) {
        (void)hold_at(run, time_at(run, clock_s), mode, NULL);
        return err;
    }
    pel_exercise_facts_cut(run->facts, time_s);
    return hold_at(run, time_s, mode, fault);
}
