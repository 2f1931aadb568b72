#include "frames/mailbox.h"

#include "base/clock.h"
#include "base/watch.h"

#include <stdatomic.h>
#include <time.h>

void pel_queue_push(struct pel_queue *queue, struct pel_mail *mail)
{
    mail->next = NULL;
    if (queue->last) {
        queue->last->next = mail;
    } else {
        queue->first = mail;
    }
    queue->last = mail;
}

struct pel_mail *pel_queue_pop(struct pel_queue *queue)
{
    struct pel_mail *mail = queue->first;
    if (mail) {
        queue->first = mail->next;
        queue->last = queue->first ? queue->last : NULL;
        mail->next = NULL;
    }
    return mail;
}

void pel_cond_init(pthread_cond_t *cond)
{
    pthread_condattr_t attributes;
    pthread_condattr_init(&attributes);
    pthread_condattr_setclock(&attributes, CLOCK_MONOTONIC);
    pthread_cond_init(cond, &attributes);
    pthread_condattr_destroy(&attributes);
}

void pel_cond_wait_ns(pthread_cond_t *cond, pthread_mutex_t *lock,
                      int64_t wait_ns)
{
    struct timespec end;
    clock_gettime(CLOCK_MONOTONIC, &end);
    int64_t ns = end.tv_nsec + wait_ns;
    end.tv_sec += ns / 1000000000;
    end.tv_nsec = ns % 1000000000;
    pthread_cond_timedwait(cond, lock, &end);
}

/* --- alarm --------------------------------------------------------------- */

struct alarm {
    GSource source;
    const char *name;
    void (*ring)(void *user);
    void *user;
};

static gboolean alarm_dispatch(GSource *source, GSourceFunc callback,
                               gpointer data)
{
    struct alarm *alarm = (struct alarm *)source;
    PEL_WATCH(alarm->name);
    (void)callback;
    (void)data;
    g_source_set_ready_time(source, -1);
    alarm->ring(alarm->user);
    return G_SOURCE_CONTINUE;
}

GSource *pel_alarm_create(GMainContext *context, const char *name,
                          void (*ring)(void *user), void *user)
{
    static GSourceFuncs functions = { .dispatch = alarm_dispatch };
    GSource *source = g_source_new(&functions, sizeof(struct alarm));
    struct alarm *alarm = (struct alarm *)source;
    alarm->name = name;
    alarm->ring = ring;
    alarm->user = user;
    g_source_set_name(source, name);
    g_source_attach(source, context);
    return source;
}

/* --- mailbox ------------------------------------------------------------- */

/* Everything that was posted, the oldest first, behind what waits. */
static void fetch(struct pel_mailbox *box)
{
    struct pel_mail *newest = atomic_exchange(&box->posted, NULL);
    struct pel_mail *oldest = NULL;
    while (newest) {
        struct pel_mail *before = newest->next;
        newest->next = oldest;
        oldest = newest;
        newest = before;
    }
    while (oldest) {
        struct pel_mail *after = oldest->next;
        pel_queue_push(&box->queue, oldest);
        oldest = after;
    }
}

static void receive_all(void *user)
{
    struct pel_mailbox *box = user;
    struct pel_mail *mail;
    do {
        fetch(box);
        mail = pel_queue_pop(&box->queue);
        if (mail) {
            box->receive(box->user, mail);
        }
    } while (mail);
}

void pel_mailbox_init(struct pel_mailbox *box, GMainContext *context,
                      void (*receive)(void *user, struct pel_mail *mail),
                      void *user)
{
    *box = (struct pel_mailbox){ .receive = receive, .user = user };
    box->source = pel_alarm_create(context, "frames mailbox", receive_all, box);
}

void pel_mailbox_finish(struct pel_mailbox *box)
{
    if (box->source) {
        g_source_destroy(box->source);
        g_source_unref(box->source);
        box->source = NULL;
    }
}

void pel_mailbox_post(struct pel_mailbox *box, struct pel_mail *mail)
{
    struct pel_mail *before = atomic_load(&box->posted);
    do {
        mail->next = before;
    } while (!atomic_compare_exchange_weak(&box->posted, &before, mail));
    g_source_set_ready_time(box->source, 0);
}

bool pel_cond_wait_ended(pthread_cond_t *cond, pthread_mutex_t *lock,
                         const int *ended, int count, int64_t wait_ns)
{
    int64_t end = pel_now_ns() + wait_ns, left = wait_ns;
    while (*ended < count && left > 0) {
        pel_cond_wait_ns(cond, lock, left);
        left = end - pel_now_ns();
    }
    return *ended == count;
}
