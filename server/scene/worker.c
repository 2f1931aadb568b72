#include "scene/worker.h"
#include "base/watch.h"

#include <glib.h>

struct pel_worker {
    const char *name;
    GThread *thread;            /* NULL: not started */
    GAsyncQueue *tasks, *ended; /* struct pel_task */
    GSource *source;            /* is woken when a task has ended */
    unsigned count;
    struct pel_task stop;
};

static gpointer run(gpointer user)
{
    struct pel_worker *worker = user;
    for (;;) {
        struct pel_task *task = g_async_queue_pop(worker->tasks);
        if (task == &worker->stop) {
            return NULL;
        }
        task->work(task);
        g_async_queue_push(worker->ended, task);
        g_source_set_ready_time(worker->source, 0);
    }
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
    struct pel_task *task = g_async_queue_try_pop(worker->ended);
    if (task) {
        if (g_async_queue_length(worker->ended) > 0) {
            g_source_set_ready_time(source, 0); /* one a turn */
        }
        finish(worker, task, false);
    }
    return G_SOURCE_CONTINUE;
}

struct pel_worker *pel_worker_create(const char *name)
{
    static GSourceFuncs functions = { .dispatch = dispatch };
    struct pel_worker *worker = g_new0(struct pel_worker, 1);
    worker->name = name;
    worker->tasks = g_async_queue_new();
    worker->ended = g_async_queue_new();
    worker->source = g_source_new(&functions, sizeof(struct source));
    ((struct source *)worker->source)->worker = worker;
    g_source_set_name(worker->source, name);
    g_source_attach(worker->source, NULL);
    return worker;
}

void pel_worker_push(struct pel_worker *worker, struct pel_task *task)
{
    if (!worker->thread) {
        worker->thread = g_thread_new(worker->name, run, worker);
    }
    worker->count++;
    g_async_queue_push(worker->tasks, task);
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
    finish(worker, g_async_queue_pop(worker->ended), false);
    return true;
}

void pel_worker_destroy(struct pel_worker *worker)
{
    struct pel_task *task;
    if (!worker) {
        return;
    }
    if (worker->thread) {
        g_async_queue_push_front(worker->tasks, &worker->stop);
        g_thread_join(worker->thread);
    }
    g_source_destroy(worker->source);
    while ((task = g_async_queue_try_pop(worker->ended))) {
        finish(worker, task, true);
    }
    while ((task = g_async_queue_try_pop(worker->tasks))) {
        finish(worker, task, true);
    }
    g_source_unref(worker->source);
    g_async_queue_unref(worker->tasks);
    g_async_queue_unref(worker->ended);
    g_free(worker);
}
