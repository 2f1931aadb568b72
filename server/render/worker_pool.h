/* Threads that share one piece of work at a time with the calling thread. The
 * result must not depend on which thread computes which part. */
#pragma once

#include <stddef.h>

#include "base/err.h"

#define PEL_WORKER_POOL_MAX 8 /* members, the asking thread counted */

struct pel_worker_pool;

/* `members` threads, 1..PEL_WORKER_POOL_MAX, of which the asking one is the
 * first; fewer when the system gives no more. NO_MEMORY. */
PEL_CHECK enum pel_err pel_worker_pool_create(int members,
                                              struct pel_worker_pool **out);
void pel_worker_pool_destroy(struct pel_worker_pool *pool); /* NULL allowed */

/* Calls work(user, member, i) once for each i < count, on any member
 * (0..members − 1), and returns when all are done. One thread at a time. */
void pel_worker_pool_run(struct pel_worker_pool *pool, int count,
                         void (*work)(void *user, int member, int i),
                         void *user);

int pel_worker_pool_members(const struct pel_worker_pool *pool);
