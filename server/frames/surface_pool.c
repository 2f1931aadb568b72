#include "frames/surface_pool.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <unistd.h>

#include "base/clock.h"
#include "base/lock.h"
#include "base/reserve.h"
#include "base/urgent.h"
#include "ocean/fields.h"

#define STOP_NS 1000000000LL
#define TEXT_NICE 10
#define KEPT_NS                                                                \
    5000000000LL /* what was computed for queries, after the last              \
                  */

/* A moment to be prepared. */
struct prefetched {
    const struct pel_snapshot *snapshot; /* NULL: none */
    double time_s;
    bool moving;
    struct pel_box of;
    int64_t begin_ns;
};

struct pel_surface_pool {
    pthread_mutex_t lock; /* protects all below and the queries' counts */
    pthread_cond_t asked, over, answered;
    struct pel_queue queue;
    struct pel_queue texts; /* answered, to be written by a thread of its own */
    struct prefetched prefetched[PEL_MOST_PREPARED]; /* newest first */
    bool fresh;        /* the next slice is a first one, if there is any */
    atomic_bool hurry; /* somebody asks, or all ends */
    bool stop;
    int count, ended;
    pthread_t threads[PEL_SURFACE_POOL_MAX + 1]; /* the last one writes */
    struct pel_mailbox *box;
};

/* Takes the first in the queue off it, or the first that has not begun; NULL:
 * nobody asks. */
static struct pel_surface_query *next_query(struct pel_surface_pool *self)
{
    size_t before = 0;
    const struct pel_mail *mail = self->queue.first;
    self->fresh = !self->fresh;
    while (self->fresh && mail &&
           ((const struct pel_surface_query *)mail)->begun > 0) {
        mail = mail->next;
        before++;
    }
    for (; mail && before > 0; before--) { /* at most 16 are there */
        pel_queue_push(&self->queue, pel_queue_pop(&self->queue));
    }
    return (struct pel_surface_query *)pel_queue_pop(&self->queue);
}

/* The next slice; has the lock. A query goes to the queue's end with each, and
 * leaves it with its last. */
static struct pel_surface_query *take(struct pel_surface_pool *self,
                                      size_t *first, size_t *count)
{
    struct pel_surface_query *query = next_query(self);
    if (query) {
        size_t left = query->count - query->begun;
        *first = query->begun;
        *count = left < PEL_SURFACE_SLICE ? left : PEL_SURFACE_SLICE;
        query->begun += *count;
        if (query->begun < query->count) {
            pel_queue_push(&self->queue, &query->mail);
        }
    }
    atomic_store(&self->hurry, self->queue.first != NULL);
    return query;
}

/* --- preparing -------------------------------------------------------------
 */

struct worker {
    struct pel_surface_pool *all;
    struct pel_urgent urgent;
};

static bool go_on(void *user)
{
    struct worker *worker = user;
    pel_urgent_account(&worker->urgent);
    return !atomic_load(&worker->all->hurry);
}

/* Index of the next moment to prepare, −1: none. */
static int next_prefetch(const struct pel_surface_pool *self)
{
    int next = -1;
    for (int i = 0; i < PEL_MOST_PREPARED; i++) {
        const struct prefetched *f = &self->prefetched[i];
        if (f->snapshot &&
            (next < 0 || f->begin_ns < self->prefetched[next].begin_ns)) {
            next = i;
        }
    }
    return next;
}

/* Has the lock, not while it computes. Threads that are idle prepare the same
 * moment; whoever finds nothing left of it takes it off. */
static void prepare(struct worker *worker, int index)
{
    struct pel_surface_pool *self = worker->all;
    struct prefetched f = self->prefetched[index];
    pel_snapshot_ref(f.snapshot);
    pthread_mutex_unlock(&self->lock);
    bool whole = pel_snapshot_prepare(f.snapshot, f.time_s, f.moving, &f.of,
                                      go_on, worker);
    pthread_mutex_lock(&self->lock);
    for (int i = 0; i < PEL_MOST_PREPARED; i++) {
        struct prefetched *still = &self->prefetched[i];
        bool this = still->snapshot == f.snapshot && still->time_s == f.time_s;
        if (this && (whole || !atomic_load(&self->hurry))) {
            pel_snapshot_unref(still->snapshot);
            still->snapshot = NULL;
        }
    }
    pel_snapshot_unref(f.snapshot);
}

/* Nobody asks: prepares, or waits. */
static void idle(struct worker *worker)
{
    struct pel_surface_pool *self = worker->all;
    int next = next_prefetch(self);
    if (next < 0) {
        int64_t before_ns = pel_now_ns();
        pel_cond_wait_ns(&self->asked, &self->lock, KEPT_NS);
        if (pel_now_ns() - before_ns >= KEPT_NS) {
            pthread_mutex_unlock(&self->lock);
            pel_fields_forget(before_ns);
            pthread_mutex_lock(&self->lock);
        }
        return;
    }
    int64_t wait_ns = self->prefetched[next].begin_ns - pel_now_ns();
    if (wait_ns > 0) {
        pel_cond_wait_ns(&self->asked, &self->lock, wait_ns);
    } else {
        prepare(worker, next);
    }
}

void pel_surface_pool_prepare(struct pel_surface_pool *self,
                              const struct pel_snapshot *snapshot,
                              double time_s, bool moving,
                              const struct pel_box *of, int64_t begin_ns)
{
    struct prefetched *f = self->prefetched;
    pthread_mutex_lock(&self->lock);
    pel_snapshot_unref(f[PEL_MOST_PREPARED - 1].snapshot);
    memmove(f + 1, f, (PEL_MOST_PREPARED - 1) * sizeof *f);
    f[0] = (struct prefetched){ pel_snapshot_ref(snapshot), time_s, moving, *of,
                                begin_ns };
    pthread_mutex_unlock(&self->lock);
    pthread_cond_broadcast(&self->asked);
}

/* --- answering --------------------------------------------------------------
 */

static bool is_slow(const struct pel_surface_query *query)
{
    return query->form.slow && query->count > PEL_SURFACE_SLICE;
}

static void write_slice(struct pel_surface_query *query, size_t first,
                        size_t count)
{
    struct pel_surface_text *part = &query->parts[first / PEL_SURFACE_SLICE];
    part->text =
        query->form.slice(query->samples + first, first, count, &part->size);
}

static void answer(struct pel_surface_query *query, size_t first, size_t count)
{
    struct pel_surface_sample *samples = query->samples + first;
    pel_snapshot_surface(query->snapshot, query->points + first, count,
                         query->time_s, query->moving, samples);
    if (query->foam) {
        pel_snapshot_foam(query->snapshot, count, query->time_s, samples);
    }
    if (query->form.slice && count > 0 && !is_slow(query)) {
        write_slice(query, first, count);
    }
}

/* The slices behind each other, between head and tail. */
static void join(struct pel_surface_query *query)
{
    const struct pel_surface_form *form = &query->form;
    size_t parts = (query->count + PEL_SURFACE_SLICE - 1) / PEL_SURFACE_SLICE;
    size_t size = 0;
    char head[PEL_SURFACE_HEAD];
    for (size_t i = 0; i < parts; i++) {
        size += query->parts[i].size;
    }
    const char *tail = form->tail ? form->tail(query->count) : "";
    size_t before = form->head(form, query->time_s, query->count, size, head);
    query->text = pel_sure_malloc(before + size + strlen(tail) + 1);
    memcpy(query->text, head, before);
    char *to = query->text + before;
    for (size_t i = 0; i < parts; i++) {
        memcpy(to, query->parts[i].text, query->parts[i].size);
        to += query->parts[i].size;
        free(query->parts[i].text);
        query->parts[i].text = NULL;
    }
    memcpy(to, tail, strlen(tail) + 1);
    query->size = before + size + strlen(tail);
}

static void post(struct pel_surface_pool *self, struct pel_surface_query *query)
{
    if (query->form.slice) {
        join(query);
    }
    pel_mailbox_post(self->box, &query->mail);
}

/* It is computed; has the lock, not while it is posted. */
static void give(struct pel_surface_pool *self, struct pel_surface_query *query)
{
    bool slow = is_slow(query);
    if (slow) {
        pel_queue_push(&self->texts, &query->mail);
    }
    pthread_mutex_unlock(&self->lock);
    if (slow) {
        pthread_cond_signal(&self->answered);
    } else {
        post(self, query);
    }
    pthread_mutex_lock(&self->lock);
}

static void *run(void *argument)
{
    struct worker worker = { .all = argument };
    struct pel_surface_pool *self = argument;
    pel_urgent_begin(&worker.urgent, PEL_URGENT_ANSWERS);
    pthread_mutex_lock(&self->lock);
    while (!self->stop) {
        size_t first, count;
        struct pel_surface_query *query = take(self, &first, &count);
        if (!query) {
            idle(&worker);
            continue;
        }
        pthread_mutex_unlock(&self->lock);
        answer(query, first, count);
        pel_urgent_account(&worker.urgent);
        pthread_mutex_lock(&self->lock);
        query->answered += count;
        if (query->answered == query->count) {
            give(self, query);
        }
    }
    self->ended++;
    pthread_cond_signal(&self->over);
    pthread_mutex_unlock(&self->lock);
    return NULL;
}

/* Writes what is slow, a slice of each in turn. */
static void *write_texts(void *argument)
{
    struct pel_surface_pool *self = argument;
    (void)setpriority(PRIO_PROCESS, (id_t)gettid(), TEXT_NICE);
    pthread_mutex_lock(&self->lock);
    while (!self->stop) {
        struct pel_surface_query *query =
            (struct pel_surface_query *)pel_queue_pop(&self->texts);
        if (!query) {
            pthread_cond_wait(&self->answered, &self->lock);
            continue;
        }
        size_t first = query->written, left = query->count - first;
        size_t count = left < PEL_SURFACE_SLICE ? left : PEL_SURFACE_SLICE;
        pthread_mutex_unlock(&self->lock);
        write_slice(query, first, count);
        query->written += count;
        if (query->written == query->count) {
            post(self, query);
            query = NULL;
        }
        pthread_mutex_lock(&self->lock);
        if (query) {
            pel_queue_push(&self->texts, &query->mail);
        }
    }
    self->ended++;
    pthread_cond_signal(&self->over);
    pthread_mutex_unlock(&self->lock);
    return NULL;
}

enum pel_err pel_surface_pool_create(int cores, struct pel_mailbox *box,
                                     struct pel_surface_pool **out)
{
    struct pel_surface_pool *self = calloc(1, sizeof *self);
    if (!self) {
        return PEL_ERR_NO_MEMORY;
    }
    int threads = cores < PEL_SURFACE_POOL_MAX ? cores : PEL_SURFACE_POOL_MAX;
    self->box = box;
    pel_lock_init(&self->lock);
    pel_cond_init(&self->asked);
    pel_cond_init(&self->over);
    pel_cond_init(&self->answered);
    for (int i = 0; i < threads || i < 1; i++) {
        if (pthread_create(&self->threads[i], NULL, run, self) != 0) {
            break;
        }
        pthread_setname_np(self->threads[i], "surface");
        self->count = i + 1;
    }
    if (self->count == 0 ||
        pthread_create(&self->threads[self->count], NULL, write_texts, self)) {
        (void)pel_surface_pool_stop(self);
        pel_surface_pool_destroy(self);
        return PEL_ERR_IO;
    }
    pthread_setname_np(self->threads[self->count++], "surface text");
    *out = self;
    return PEL_OK;
}

void pel_surface_pool_push(struct pel_surface_pool *self,
                           struct pel_surface_query *query)
{
    query->mail.kind = PEL_MAIL_SURFACE;
    query->begun = query->answered = query->written = 0;
    pel_beat();
    pthread_mutex_lock(&self->lock);
    pel_queue_push(&self->queue, &query->mail);
    atomic_store(&self->hurry, true);
    bool slices = query->count > PEL_SURFACE_SLICE;
    pthread_mutex_unlock(&self->lock);
    if (slices) {
        pthread_cond_broadcast(&self->asked);
    } else {
        pthread_cond_signal(&self->asked);
    }
}

bool pel_surface_pool_stop(struct pel_surface_pool *self)
{
    pthread_mutex_lock(&self->lock);
    self->stop = true;
    atomic_store(&self->hurry, true);
    pthread_cond_broadcast(&self->asked);
    pthread_cond_signal(&self->answered);
    bool ended = pel_cond_wait_ended(&self->over, &self->lock, &self->ended,
                                     self->count, STOP_NS);
    pthread_mutex_unlock(&self->lock);
    for (int i = 0; i < self->count; i++) {
        if (ended) {
            pthread_join(self->threads[i], NULL);
        } else {
            pthread_detach(self->threads[i]);
        }
    }
    return ended;
}

void pel_surface_pool_destroy(struct pel_surface_pool *self)
{
    if (self) {
        for (int i = 0; i < PEL_MOST_PREPARED; i++) {
            pel_snapshot_unref(self->prefetched[i].snapshot);
        }
        pthread_cond_destroy(&self->asked);
        pthread_cond_destroy(&self->answered);
        pthread_cond_destroy(&self->over);
        pthread_mutex_destroy(&self->lock);
        free(self);
    }
}
