#include "render/worker_pool.h"

#include <pthread.h>
#include <stdbool.h>
#include <stdlib.h>

struct member {
    struct pel_worker_pool *pool;
    pthread_t thread;
    int number;
};

struct pel_worker_pool {
    pthread_mutex_t lock; /* protects all below */
    pthread_cond_t wake, done;
    void (*work)(void *user, int member, int i);
    void *user;
    int count, next, finished;
    bool stop;
    int members;
    struct member member[PEL_WORKER_POOL_MAX];
};

/* Takes pieces while there are any; with the lock held. */
static void take_part(struct pel_worker_pool *c, int member)
{
    while (c->next < c->count) {
        int i = c->next++;
        pthread_mutex_unlock(&c->lock);
        c->work(c->user, member, i);
        pthread_mutex_lock(&c->lock);
        if (++c->finished == c->count) {
            pthread_cond_signal(&c->done);
        }
    }
}

static void *run(void *argument)
{
    struct member *m = argument;
    struct pel_worker_pool *c = m->pool;
    pthread_mutex_lock(&c->lock);
    while (!c->stop) {
        take_part(c, m->number);
        pthread_cond_wait(&c->wake, &c->lock);
    }
    pthread_mutex_unlock(&c->lock);
    return NULL;
}

enum pel_err pel_worker_pool_create(int members, struct pel_worker_pool **out)
{
    struct pel_worker_pool *c = calloc(1, sizeof *c);
    if (!c) {
        return PEL_ERR_NO_MEMORY;
    }
    pthread_mutex_init(&c->lock, NULL);
    pthread_cond_init(&c->wake, NULL);
    pthread_cond_init(&c->done, NULL);
    c->members = 1;
    while (c->members < members && c->members < PEL_WORKER_POOL_MAX) {
        struct member *m = &c->member[c->members];
        *m = (struct member){ .pool = c, .number = c->members };
        if (pthread_create(&m->thread, NULL, run, m) != 0) {
            break;
        }
        pthread_setname_np(m->thread, "waves");
        c->members++;
    }
    *out = c;
    return PEL_OK;
}

void pel_worker_pool_destroy(struct pel_worker_pool *c)
{
    if (!c) {
        return;
    }
    pthread_mutex_lock(&c->lock);
    c->stop = true;
    pthread_cond_broadcast(&c->wake);
    pthread_mutex_unlock(&c->lock);
    for (int i = 1; i < c->members; i++) {
        pthread_join(c->member[i].thread, NULL);
    }
    pthread_cond_destroy(&c->done);
    pthread_cond_destroy(&c->wake);
    pthread_mutex_destroy(&c->lock);
    free(c);
}

void pel_worker_pool_run(struct pel_worker_pool *c, int count,
                         void (*work)(void *user, int member, int i),
                         void *user)
{
    pthread_mutex_lock(&c->lock);
    c->work = work;
    c->user = user;
    c->count = count;
    c->next = c->finished = 0;
    pthread_cond_broadcast(&c->wake);
    take_part(c, 0);
    while (c->finished < c->count) {
        pthread_cond_wait(&c->done, &c->lock);
    }
    pthread_mutex_unlock(&c->lock);
}

int pel_worker_pool_members(const struct pel_worker_pool *c)
{
    return c->members;
}
