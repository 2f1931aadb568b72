#include "scene/exercise.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/log.h"
#include "base/trial.h"
#include "base/watch.h"
#include "fault.h"
#include "message.h"
#include "scene/exercise_parts.h"
#include "scene/exerciserun.h"
#include "scene/scene_parts.h"

#define MOST_FACTS (1u << 20) /* of one answer */
#define MOST_KEPT (4u << 20)
#define FILES_NICE 10

/* --- what a client asks for ----------------------------------------------- */

/* The earliest time that an event waits for by time alone. */
static void find_next(const struct pel_exercise_run *run,
                      Pelagos__ExerciseStatus *out)
{
    const Pelagos__ExerciseRun *now = pel_exercise_run_state(run);
    const Pelagos__ExerciseEvent *next = NULL;
    double best = INFINITY;
    for (size_t i = 0; i < run->exercise->n_events; i++) {
        const Pelagos__ExerciseEvent *event = run->exercise->events[i];
        const Pelagos__ExerciseDone *done = pel_exercise_done(now, event->name);
        for (size_t k = 0; k < event->n_when && !(done && done->count); k++) {
            const Pelagos__ExerciseWhen *w = event->when[k];
            if (w->has_at && w->at < best) {
                best = w->at;
                next = event;
            }
        }
    }
    if (next) {
        out->next = strdup(next->name);
        out->has_next_time = true;
        out->next_time = best;
    }
}

static void put_ships(const Pelagos__Exercise *exercise,
                      Pelagos__ExerciseStatus *out)
{
    size_t count = pel_exercise_ship_count(exercise);
    out->ships = calloc(count, sizeof *out->ships);
    for (size_t i = 0; out->ships && i < count; i++) {
        out->ships[out->n_ships++] = pel_exercise_ship(exercise, i);
    }
}

static Pelagos__ExerciseStatus *status(const struct pel_exercise_run *run)
{
    Pelagos__ExerciseStatus *out = (Pelagos__ExerciseStatus *)pel_message_new(
        &pelagos__exercise_status__descriptor);
    const Pelagos__ExerciseRun *now = pel_exercise_run_state(run);
    out->run = (Pelagos__ExerciseRun *)pel_message_copy(&now->base);
    out->has_leads = out->has_time = true;
    out->leads = run->leads;
    out->time = pel_exercise_run_time(run);
    if (run->leads) {
        double earliest = pel_exercise_past_earliest(run->past);
        out->title = run->exercise->title ? strdup(run->exercise->title) : NULL;
        out->has_events = true;
        out->events = (uint32_t)run->exercise->n_events;
        out->has_earliest = isfinite(earliest);
        out->earliest = out->has_earliest ? earliest : 0;
        put_ships(run->exercise, out);
        find_next(run, out);
    }
    return out;
}

static enum pel_err refuse_ship(const Pelagos__Exercise *exercise,
                                uint32_t ship, struct pel_fault *fault)
{
    char value[16];
    g_autoptr(GString) what = g_string_new("must be one of the own ships:");
    for (size_t i = 0; i < pel_exercise_ship_count(exercise); i++) {
        g_string_append_printf(what, " %u", pel_exercise_ship(exercise, i));
    }
    g_snprintf(value, sizeof value, "%u", ship);
    return pel_fault_refuse(PEL_ERR_INVALID, "ship", value, what->str, fault);
}

static enum pel_err give_facts(const struct pel_exercise_run *run,
                               const Pelagos__ExerciseCommand *command,
                               Pelagos__ExerciseStatus *out,
                               struct pel_fault *fault)
{
    double more;
    if (!run->facts) {
        return pel_fault_set(fault, PEL_ERR_CONFLICT,
                             "no exercise is loaded, so there are no facts");
    }
    int ship = command->has_ship
                   ? pel_exercise_ship_index(run->exercise, command->ship)
                   : 0;
    if (ship < 0) {
        return refuse_ship(run->exercise, command->ship, fault);
    }
    g_autofree char *text = pel_exercise_sheet_text(
        pel_exercise_facts_of(run->facts, (size_t)ship),
        command->has_time ? command->time : 0, MOST_FACTS, &more);
    out->facts = strdup(text);
    out->has_more = !isnan(more);
    out->more = out->has_more ? more : 0;
    return PEL_OK;
}

/* What was loaded last; NULL: nothing is kept. */
static Pelagos__Exercise *kept(const struct pel_exercises *all)
{
    char *bytes = NULL;
    size_t size = 0;
    if (!all->run.kept_path ||
        pel_file_read(all->run.kept_path, MOST_KEPT, &bytes, &size, NULL)) {
        return NULL;
    }
    Pelagos__Exercise *exercise =
        pelagos__exercise__unpack(NULL, size, (const uint8_t *)bytes);
    free(bytes);
    return exercise;
}

/* The part of a command that reads and writes files. */
struct filed {
    bool done;
    enum pel_err err;
    struct pel_fault fault;
    Pelagos__Exercise *read;         /* of SHOW and LOAD; or NULL */
    Pelagos__Exercise *before;       /* of LOAD: what was loaded; or NULL */
    Pelagos__ExerciseStatus *listed; /* of LIST; or NULL */
};

static enum pel_err need_exercise(const Pelagos__ExerciseCommand *command,
                                  struct pel_fault *fault)
{
    return command->exercise ? PEL_OK
                             : pel_fault_refuse(PEL_ERR_INVALID, "exercise",
                                                NULL, "is missing", fault);
}

static enum pel_err check_time(const Pelagos__ExerciseCommand *command,
                               struct pel_fault *fault)
{
    bool good =
        !command->has_time || (command->time >= 0 && command->time <= 1e9);
    return good ? PEL_OK
                : pel_fault_refuse(PEL_ERR_OUT_OF_RANGE, "time", NULL,
                                   "must be 0 to 1e9 s", fault);
}

/* Any thread. */
static void do_files(const struct pel_exercises *all,
                     const Pelagos__ExerciseCommand *c, struct filed *out)
{
    struct pel_exercise_files *files = all->files;
    struct pel_fault *fault = &out->fault;
    out->done = true;
    out->err = check_time(c, fault);
    if (out->err) {
        return; /* a command that is refused changes no file */
    }
    switch (c->action) {
    case PELAGOS__EXERCISE_ACTION__LIST:
        out->listed = (Pelagos__ExerciseStatus *)pel_message_new(
            &pelagos__exercise_status__descriptor);
        pel_exercise_files_list(files, out->listed);
        break;
    case PELAGOS__EXERCISE_ACTION__SHOW:
        out->err = pel_exercise_files_read(files, c->name, &out->read, fault);
        break;
    case PELAGOS__EXERCISE_ACTION__LOAD:
        out->err = pel_exercise_files_read(files, c->name, &out->read, fault);
        out->before = out->err ? NULL : kept(all);
        break;
    case PELAGOS__EXERCISE_ACTION__CHECK:
        out->err = need_exercise(c, fault);
        out->err = out->err ? out->err : pel_exercise_check(c->exercise, fault);
        break;
    case PELAGOS__EXERCISE_ACTION__SAVE:
        out->err = need_exercise(c, fault);
        out->err = out->err ? out->err
                            : pel_exercise_files_save(files, c->name,
                                                      c->exercise, fault);
        break;
    case PELAGOS__EXERCISE_ACTION__DELETE:
        out->err = pel_exercise_files_delete(files, c->name, fault);
        break;
    default:
        break;
    }
}

static void filed_finish(struct filed *filed)
{
    if (filed->read) {
        pelagos__exercise__free_unpacked(filed->read, NULL);
    }
    if (filed->before) {
        pelagos__exercise__free_unpacked(filed->before, NULL);
    }
    if (filed->listed) {
        pelagos__exercise_status__free_unpacked(filed->listed, NULL);
    }
}

static enum pel_err load(struct pel_exercises *all, const char *name,
                         struct filed *filed, struct pel_fault *fault)
{
    if (filed->before) {
        pel_exercise_facts_remove(filed->before, all->run.facts_path);
    }
    return pel_exercise_run_load(&all->run, name, g_steal_pointer(&filed->read),
                                 fault);
}

/* Whether it changes the scene, and not just files. */
static bool edits(Pelagos__ExerciseAction action)
{
    return action == PELAGOS__EXERCISE_ACTION__LOAD ||
           action == PELAGOS__EXERCISE_ACTION__START ||
           action == PELAGOS__EXERCISE_ACTION__PAUSE ||
           action == PELAGOS__EXERCISE_ACTION__REWIND ||
           action == PELAGOS__EXERCISE_ACTION__STOP;
}

static enum pel_err act(struct pel_exercises *all,
                        const Pelagos__ExerciseCommand *c, struct filed *filed,
                        struct pel_fault *fault)
{
    enum pel_err err =
        edits(c->action) ? pel_scene_refuse_led(all->run.scene, fault) : PEL_OK;
    if (err) {
        return err;
    }
    if (!filed->done) {
        do_files(all, c, filed);
    }
    if (filed->err) {
        *fault = filed->fault;
        return filed->err;
    }
    switch (c->action) {
    case PELAGOS__EXERCISE_ACTION__LOAD:
        return load(all, c->name, filed, fault);
    case PELAGOS__EXERCISE_ACTION__START:
        return pel_exercise_run_start(&all->run, fault);
    case PELAGOS__EXERCISE_ACTION__PAUSE:
        return pel_exercise_run_pause(&all->run, fault);
    case PELAGOS__EXERCISE_ACTION__REWIND:
        return c->has_time
                   ? pel_exercise_run_rewind(&all->run, c->time, fault)
                   : pel_fault_refuse(PEL_ERR_INVALID, "time", NULL,
                                      "is missing: the exercise time to go "
                                      "back to",
                                      fault);
    case PELAGOS__EXERCISE_ACTION__STOP:
        return pel_exercise_run_stop(&all->run, fault);
    default:
        return PEL_OK;
    }
}

static enum pel_err carry_out(struct pel_exercises *all,
                              const Pelagos__ExerciseCommand *command,
                              struct filed *filed,
                              Pelagos__ExerciseStatus **out,
                              struct pel_fault *fault)
{
    *out = NULL;
    pel_scene_catch_up(all->run.scene);
    enum pel_err err = act(all, command, filed, fault);
    if (err) {
        return err;
    }
    *out = status(&all->run);
    (*out)->exercise = g_steal_pointer(&filed->read);
    if (filed->listed) {
        (*out)->n_exercises = filed->listed->n_exercises;
        (*out)->exercises = g_steal_pointer(&filed->listed->exercises);
        filed->listed->n_exercises = 0;
    }
    if (command->action == PELAGOS__EXERCISE_ACTION__FACTS) {
        err = give_facts(&all->run, command, *out, fault);
    }
    if (err) {
        pelagos__exercise_status__free_unpacked(*out, NULL);
        *out = NULL;
    }
    return err;
}

enum pel_err pel_exercises_command(struct pel_exercises *all,
                                   const Pelagos__ExerciseCommand *command,
                                   Pelagos__ExerciseStatus **out,
                                   struct pel_fault *fault)
{
    PEL_WATCH("exercise command");
    struct filed filed = { .err = PEL_OK };
    enum pel_err err = carry_out(all, command, &filed, out, fault);
    filed_finish(&filed);
    return err;
}

/* --- with files by a thread ----------------------------------------------- */

struct asked {
    struct pel_task task;
    struct pel_exercises *all;
    Pelagos__ExerciseCommand *command; /* ours */
    struct filed filed;
    pel_exercises_done done;
    void *user;
};

static void look_at_files(struct pel_task *task)
{
    struct asked *asked = (struct asked *)task;
    do_files(asked->all, asked->command, &asked->filed);
}

static void go_on(struct pel_task *task, bool dropped)
{
    struct asked *asked = (struct asked *)task;
    struct pel_scene *scene = asked->all->run.scene;
    uint64_t before = scene->state->revision;
    struct pel_fault fault = { 0 };
    Pelagos__ExerciseStatus *out = NULL;
    enum pel_err err = dropped ? pel_fault_set(&fault, PEL_ERR_CONFLICT,
                                               "the daemon is stopping")
                               : carry_out(asked->all, asked->command,
                                           &asked->filed, &out, &fault);
    asked->done(asked->user, err, &fault, out,
                scene->state->revision != before);
    filed_finish(&asked->filed);
    pelagos__exercise_command__free_unpacked(asked->command, NULL);
    g_free(asked);
}

void pel_exercises_ask(struct pel_exercises *all,
                       const Pelagos__ExerciseCommand *command,
                       pel_exercises_done done, void *user)
{
    struct asked *asked = g_new0(struct asked, 1);
    asked->task = (struct pel_task){ .work = look_at_files, .done = go_on };
    asked->all = all;
    asked->command =
        (Pelagos__ExerciseCommand *)pel_message_copy(&command->base);
    asked->done = done;
    asked->user = user;
    bool files = command->action == PELAGOS__EXERCISE_ACTION__LIST ||
                 command->action == PELAGOS__EXERCISE_ACTION__SHOW ||
                 command->action == PELAGOS__EXERCISE_ACTION__CHECK ||
                 command->action == PELAGOS__EXERCISE_ACTION__SAVE ||
                 command->action == PELAGOS__EXERCISE_ACTION__DELETE ||
                 command->action == PELAGOS__EXERCISE_ACTION__LOAD;
    if (files || pel_worker_count(all->worker) > 0) {
        pel_worker_push(all->worker, &asked->task);
    } else {
        go_on(&asked->task, false);
    }
}

void pel_exercises_glance(struct pel_exercises *all,
                          struct pel_exercise_glance *out)
{
    const struct pel_exercise_run *run = &all->run;
    const Pelagos__ExerciseRun *now = pel_exercise_run_state(run);
    *out = (struct pel_exercise_glance){ .phase = now->phase };
    out->time_s = pel_exercise_run_time(run);
    out->events = run->leads ? (uint32_t)run->exercise->n_events : 0;
    for (size_t i = 0; i < now->n_events; i++) {
        out->fired += now->events[i]->count;
    }
    if (run->facts) {
        pel_exercise_sheet_glance(pel_exercise_facts_of(run->facts, 0), out);
    }
}

size_t pel_exercises_count(struct pel_exercises *all)
{
    return pel_exercise_files_names(all->files)->len;
}

char *pel_exercises_name(struct pel_exercises *all, size_t number)
{
    const GPtrArray *names = pel_exercise_files_names(all->files);
    return number < names->len ? g_strdup(names->pdata[number]) : NULL;
}

int pel_exercises_number(struct pel_exercises *all, const char *name)
{
    const GPtrArray *names = pel_exercise_files_names(all->files);
    name = name ? name : pel_exercise_run_state(&all->run)->name;
    for (guint i = 0; name && i < names->len; i++) {
        if (strcmp(names->pdata[i], name) == 0) {
            return (int)i;
        }
    }
    return -1;
}

double pel_exercises_time(struct pel_exercises *all)
{
    return pel_exercise_run_time(&all->run);
}

/* --- life ----------------------------------------------------------------- */

/* The exercise that ran when the daemon ended. */
static void resume(struct pel_exercises *all)
{
    struct pel_fault fault;
    if (!pel_exercise_run_named(&all->run)) {
        return;
    }
    Pelagos__Exercise *exercise = kept(all);
    if (!exercise || pel_exercise_check(exercise, &fault) ||
        !pel_exercise_run_resume(&all->run, exercise,
                                 pel_scene_time(all->run.scene))) {
        pel_warn("EXR-002",
                 "exercise %s does not go on: what is kept of it is not what "
                 "the state names; load it again",
                 pel_exercise_run_state(&all->run)->name);
        if (exercise) {
            pelagos__exercise__free_unpacked(exercise, NULL);
        }
    }
}

enum pel_err pel_exercises_create(const struct pel_exercises_options *options,
                                  struct pel_scene *scene,
                                  struct pel_exercises **out,
                                  struct pel_fault *fault)
{
    *out = NULL;
    if (options->directory &&
        !g_file_test(options->directory, G_FILE_TEST_IS_DIR)) {
        return pel_fault_set(fault, PEL_ERR_NOT_FOUND,
                             "--exercises: %.140s is no directory; make it, "
                             "name another, or say off",
                             options->directory);
    }
    struct pel_exercises *all = g_new0(struct pel_exercises, 1);
    all->files = pel_exercise_files_create(options->directory);
    all->worker = pel_worker_create("exercises");
    pel_worker_set_nice(all->worker, FILES_NICE);
    pel_exercise_run_init(&all->run, scene, all->files, options->state_path);
    if (!pel_trial()) {
        resume(all);
    }
    *out = all;
    return PEL_OK;
}

void pel_exercises_destroy(struct pel_exercises *all)
{
    if (all) {
        pel_worker_destroy(all->worker);
        pel_exercise_run_finish(&all->run);
        pel_exercise_files_destroy(all->files);
        g_free(all);
    }
}

void pel_exercises_collect(void *user, struct pel_metrics_page *page)
{
    const struct pel_exercises *all = user;
    pel_metric(page, "pelagos_exercise_events_total", PEL_METRIC_COUNTER,
               "Events of exercises that took effect.", NULL,
               (double)all->run.fired);
    pel_metric(page, "pelagos_exercise_refused_total", PEL_METRIC_COUNTER,
               "Events of exercises that the scene refused.", NULL,
               (double)all->run.refused);
    pel_metric(page, "pelagos_exercise_past_bytes", PEL_METRIC_GAUGE,
               "Bytes that are kept for a rewind.", NULL,
               all->run.past ? (double)pel_exercise_past_bytes(all->run.past)
                             : 0);
    pel_metric(page, "pelagos_exercise_facts_bytes", PEL_METRIC_GAUGE,
               "Bytes of facts.", NULL,
               all->run.facts ? (double)pel_exercise_facts_bytes(all->run.facts)
                              : 0);
}
