#include "net/series.h"

#include <stdlib.h>
#include <string.h>

#include "base/watch.h"
#include "bounds.h"
#include "message.h"
#include "net/command.h"
#include "net/series_parts.h"
#include "scene/sun.h"
#include "scene/worker.h"

#define AT_ONCE 2   /* questions of one series */
#define AGAIN_MS 20 /* after all places of its kind were taken */

struct pel_series {
    struct pel_scene *scene;
    struct pel_frames *frames;
    struct pel_claims *claims; /* NULL: nothing is counted */
    struct pel_worker *worker; /* makes the files */
    GPtrArray *jobs;           /* of struct pel_series_job */
    uint64_t questions;
};

struct pel_series_job {
    struct pel_task task;
    struct pel_series *all;
    struct pel_series_plan plan;
    struct pel_series_table table;
    struct pel_series_origin origin;
    struct pel_series_form form;
    size_t asked, answered;
    unsigned under_way;
    guint source; /* goes on soon; 0: no need */
    bool filing;  /* the worker has it */
    enum pel_err err;
    struct pel_fault fault;
    struct pel_series_answer answer;
    pel_series_done done;
    void *user;
};

/* A question of the series, then its answer. The worker takes the numbers: tens
 * of milliseconds for 10,000 points. */
struct asked {
    struct pel_task task;
    struct pel_series_job *job;
    size_t cell;
    struct pel_claim claim;
    ProtobufCMessage *answer; /* or these, of a surface: */
    struct pel_surface_sample *samples;
    size_t count;
    double time_s;
    enum pel_err err;
    struct pel_fault fault;
};

static void go_on(struct pel_series_job *job);

/* --- the end --------------------------------------------------------------
 */

static void job_free(struct pel_series_job *job)
{
    free(job->answer.data);
    pel_series_table_finish(&job->table);
    pel_series_plan_finish(&job->plan);
    pelagos__state__free_unpacked(job->origin.state, NULL);
    g_free(job);
}

/* Tells who waits. Questions that are still under way keep the job. */
static void job_end(struct pel_series_job *job)
{
    if (job->source) {
        g_source_remove(job->source);
        job->source = 0;
    }
    job->done(job->user, job->err, &job->fault, &job->answer);
    pel_scene_tries(job->all->scene, false);
    g_ptr_array_remove_fast(job->all->jobs, job);
    job->all = NULL;
    if (job->under_way == 0) {
        job_free(job);
    }
}

static void file_work(struct pel_task *task)
{
    struct pel_series_job *job = (struct pel_series_job *)task;
    pel_series_table_end(&job->table);
    job->err = pel_series_file(&job->table, &job->origin, &job->form,
                               &job->answer, &job->fault);
}

static void file_done(struct pel_task *task, bool dropped)
{
    struct pel_series_job *job = (struct pel_series_job *)task;
    if (dropped && !job->err) {
        job->err = pel_fault_set(&job->fault, PEL_ERR_CONFLICT,
                                 "the daemon is stopping");
    }
    job_end(job);
}

static void fail(struct pel_series_job *job, enum pel_err err,
                 const struct pel_fault *fault)
{
    if (!job->err) {
        job->err = err;
        job->fault = *fault;
    }
}

/* --- answers ---------------------------------------------------------------
 */

static gboolean on_soon(gpointer user)
{
    PEL_WATCH("series");
    struct pel_series_job *job = user;
    job->source = 0;
    go_on(job);
    return G_SOURCE_REMOVE;
}

static void soon(struct pel_series_job *job)
{
    if (!job->source) {
        job->source = g_idle_add(on_soon, job);
    }
}

static void asked_free(struct asked *asked)
{
    pel_claim_give(&asked->claim);
    free(asked->samples);
    if (asked->answer) {
        protobuf_c_message_free_unpacked(asked->answer, NULL);
    }
    g_free(asked);
}

static void taken(struct asked *asked)
{
    struct pel_series_job *job = asked->job;
    if (asked->err) {
        fail(job, asked->err, &asked->fault);
    }
    job->under_way--;
    job->answered++;
    asked_free(asked);
    if (job->all) {
        soon(job);
    } else if (job->under_way == 0) {
        job_free(job);
    }
}

static void take_numbers(struct pel_task *task)
{
    struct asked *asked = (struct asked *)task;
    struct pel_series_table *table = &asked->job->table;
    if (asked->answer) {
        asked->err = pel_series_table_take(table, asked->cell, asked->answer,
                                           &asked->fault);
        return;
    }
    Pelagos__Surface *surface =
        pel_surface_message(asked->time_s, asked->samples, asked->count);
    asked->err = pel_series_table_take(table, asked->cell, &surface->base,
                                       &asked->fault);
    pel_surface_message_free(surface);
}

static void numbers_taken(struct pel_task *task, bool dropped)
{
    struct asked *asked = (struct asked *)task;
    if (dropped) {
        asked->err = pel_fault_set(&asked->fault, PEL_ERR_CONFLICT,
                                   "the daemon is stopping");
    }
    taken(asked);
}

/* The answer has come, or why there is none. */
static void take(struct asked *asked, enum pel_err err,
                 const struct pel_fault *fault)
{
    PEL_WATCH("series");
    struct pel_series_job *job = asked->job;
    if (err) {
        asked->err = err;
        asked->fault = *fault;
    }
    if (err || job->err || !job->all) {
        taken(asked);
        return;
    }
    asked->task =
        (struct pel_task){ .work = take_numbers, .done = numbers_taken };
    pel_worker_push(job->all->worker, &asked->task);
}

static void take_message(struct asked *asked, enum pel_err err,
                         const struct pel_fault *fault,
                         const ProtobufCMessage *answer)
{
    asked->answer = err ? NULL : pel_message_copy(answer);
    take(asked, err, fault);
}

static void on_optics(void *user, enum pel_err err,
                      const struct pel_fault *fault,
                      const Pelagos__Optics *answer)
{
    take_message(user, err, fault, err ? NULL : &answer->base);
}

static void on_spectrum(void *user, enum pel_err err,
                        const struct pel_fault *fault,
                        const Pelagos__Spectrum *answer)
{
    take_message(user, err, fault, err ? NULL : &answer->base);
}

static void on_surface(void *user, enum pel_err err,
                       const struct pel_fault *fault,
                       struct pel_surface_answer *answer)
{
    struct asked *asked = user;
    if (answer) {
        asked->samples = g_steal_pointer(&answer->samples);
        asked->count = answer->count;
        asked->time_s = answer->time_s;
    }
    take(asked, err, fault);
}

/* --- questions ----------------------------------------------------------- */

/* All answers are to be of one sea, sky and water. */
static enum pel_err check_state(struct pel_series_job *job,
                                struct pel_fault *fault)
{
    const Pelagos__State *now = pel_scene_state(job->all->scene);
    Pelagos__State *then = job->origin.state;
    if (now->revision == then->revision) {
        return PEL_OK;
    }
    then->revision = now->revision;
    bool same = pel_message_same(&now->sea->base, &then->sea->base) &&
                pel_message_same(&now->sky->base, &then->sky->base) &&
                pel_message_same(&now->water->base, &then->water->base) &&
                pel_message_same(&now->origin->base, &then->origin->base) &&
                g_strcmp0(now->clock->utc, then->clock->utc) == 0;
    return same ? PEL_OK
                : pel_fault_set(fault, PEL_ERR_CONFLICT,
                                "sea, sky, water or origin were changed while "
                                "the series was under way: ask again");
}

static enum pel_err ask_it(struct pel_series_job *job,
                           ProtobufCMessage *question, struct asked *asked,
                           struct pel_fault *fault)
{
    struct pel_series *all = job->all;
    bool optics = job->plan.query->question_case ==
                  PELAGOS__SERIES_QUERY__QUESTION_OPTICS;
    if (job->plan.query->question_case ==
        PELAGOS__SERIES_QUERY__QUESTION_SPECTRUM) {
        return pel_command_spectrum(all->scene,
                                    (Pelagos__SpectrumQuery *)question,
                                    on_spectrum, asked, fault);
    }
    enum pel_err err = pel_claim_take(
        all->claims, optics ? PEL_CLAIM_OPTICS : PEL_CLAIM_SURFACES,
        &job->form.who, 1, &asked->claim, fault);
    if (err) {
        return err;
    }
    return optics ? pel_command_optics(all->frames,
                                       (Pelagos__OpticsQuery *)question,
                                       on_optics, asked, fault)
                  : pel_command_surface(
                        all->frames, (Pelagos__SurfaceQuery *)question, NULL,
                        PEL_RANK_NOBODY, NULL, on_surface, asked, fault);
}

static enum pel_err ask_one(struct pel_series_job *job, struct pel_fault *fault)
{
    struct pel_series *all = job->all;
    ProtobufCMessage *question = NULL;
    size_t cell = pel_series_cell(&job->plan, job->asked);
    enum pel_err err = check_state(job, fault);
    if (!err) {
        err = pel_series_question(&job->plan, cell, &question, fault);
    }
    if (err) {
        return err;
    }
    struct asked *asked = g_new0(struct asked, 1);
    *asked = (struct asked){ .job = job, .cell = cell };
    job->asked++;
    job->under_way++;
    all->questions++;
    err = ask_it(job, question, asked, fault);
    protobuf_c_message_free_unpacked(question, NULL);
    if (err) {
        asked_free(asked);
        job->asked--;
        job->under_way--;
    }
    return err;
}

static void finish(struct pel_series_job *job)
{
    if (job->err) {
        job_end(job);
        return;
    }
    job->filing = true;
    job->task = (struct pel_task){ .work = file_work, .done = file_done };
    pel_worker_push(job->all->worker, &job->task);
}

/* Asks as much as may be under way, and ends the job where nothing is left. */
static void go_on(struct pel_series_job *job)
{
    struct pel_fault fault;
    enum pel_err err = PEL_OK;
    if (!job->err && job->asked < job->plan.cells && job->under_way < AT_ONCE) {
        err = ask_one(job, &fault);
        if (err == PEL_ERR_BUSY) { /* others have all places */
            if (!job->source) {
                job->source = g_timeout_add(AGAIN_MS, on_soon, job);
            }
            return;
        }
        if (err) {
            fail(job, err, &fault);
        } else if (job->under_way < AT_ONCE) {
            soon(job); /* at the loop's next turn: each turn is short */
        }
    }
    bool all = job->err || job->answered == job->plan.cells;
    if (all && job->under_way == 0) {
        finish(job);
    }
}

/* --- from outside ----------------------------------------------------------
 */

struct pel_series *pel_series_create(struct pel_scene *scene,
                                     struct pel_frames *frames,
                                     struct pel_claims *claims)
{
    struct pel_series *all = g_new0(struct pel_series, 1);
    all->scene = scene;
    all->frames = frames;
    all->claims = claims;
    all->worker = pel_worker_create("series");
    all->jobs = g_ptr_array_new();
    return all;
}

void pel_series_collect(const struct pel_series *all,
                        struct pel_metrics_page *page)
{
    pel_metric(page, "pelagos_series_under_way", PEL_METRIC_GAUGE,
               "Series of numbers that are being answered.", NULL,
               (double)all->jobs->len);
    pel_metric(page, "pelagos_series_questions_total", PEL_METRIC_COUNTER,
               "Questions asked for series.", NULL, (double)all->questions);
}

void pel_series_destroy(struct pel_series *all)
{
    if (!all) {
        return;
    }
    pel_worker_destroy(all->worker);
    struct pel_fault fault;
    pel_fault_set(&fault, PEL_ERR_CONFLICT, "the daemon is stopping");
    while (all->jobs->len > 0) {
        struct pel_series_job *job = g_ptr_array_index(all->jobs, 0);
        fail(job, PEL_ERR_CONFLICT, &fault);
        job_end(job);
    }
    g_ptr_array_free(all->jobs, TRUE);
    g_free(all);
}

/* The parts of the state that the answers are of. */
static Pelagos__State *state_of(struct pel_scene *scene)
{
    Pelagos__State some = *pel_scene_state(scene);
    some.n_views = some.n_entities = some.n_presets = 0;
    Pelagos__State *copy = (Pelagos__State *)pel_message_copy(&some.base);
    return copy;
}

static void note_origin(struct pel_series_job *job)
{
    struct pel_series_origin *o = &job->origin;
    g_autoptr(GDateTime) now = g_date_time_new_now_utc();
    g_autofree char *text = g_date_time_format(now, "%Y-%m-%dT%H:%M:%SZ");
    g_strlcpy(o->when, text, sizeof o->when);
    g_strlcpy(o->device, pel_frames_device(job->all->frames), sizeof o->device);
    o->state = state_of(job->all->scene);
    if (pel_utc_parse(o->state->clock->utc, &o->epoch_unix_s)) {
        o->epoch_unix_s = 0;
    }
}

enum pel_err
pel_series_ask(struct pel_series *all, const Pelagos__SeriesQuery *query,
               const struct pel_series_form *form, pel_series_done done,
               void *user, struct pel_series_job **out, struct pel_fault *fault)
{
    struct pel_taken taken = { { 0 }, 0 };
    for (guint i = 0; i < all->jobs->len; i++) {
        const struct pel_series_job *each = g_ptr_array_index(all->jobs, i);
        pel_taken_add(&taken, &form->who, &each->form.who, 1);
    }
    enum pel_share_answer share =
        pel_share_ask(PEL_BOUND_SERIES, &taken, &form->who, 1);
    if (share) {
        return pel_fault_set(
            fault, PEL_ERR_BUSY,
            "%u series are under way already, as many as there "
            "may be %s",
            all->jobs->len, pel_share_words(share, form->who.rank));
    }
    struct pel_series_job *job = g_new0(struct pel_series_job, 1);
    enum pel_err err = pel_series_plan_make(query, &job->plan, fault);
    if (err) {
        pel_series_plan_finish(&job->plan);
        g_free(job);
        return err;
    }
    pel_series_table_init(&job->plan, &job->table);
    job->all = all;
    job->form = *form;
    job->done = done;
    job->user = user;
    pel_series_plan_at(&job->plan, pel_scene_time(all->scene));
    note_origin(job);
    g_ptr_array_add(all->jobs, job);
    pel_scene_tries(all->scene, true);
    soon(job);
    *out = job;
    return PEL_OK;
}

void pel_series_cancel(struct pel_series_job *job)
{
    struct pel_fault fault;
    pel_fault_set(&fault, PEL_ERR_CONFLICT, "nobody waits for it any more");
    if (!job->filing) {
        fail(job, PEL_ERR_CONFLICT, &fault);
        soon(job);
    }
}
