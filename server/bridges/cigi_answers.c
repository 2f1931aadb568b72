#include "bridges/cigi_answers.h"

#include <glib.h>
#include <string.h>

#include "base/log.h"
#include "base/urgent.h"

#define MAX_JOBS 8
#define MAX_WAITING 4096
#define TELL_NS 60000000000LL

/* The requests of one moment; then its answers. */
struct job {
    bool stop;
    unsigned era; /* jobs of an earlier one are forgotten */
    struct pel_cigi_moment moment;
    struct pel_cigi_world world;
    size_t count, answer_count;
    struct pel_cigi_packet *questions;
    struct pel_cigi_packet *answers; /* at most 2 a question */
};

struct pel_cigi_answers {
    GThread *thread; /* NULL: answers are made at once */
    GAsyncQueue *jobs, *done;
    unsigned era;
    size_t made, dropped;
    size_t told_made, told_dropped; /* when the log was told */
    int64_t told_ns;                /* 0: never */
    size_t first, count;
    struct pel_cigi_packet waiting[MAX_WAITING];
};

static void job_free(struct job *job)
{
    if (job) {
        pel_snapshot_unref(job->moment.snapshot);
        g_free(job->questions);
        g_free(job->answers);
        g_free(job);
    }
}

static bool keep(void *user, const struct pel_cigi_packet *answer)
{
    struct job *job = user;
    job->answers[job->answer_count++] = *answer;
    return true;
}

static void work(struct job *job)
{
    const struct pel_cigi_packet *list[PEL_CIGI_MAX_QUESTIONS];
    for (size_t i = 0; i < job->count; i++) {
        list[i] = &job->questions[i];
    }
    job->answers = g_new(struct pel_cigi_packet, 2 * job->count);
    pel_cigi_answer(&job->moment, list, job->count, keep, job);
}

/* The host waits for its answers, so they do not wait for pictures. */
static gpointer run(gpointer user)
{
    struct pel_cigi_answers *a = user;
    struct pel_urgent urgent = { 0 };
    pel_urgent_begin(&urgent, PEL_URGENT_ANSWERS);
    for (;;) {
        pel_urgent_account(&urgent);
        struct job *job = g_async_queue_pop(a->jobs);
        if (job->stop) {
            job_free(job);
            return NULL;
        }
        work(job);
        g_async_queue_push(a->done, job);
    }
}

struct pel_cigi_answers *pel_cigi_answers_create(bool threaded)
{
    struct pel_cigi_answers *a = g_new0(struct pel_cigi_answers, 1);
    a->jobs = g_async_queue_new();
    a->done = g_async_queue_new();
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
        struct job *stop = g_new0(struct job, 1);
        stop->stop = true;
        g_async_queue_push_front(a->jobs, stop);
        g_thread_join(a->thread);
    }
    for (struct job *job; (job = g_async_queue_try_pop(a->jobs));) {
        job_free(job);
    }
    for (struct job *job; (job = g_async_queue_try_pop(a->done));) {
        job_free(job);
    }
    g_async_queue_unref(a->jobs);
    g_async_queue_unref(a->done);
    g_free(a);
}

/* Moves the answers of finished jobs into the ring. */
static void collect(struct pel_cigi_answers *a)
{
    for (struct job *job; (job = g_async_queue_try_pop(a->done));) {
        for (size_t i = 0; i < job->answer_count && job->era == a->era; i++) {
            if (a->count == MAX_WAITING) {
                a->dropped++;
                continue;
            }
            a->waiting[(a->first + a->count) % MAX_WAITING] = job->answers[i];
            a->count++;
            a->made++;
        }
        job_free(job);
    }
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
    if (count == 0) {
        return;
    }
    collect(a); /* in a flood no frame comes between */
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
    if (!a->thread) {
        work(job);
        g_async_queue_push(a->done, job);
        collect(a);
        return;
    }
    struct job *oldest = g_async_queue_length(a->jobs) >= MAX_JOBS
                             ? g_async_queue_try_pop(a->jobs)
                             : NULL;
    if (oldest) {
        a->dropped += oldest->count;
        job_free(oldest);
    }
    pel_beat();
    g_async_queue_push(a->jobs, job);
}

const struct pel_cigi_packet *pel_cigi_answers_peek(struct pel_cigi_answers *a)
{
    collect(a);
    return a->count > 0 ? &a->waiting[a->first] : NULL;
}

void pel_cigi_answers_pop(struct pel_cigi_answers *a)
{
    if (a->count > 0) {
        a->first = (a->first + 1) % MAX_WAITING;
        a->count--;
    }
}

void pel_cigi_answers_clear(struct pel_cigi_answers *a)
{
    a->era++;
    a->count = 0;
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
             "came than the processor answers; ask less often, about fewer "
             "places, draw fewer views, or permit real time (--realtime)",
             lost, asked);
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
