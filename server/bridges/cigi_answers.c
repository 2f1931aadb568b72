#include "bridges/cigi_answers.h"

#include <glib.h>
#include <string.h>

#include "base/log.h"
#include "base/urgent.h"

#define MAX_HELD PEL_BOUND_CIGI_WAITING
#define EXACT 2 /* moments of a sea of FFT that may wait for each other */
#define TELL_NS 60000000000LL

/* The requests of one moment; then its answers. */
struct job {
    unsigned era; /* jobs of an earlier one are forgotten */
    struct pel_cigi_moment moment;
    struct pel_cigi_world world;
    size_t count, answer_count;
    struct pel_cigi_packet *questions;
    struct pel_cigi_packet *answers; /* at most 2 a question */
};

struct pel_cigi_answers {
    GThread *thread; /* NULL: answers are made at once */
    GMutex lock;     /* jobs, done, stop */
    GCond asked;
    GQueue jobs, done;
    bool stop;
    unsigned era;
    size_t held; /* requests of jobs that are not freed */
    size_t made, dropped;
    size_t told_made, told_dropped; /* when the log was told */
    int64_t told_ns;                /* 0: never */
    GQueue ready;                   /* jobs whose answers are not sent */
    size_t sent;                    /* answers of the first of them that are */
    GList *at;                      /* the job that is taken from; NULL: none */
    size_t next;                    /* of its answers */
};

static void job_free(struct job *job)
{
    pel_snapshot_unref(job->moment.snapshot);
    g_free(job->questions);
    g_free(job->answers);
    g_free(job);
}

/* Frees all; returns how many requests they were. */
static size_t empty(GQueue *jobs)
{
    size_t count = 0;
    for (struct job *job; (job = g_queue_pop_head(jobs));) {
        count += job->count;
        job_free(job);
    }
    return count;
}

static bool keep(void *user, const struct pel_cigi_packet *answer)
{
    struct job *job = user;
    job->answers[job->answer_count++] = *answer;
    return true;
}

static void work(struct job *job, const struct pel_cigi_moment *moment)
{
    const struct pel_cigi_packet *list[PEL_CIGI_MAX_QUESTIONS];
    for (size_t i = 0; i < job->count; i++) {
        list[i] = &job->questions[i];
    }
    job->answers = g_new(struct pel_cigi_packet, 2 * job->count);
    pel_cigi_answer(moment, list, job->count, keep, job);
}

/* The jobs that are done next, all about the moment of the last of them. Where
 * moments of a sea come faster than they can be computed, that is all that
 * wait: as CIGI has it, an answer names the host frame that was the newest when
 * it was calculated. */
static void take_next(struct pel_cigi_answers *a, GQueue *batch)
{
    const struct job *newest = g_queue_peek_tail(&a->jobs);
    size_t count = g_queue_get_length(&a->jobs);
    if (count <= EXACT || !pel_snapshot_transforms(newest->moment.snapshot)) {
        count = 1;
    }
    while (count-- > 0) {
        g_queue_push_tail(batch, g_queue_pop_head(&a->jobs));
    }
}

/* The host waits for its answers, so they do not wait for pictures. */
static gpointer run(gpointer user)
{
    struct pel_cigi_answers *a = user;
    struct pel_urgent urgent = { 0 };
    pel_urgent_begin(&urgent, PEL_URGENT_ANSWERS);
    g_mutex_lock(&a->lock);
    while (!a->stop) {
        GQueue batch = G_QUEUE_INIT;
        if (g_queue_is_empty(&a->jobs)) {
            g_cond_wait(&a->asked, &a->lock);
            continue;
        }
        take_next(a, &batch);
        g_mutex_unlock(&a->lock);
        const struct job *last = g_queue_peek_tail(&batch);
        for (const GList *l = batch.head; l; l = l->next) {
            pel_urgent_account(&urgent);
            work(l->data, &last->moment);
        }
        g_mutex_lock(&a->lock);
        for (struct job *job; (job = g_queue_pop_head(&batch));) {
            g_queue_push_tail(&a->done, job);
        }
    }
    g_mutex_unlock(&a->lock);
    return NULL;
}

struct pel_cigi_answers *pel_cigi_answers_create(bool threaded)
{
    struct pel_cigi_answers *a = g_new0(struct pel_cigi_answers, 1);
    g_mutex_init(&a->lock);
    g_cond_init(&a->asked);
    if (threaded) {
        a->thread = g_thread_new("cigi", run, a);
    }
    return a;
}

void pel_cigi_answers_destroy(struct pel_cigi_answers *a)
{
    if (!a) {
        return;
    }
    if (a->thread) {
        g_mutex_lock(&a->lock);
        a->stop = true;
        g_cond_signal(&a->asked);
        g_mutex_unlock(&a->lock);
        g_thread_join(a->thread);
    }
    empty(&a->jobs);
    empty(&a->done);
    empty(&a->ready);
    g_cond_clear(&a->asked);
    g_mutex_clear(&a->lock);
    g_free(a);
}

static void forget(struct pel_cigi_answers *a, struct job *job)
{
    a->held -= job->count;
    job_free(job);
}

/* Takes the jobs that are done to those whose answers are sent. */
static void collect(struct pel_cigi_answers *a)
{
    GQueue done = G_QUEUE_INIT;
    g_mutex_lock(&a->lock);
    for (gpointer job; (job = g_queue_pop_head(&a->done));) {
        g_queue_push_tail(&done, job);
    }
    g_mutex_unlock(&a->lock);
    for (struct job *job; (job = g_queue_pop_head(&done));) {
        if (job->era != a->era) {
            forget(a, job);
            continue;
        }
        a->made += job->answer_count;
        g_queue_push_tail(&a->ready, job);
    }
    a->at = a->at ? a->at : a->ready.head;
}

static struct job *job_of(struct pel_cigi_answers *a,
                          const struct pel_cigi_moment *moment,
                          const struct pel_cigi_packet *const *questions,
                          size_t count)
{
    struct job *job = g_new0(struct job, 1);
    job->era = a->era;
    job->moment = *moment;
    job->world = *moment->world;
    job->moment.world = &job->world;
    job->moment.snapshot = pel_snapshot_ref(moment->snapshot);
    job->count = count;
    job->questions = g_new(struct pel_cigi_packet, count);
    for (size_t i = 0; i < count; i++) {
        job->questions[i] = *questions[i];
    }
    return job;
}

/* Makes room for `count` requests at the cost of the oldest that wait; false:
 * there is none. */
static bool make_room(struct pel_cigi_answers *a, size_t count)
{
    struct job *oldest = NULL;
    do {
        if (a->held + count <= MAX_HELD) {
            return true;
        }
        g_mutex_lock(&a->lock);
        oldest = g_queue_pop_head(&a->jobs);
        g_mutex_unlock(&a->lock);
        if (oldest) {
            a->dropped += oldest->count;
            forget(a, oldest);
        }
    } while (oldest);
    a->dropped += count;
    return false;
}

void pel_cigi_answers_ask(struct pel_cigi_answers *a,
                          const struct pel_cigi_moment *moment,
                          const struct pel_cigi_packet *const *questions,
                          size_t count)
{
    if (count > PEL_CIGI_MAX_QUESTIONS) {
        a->dropped += count - PEL_CIGI_MAX_QUESTIONS;
        count = PEL_CIGI_MAX_QUESTIONS;
    }
    if (count == 0 || !make_room(a, count)) {
        return;
    }
    struct job *job = job_of(a, moment, questions, count);
    a->held += count;
    if (!a->thread) {
        work(job, &job->moment);
        g_queue_push_tail(&a->done, job);
        return;
    }
    pel_beat();
    g_mutex_lock(&a->lock);
    g_queue_push_tail(&a->jobs, job);
    g_cond_signal(&a->asked);
    g_mutex_unlock(&a->lock);
}

void pel_cigi_answers_begin(struct pel_cigi_answers *a, bool sent)
{
    collect(a);
    if (!sent) {
        a->at = a->ready.head;
        a->next = a->sent;
        return;
    }
    while (a->at && a->ready.head != a->at) {
        forget(a, g_queue_pop_head(&a->ready));
    }
    a->sent = a->next;
    if (a->at && a->next == ((struct job *)a->at->data)->answer_count) {
        forget(a, g_queue_pop_head(&a->ready));
        a->at = a->ready.head;
        a->sent = a->next = 0;
    }
}

const struct pel_cigi_packet *pel_cigi_answers_peek(struct pel_cigi_answers *a)
{
    collect(a);
    while (a->at) {
        const struct job *job = a->at->data;
        if (a->next < job->answer_count) {
            return &job->answers[a->next];
        }
        if (!a->at->next) {
            return NULL;
        }
        a->at = a->at->next;
        a->next = 0;
    }
    return NULL;
}

void pel_cigi_answers_pop(struct pel_cigi_answers *a)
{
    if (pel_cigi_answers_peek(a)) {
        a->next++;
    }
}

void pel_cigi_answers_clear(struct pel_cigi_answers *a)
{
    a->era++;
    g_mutex_lock(&a->lock);
    a->held -= empty(&a->jobs);
    a->held -= empty(&a->done);
    g_mutex_unlock(&a->lock);
    a->held -= empty(&a->ready);
    a->at = NULL;
    a->sent = a->next = 0;
}

bool pel_cigi_answers_tell(struct pel_cigi_answers *a, int64_t now_ns)
{
    size_t lost = a->dropped - a->told_dropped;
    size_t asked = lost + a->made - a->told_made;
    if (lost == 0 || (a->told_ns && now_ns - a->told_ns < TELL_NS)) {
        return false;
    }
    pel_warn("CIG-015",
             "%zu of %zu requests of the CIGI host were not answered: more "
             "than %d came with one frame, or %d waited; ask less often, about "
             "fewer places, draw fewer views, or permit real time "
             "(--realtime)",
             lost, asked, PEL_CIGI_MAX_QUESTIONS, MAX_HELD);
    a->told_ns = now_ns;
    a->told_made = a->made;
    a->told_dropped = a->dropped;
    return true;
}

void pel_cigi_answers_lose(struct pel_cigi_answers *a, size_t count)
{
    a->dropped += count;
}

size_t pel_cigi_answers_made(const struct pel_cigi_answers *a)
{
    return a->made;
}

size_t pel_cigi_answers_dropped(const struct pel_cigi_answers *a)
{
    return a->dropped;
}
