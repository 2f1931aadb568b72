/* Threads that share out one piece of work at a time with the thread that asks
 * for it. What they compute must not depend on who computes it. */
#pragma once

#include <stddef.h>

#include "base/err.h"

#define PEL_CREW_MOST 8 /* members, the asking thread counted */

struct pel_crew;

/* `members` threads, 1..PEL_CREW_MOST, of which the asking one is the first;
 * fewer when the system gives no more. NO_MEMORY. */
PEL_CHECK enum pel_err pel_crew_create(int members, struct pel_crew **out);
void pel_crew_destroy(struct pel_crew *crew); /* NULL allowed */

/* Calls work(user, member, i) once for each i < count, on any member
 * (0..members − 1), and returns when all are done. One thread at a time. */
void pel_crew_run(struct pel_crew *crew, int count,
                  void (*work)(void *user, int member, int i), void *user);

int pel_crew_members(const struct pel_crew *crew);
