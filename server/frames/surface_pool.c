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
#define BEHIND_NICE 10 /* those that draw have 5 */
/* Of each thread's core, before those that draw. */
#define STEER_SHARE 0.3
#define STEER_BURST_NS 60000000
#define WATCH_SHARE 0.025
#define WATCH_BURST_NS 5000000
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

/* Queries that take turns. */
struct lane {
    struct pel_queue queue;
    bool turn; /* the next slice is one of who is served first */
};

enum { URGENT, BEHIND, LANES };

struct pel_surface_pool {
    pthread_mutex_t lock; /* protects all below and the queries' counts */
    pthread_cond_t asked, over, behind;
    struct lane lanes[LANES];
    struct pel_queue texts; /* answered, to be written behind */
    bool text_turn;
    struct pel_allowance steer, watch; /* to be urgent */
    int64_t used_ns[LANES];
    struct prefetched prefetched[PEL_MOST_PREPARED]; /* newest first */
    atomic_bool hurry; /* somebody asks, or all ends */
    bool stop;
    int count, ended;
    pthread_t threads[2 * PEL_SURFACE_POOL_MAX];
    struct pel_mailbox *box;
};

static int order_of(const struct pel_mail *mail)
{
    const struct pel_surface_query *query =
        (const struct pel_surface_query *)mail;
    return (query->rank < PEL_RANK_WATCH ? 0 : 2) + (query->begun > 0);
}

/* Takes the first in the queue off it, or in every other turn the first of
 * those who may steer, and of these one that has not begun; NULL: nobody
 * asks. */
static struct pel_surface_query *next_query(struct lane *lane)
{
    struct pel_queue *queue = &lane->queue;
    struct pel_mail *before = NULL;
    lane->turn = !lane->turn;
    if (!lane->turn || !queue->first) {
        return (struct pel_surface_query *)pel_queue_pop(queue);
    }
    struct pel_mail *best = queue->first;
    for (struct pel_mail *m = queue->first; m->next; m = m->next) {
        if (order_of(m->next) < order_of(best)) {
            before = m;
            best = m->next;
        }
    }
    if (!before) {
        return (struct pel_surface_query *)pel_queue_pop(queue);
    }
    before->next = best->next;
    queue->last = best->next ? queue->last : before;
    best->next = NULL;
    return (struct pel_surface_query *)best;
}

/* It is gone on with before others: the moments of all do not fit into what is
 * kept of the sea (ocean/fields.h), and each slice would compute its own
 * again. */
static void put_back(struct pel_queue *queue, struct pel_surface_query *query)
{
    query->mail.next = queue->first;
    queue->first = &query->mail;
    queue->last = queue->last ? queue->last : &query->mail;
}

/* Whether who asks may be answered before those that draw; has the lock. */
static bool may_be_urgent(struct pel_surface_pool *self, enum pel_rank rank)
{
    struct pel_allowance *of =
        rank < PEL_RANK_WATCH ? &self->steer : &self->watch;
    return rank < PEL_RANK_NOBODY && pel_allowance_has(of, pel_now_ns());
}

static void spend(struct pel_surface_pool *self, int lane, enum pel_rank rank,
                  int64_t used_ns)
{
    self->used_ns[lane] += used_ns;
    if (lane == URGENT) {
        pel_allowance_spend(rank < PEL_RANK_WATCH ? &self->steer : &self->watch,
                            used_ns);
    }
}

/* The next slice; has the lock. A query leaves the queue with its last. What
 * may not be urgent goes behind. */
static struct pel_surface_query *take(struct pel_surface_pool *self, int lane,
                                      size_t *first, size_t *count)
{
    struct pel_surface_query *query = next_query(&self->lanes[lane]);
    while (query && lane == URGENT && !may_be_urgent(self, query->rank)) {
        pel_queue_push(&self->lanes[BEHIND].queue, &query->mail);
        pthread_cond_signal(&self->behind);
        query = next_query(&self->lanes[lane]);
    }
    if (query) {
        size_t left = query->count - query->begun;
        *first = query->begun;
        *count = left < PEL_SURFACE_SLICE ? left : PEL_SURFACE_SLICE;
        query->begun += *count;
        if (query->begun < query->count) {
            put_back(&self->lanes[lane].queue, query);
        }
    }
    atomic_store(&self->hurry, self->lanes[URGENT].queue.first != NULL);
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
        pthread_cond_signal(&self->behind);
    } else {
        post(self, query);
    }
    pthread_mutex_lock(&self->lock);
}

/* One slice; has the lock, not while it computes. False: nobody asks. */
static bool answer_one(struct pel_surface_pool *self, int lane,
                       struct pel_urgent *urgent)
{
    size_t first, count;
    struct pel_surface_query *query = take(self, lane, &first, &count);
    if (!query) {
        return false;
    }
    enum pel_rank rank = query->rank;
    pthread_mutex_unlock(&self->lock);
    int64_t before_ns = pel_thread_cpu_ns();
    answer(query, first, count);
    int64_t used_ns = pel_thread_cpu_ns() - before_ns;
    if (urgent) {
        pel_urgent_account(urgent);
    }
    pthread_mutex_lock(&self->lock);
    spend(self, lane, rank, used_ns);
    query->answered += count;
    if (query->answered == query->count) {
        give(self, query);
    }
    return true;
}

/* Has the lock, not while it signals. */
static void *end(struct pel_surface_pool *self)
{
    self->ended++;
    pthread_cond_signal(&self->over);
    pthread_mutex_unlock(&self->lock);
    return NULL;
}

static void *run(void *argument)
{
    struct worker worker = { .all = argument };
    struct pel_surface_pool *self = argument;
    pel_urgent_begin(&worker.urgent, PEL_URGENT_ANSWERS);
    pthread_mutex_lock(&self->lock);
    while (!self->stop) {
        if (!answer_one(self, URGENT, &worker.urgent)) {
            idle(&worker);
        }
    }
    return end(self);
}

/* Writes a slice of what is slow to write, of each in turn; has the lock, not
 * while it writes. False: there is none. */
static bool write_one(struct pel_surface_pool *self)
{
    struct pel_surface_query *query =
        (struct pel_surface_query *)pel_queue_pop(&self->texts);
    if (!query) {
        return false;
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
    return true;
}

/* Answers what is not urgent and writes what is slow, in turns. */
static void *run_behind(void *argument)
{
    struct pel_surface_pool *self = argument;
    (void)setpriority(PRIO_PROCESS, (id_t)gettid(), BEHIND_NICE);
    pthread_mutex_lock(&self->lock);
    while (!self->stop) {
        self->text_turn = !self->text_turn;
        bool did = self->text_turn && write_one(self);
        did = did || answer_one(self, BEHIND, NULL) || write_one(self);
        if (!did) {
            pthread_cond_wait(&self->behind, &self->lock);
        }
    }
    return end(self);
}

static bool start(struct pel_surface_pool *self, void *(*run_it)(void *),
                  const char *name)
{
    pthread_t *thread = &self->threads[self->count];
    if (pthread_create(thread, NULL, run_it, self) != 0) {
        return false;
    }
    pthread_setname_np(*thread, name);
    self->count++;
    return true;
}

enum pel_err pel_surface_pool_create(int cores, struct pel_mailbox *box,
                                     struct pel_surface_pool **out)
{
    struct pel_surface_pool *self = calloc(1, sizeof *self);
    if (!self) {
        return PEL_ERR_NO_MEMORY;
    }
    int threads = cores < PEL_SURFACE_POOL_MAX ? cores : PEL_SURFACE_POOL_MAX;
    threads = threads < 1 ? 1 : threads;
    self->box = box;
    self->steer = (struct pel_allowance){ .share = STEER_SHARE * threads,
                                          .burst_ns = STEER_BURST_NS };
    self->watch = (struct pel_allowance){ .share = WATCH_SHARE * threads,
                                          .burst_ns = WATCH_BURST_NS };
    pel_lock_init(&self->lock);
    pel_cond_init(&self->asked);
    pel_cond_init(&self->over);
    pel_cond_init(&self->behind);
    bool there = start(self, run, "surface") &&
                 start(self, run_behind, "surface behind");
    for (int i = 1; there && i < threads && start(self, run, "surface"); i++) {
    }
    if (there && threads > 2) {
        (void)start(self, run_behind, "surface behind");
    }
    if (!there) {
        (void)pel_surface_pool_stop(self);
        pel_surface_pool_destroy(self);
        return PEL_ERR_IO;
    }
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
    pel_queue_push(&self->lanes[URGENT].queue, &query->mail);
    atomic_store(&self->hurry, true);
    bool slices = query->count > PEL_SURFACE_SLICE;
    pthread_mutex_unlock(&self->lock);
    if (slices) {
        pthread_cond_broadcast(&self->asked);
    } else {
        pthread_cond_signal(&self->asked);
    }
}

void pel_surface_pool_used(struct pel_surface_pool *self, int64_t *urgent_ns,
                           int64_t *behind_ns)
{
    pthread_mutex_lock(&self->lock);
    *urgent_ns = self->used_ns[URGENT];
    *behind_ns = self->used_ns[BEHIND];
    pthread_mutex_unlock(&self->lock);
}

bool pel_surface_pool_stop(struct pel_surface_pool *self)
{
    pthread_mutex_lock(&self->lock);
    self->stop = true;
    atomic_store(&self->hurry, true);
    pthread_cond_broadcast(&self->asked);
    pthread_cond_broadcast(&self->behind);
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
        pthread_cond_destroy(&self->behind);
        pthread_cond_destroy(&self->over);
        pthread_mutex_destroy(&self->lock);
        free(self);
    }
}
