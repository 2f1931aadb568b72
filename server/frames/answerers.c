#include "frames/answerers.h"

#include <pthread.h>
#include <stdlib.h>

#include "base/clock.h"
#include "base/urgent.h"

/* Points of a slice: a tenth of a millisecond of work. */
#define SLICE 128
#define STOP_NS 1000000000LL

struct pel_answerers {
    pthread_mutex_t lock; /* protects all below and the queries' counts */
    pthread_cond_t asked, over;
    struct pel_queue queue;
    bool stop;
    int count, ended;
    pthread_t threads[PEL_MOST_ANSWERERS];
    struct pel_mailbox *box;
};

/* The next slice of the first query; has the lock. A query leaves the queue
 * with its last slice. */
static struct pel_surface_query *take(struct pel_answerers *self, size_t *first,
                                      size_t *count)
{
    struct pel_surface_query *query =
        (struct pel_surface_query *)self->queue.first;
    if (query) {
        size_t left = query->count - query->begun;
        *first = query->begun;
        *count = left < SLICE ? left : SLICE;
        query->begun += *count;
        if (query->begun == query->count) {
            pel_queue_pop(&self->queue);
        }
    }
    return query;
}

static void *run(void *argument)
{
    struct pel_answerers *self = argument;
    struct pel_urgent urgent;
    pel_urgent_begin(&urgent, PEL_URGENT_ANSWERS);
    pthread_mutex_lock(&self->lock);
    while (!self->stop) {
        size_t first, count;
        struct pel_surface_query *query = take(self, &first, &count);
        if (!query) {
            pthread_cond_wait(&self->asked, &self->lock);
            continue;
        }
        pthread_mutex_unlock(&self->lock);
        pel_snapshot_surface(query->snapshot, query->points + first, count,
                             query->time_s, query->moving,
                             query->samples + first);
        pel_urgent_account(&urgent);
        pthread_mutex_lock(&self->lock);
        query->answered += count;
        if (query->answered == query->count) {
            pel_mailbox_post(self->box, &query->mail);
        }
    }
    self->ended++;
    pthread_cond_signal(&self->over);
    pthread_mutex_unlock(&self->lock);
    return NULL;
}

enum pel_err pel_answerers_create(int cores, struct pel_mailbox *box,
                                  struct pel_answerers **out)
{
    struct pel_answerers *self = calloc(1, sizeof *self);
    if (!self) {
        return PEL_ERR_NO_MEMORY;
    }
    int threads = cores < PEL_MOST_ANSWERERS ? cores : PEL_MOST_ANSWERERS;
    self->box = box;
    pel_lock_init(&self->lock);
    pel_cond_init(&self->asked);
    pel_cond_init(&self->over);
    for (int i = 0; i < threads || i < 1; i++) {
        if (pthread_create(&self->threads[i], NULL, run, self) != 0) {
            break;
        }
        pthread_setname_np(self->threads[i], "surface");
        self->count = i + 1;
    }
    if (self->count == 0) {
        pel_answerers_destroy(self);
        return PEL_ERR_IO;
    }
    *out = self;
    return PEL_OK;
}

void pel_answerers_push(struct pel_answerers *self,
                        struct pel_surface_query *query)
{
    query->mail.kind = PEL_MAIL_SURFACE;
    query->begun = query->answered = 0;
    pthread_mutex_lock(&self->lock);
    pel_queue_push(&self->queue, &query->mail);
    if (query->count > SLICE) {
        pthread_cond_broadcast(&self->asked);
    } else {
        pthread_cond_signal(&self->asked);
    }
    pthread_mutex_unlock(&self->lock);
}

bool pel_answerers_stop(struct pel_answerers *self)
{
    int64_t end = pel_now_ns() + STOP_NS, left = STOP_NS;
    pthread_mutex_lock(&self->lock);
    self->stop = true;
    pthread_cond_broadcast(&self->asked);
    while (self->ended < self->count && left > 0) {
        pel_cond_wait_ns(&self->over, &self->lock, left);
        left = end - pel_now_ns();
    }
    bool ended = self->ended == self->count;
    pthread_mutex_unlock(&self->lock);
    for (int i = 0; ended && i < self->count; i++) {
        pthread_join(self->threads[i], NULL);
    }
    return ended;
}

void pel_answerers_destroy(struct pel_answerers *self)
{
    if (self) {
        pthread_cond_destroy(&self->asked);
        pthread_cond_destroy(&self->over);
        pthread_mutex_destroy(&self->lock);
        free(self);
    }
}
