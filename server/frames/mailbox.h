/* Queues of messages between threads. They have no limit of their own: the
 * number of messages is bounded where they are made. */
#pragma once

#include <glib.h>
#include <pthread.h>

#include "frames/job.h"

/* First in, first out; the caller holds the lock that protects it. */
struct pel_queue {
    struct pel_mail *first, *last;
};
void pel_queue_push(struct pel_queue *queue, struct pel_mail *mail);
struct pel_mail *pel_queue_pop(struct pel_queue *queue); /* NULL: empty */

/* From any thread to the control thread, which waits for nobody. */
struct pel_mailbox {
    _Atomic(struct pel_mail *) posted; /* newest first */
    struct pel_queue queue;            /* control thread: what was posted */
    GSource *source;
    void (*receive)(void *user, struct pel_mail *mail);
    void *user;
};
/* `receive` runs in `context` for every mail, in order of posting. */
void pel_mailbox_init(struct pel_mailbox *box, GMainContext *context,
                      void (*receive)(void *user, struct pel_mail *mail),
                      void *user);
void pel_mailbox_finish(struct pel_mailbox *box);
void pel_mailbox_post(struct pel_mailbox *box, struct pel_mail *mail);

/* A source that calls back once g_source_set_ready_time says so: an alarm
 * clock that is set again and again without allocating. Attached to context. */
GSource *pel_alarm_create(GMainContext *context, const char *name,
                          void (*ring)(void *user), void *user);

/* A condition that counts time by CLOCK_MONOTONIC; and a wait on it of at most
 * wait_ns, with the lock held. */
void pel_cond_init(pthread_cond_t *cond);
void pel_cond_wait_ns(pthread_cond_t *cond, pthread_mutex_t *lock,
                      int64_t wait_ns);
/* Whether all of `count` threads end within wait_ns: each adds to *ended and
 * signals. With the lock held. */
bool pel_cond_wait_ended(pthread_cond_t *cond, pthread_mutex_t *lock,
                         const int *ended, int count, int64_t wait_ns);
