/* A thread for what takes longer than the control thread may: seas, files,
 * numbers of a spectrum. Tasks are done one after the other, in the order in
 * which they came; `done` is called on the control thread. All
 * functions are for the control thread. */
#pragma once

#include <stdbool.h>

#include "base/err.h"

struct pel_worker;

/* Lies in the caller's own struct, which stays until `done` has run. */
struct pel_task {
    void (*work)(struct pel_task *task); /* on the worker's thread */
    /* On the control thread, once for each task. dropped: the worker ends;
     * its work was done or never begun. */
    void (*done)(struct pel_task *task, bool dropped);
    struct pel_task *next; /* the worker's own */
};

/* The thread is started by the first task; `name` of at most 15 characters,
 * static. */
struct pel_worker *pel_worker_create(const char *name);

/* Before its first task: behind the threads of a smaller nice value. */
void pel_worker_set_nice(struct pel_worker *worker, int nice);

void pel_worker_push(struct pel_worker *worker, struct pel_task *task);

/* Tasks whose `done` has not been called yet. */
unsigned pel_worker_count(const struct pel_worker *worker);

/* Waits for the oldest task and calls its `done`; false: there is none. For
 * programs without a main loop, and tests. */
bool pel_worker_wait(struct pel_worker *worker);

/* Waits for the task at hand, drops the others. NULL allowed. */
void pel_worker_destroy(struct pel_worker *worker);
