#include "scene/worker.h"
#include "base/watch.h"

#include <glib.h>
#include <pthread.h>
#include <sys/resource.h>
#include <unistd.h>

/* First in, first out. */
struct queue {
    struct pel_task *first, *last;
};

struct pel_worker {
    const char *name;
    int nice;
    GThread *thread;      /* NULL: not started */
    pthread_mutex_t lock; /* protects what follows, to `stopping` */
    pthread_cond_t more;  /* a task, or stopping: for the worker */
    pthread_cond_t done;  /* a task has ended: for who waits for it */
    struct queue tasks, ended;
    bool stopping;
    GSource *source; /* is woken when a task has ended */
    unsigned count;
};

static void push(struct queue *queue, struct pel_task *task)
{
    task->next = NULL;
    if (queue->last) {
        queue->last->next = task;
    } else {
        queue->first = task;
    }
    queue->last = task;
}

static struct pel_task *pop(struct queue *queue)
{
    struct pel_task *task = queue->first;
    if (task) {
        queue->first = task->next;
        queue->last = queue->first ? queue->last : NULL;
    }
    return task;
}

static gpointer run(gpointer user)
{
    struct pel_worker *worker = user;
    if (worker->nice > 0) {
        (void)setpriority(PRIO_PROCESS, (id_t)gettid(), worker->nice);
    }
    pthread_mutex_lock(&worker->lock);
    while (!worker->stopping) {
        struct pel_task *task = pop(&worker->tasks);
        if (!task) {
            pthread_cond_wait(&worker->more, &worker->lock);
            continue;
        }
        pthread_mutex_unlock(&worker->lock);
        task->work(task);
        pthread_mutex_lock(&worker->lock);
        push(&worker->ended, task);
        pthread_cond_signal(&worker->done);
        g_source_set_ready_time(worker->source, 0);
    }
    pthread_mutex_unlock(&worker->lock);
    return NULL;
}

static void finish(struct pel_worker *worker, struct pel_task *task,
                   bool dropped)
{
    worker->count--;
    task->done(task, dropped);
}

struct source {
    GSource source;
    struct pel_worker *worker;
};

static gboolean dispatch(GSource *source, GSourceFunc callback, gpointer data)
{
    struct pel_worker *worker = ((struct source *)source)->worker;
    PEL_WATCH(worker->name);
    (void)callback;
    (void)data;
    g_source_set_ready_time(source, -1);
    pthread_mutex_lock(&worker->lock);
    struct pel_task *task = pop(&worker->ended);
    bool more = worker->ended.first != NULL;
    pthread_mutex_unlock(&worker->lock);
    if (more) {
        g_source_set_ready_time(source, 0); /* one a turn */
    }
    if (task) {
        finish(worker, task, false);
    }
    return G_SOURCE_CONTINUE;
}

struct pel_worker *pel_worker_create(const char *name)
{
    static GSourceFuncs functions = { .dispatch = dispatch };
    struct pel_worker *worker = g_new0(struct pel_worker, 1);
    worker->name = name;
    pthread_mutex_init(&worker->lock, NULL);
    pthread_cond_init(&worker->more, NULL);
    pthread_cond_init(&worker->done, NULL);
    worker->source = g_source_new(&functions, sizeof(struct source));
    ((struct source *)worker->source)->worker = worker;
    g_source_set_name(worker->source, name);
    g_source_attach(worker->source, NULL);
    return worker;
}

void pel_worker_set_nice(struct pel_worker *worker, int nice)
{
    worker->nice = nice;
}

void pel_worker_push(struct pel_worker *worker, struct pel_task *task)
{
    if (!worker->thread) {
        worker->thread = g_thread_new(worker->name, run, worker);
    }
    worker->count++;
    pthread_mutex_lock(&worker->lock);
    push(&worker->tasks, task);
    pthread_cond_signal(&worker->more);
    pthread_mutex_unlock(&worker->lock);
}

unsigned pel_worker_count(const struct pel_worker *worker)
{
    return worker->count;
}

bool pel_worker_wait(struct pel_worker *worker)
{
    if (worker->count == 0) {
        return false;
    }
    pthread_mutex_lock(&worker->lock);
    while (!worker->ended.first) {
        pthread_cond_wait(&worker->done, &worker->lock);
    }
    struct pel_task *task = pop(&worker->ended);
    pthread_mutex_unlock(&worker->lock);
    finish(worker, task, false);
    return true;
}

void pel_worker_destroy(struct pel_worker *worker)
{
    struct pel_task *task;
    if (!worker) {
        return;
    }
    if (worker->thread) {
        pthread_mutex_lock(&worker->lock);
        worker->stopping = true;
        pthread_cond_signal(&worker->more);
        pthread_mutex_unlock(&worker->lock);
        g_thread_join(worker->thread);
    }
    g_source_destroy(worker->source);
    while ((task = pop(&worker->ended))) {
        finish(worker, task, true);
    }
    while ((task = pop(&worker->tasks))) {
        finish(worker, task, true);
    }
    g_source_unref(worker->source);
    pthread_cond_destroy(&worker->done);
    pthread_cond_destroy(&worker->more);
    pthread_mutex_destroy(&worker->lock);
    g_free(worker);
}
