/* The threads that answer surface queries, in real time where that is
 * permitted (base/urgent.h). A large query is split among them. They may use a
 * third of their cores for those who may steer, a fortieth for watchers, and
 * a burst of some milliseconds; what is asked beyond that, and by
 * PEL_RANK_NOBODY, is answered behind the threads that draw. */
#pragma once

#include "frames/job.h"
#include "frames/mailbox.h"

struct pel_surface_pool;

/* As many threads as `cores`, at most PEL_SURFACE_POOL_MAX. Answered queries
 * are posted to `box`, in the order in which they are done. */
#define PEL_SURFACE_POOL_MAX 4
PEL_CHECK enum pel_err pel_surface_pool_create(int cores,
                                               struct pel_mailbox *box,
                                               struct pel_surface_pool **out);

/* Points that a thread answers before it looks what else there is: a tenth of a
 * millisecond, or one where they are written as JSON. */
#define PEL_SURFACE_SLICE 128

/* Any thread. Queries are answered one after the other; every other slice is
 * of those who may steer, and of one that waits for its first, so that few
 * points do not wait for many. */
void pel_surface_pool_push(struct pel_surface_pool *self,
                           struct pel_surface_query *query);

/* From begin_ns on, idle threads compute what a query about time_s and
 * places within `of` needs; beyond PEL_MOST_PREPARED such requests the oldest
 * is dropped. */
#define PEL_MOST_PREPARED 3
void pel_surface_pool_prepare(struct pel_surface_pool *self,
                              const struct pel_snapshot *snapshot,
                              double time_s, bool moving,
                              const struct pel_box *of, int64_t begin_ns);

/* Processor time that slices took so far, before and behind the threads that
 * draw. Any thread. */
void pel_surface_pool_used(struct pel_surface_pool *self, int64_t *urgent_ns,
                           int64_t *behind_ns);

/* Drops what waits, ends the work at hand, joins; false: not within 1 s, and
 * the threads are left alone. */
bool pel_surface_pool_stop(struct pel_surface_pool *self);
void pel_surface_pool_destroy(
    struct pel_surface_pool *self); /* after stop; NULL */
