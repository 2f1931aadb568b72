/* The threads that answer surface queries, in real time where that is
 * permitted (base/urgent.h). A large query is cut up among them. */
#pragma once

#include "frames/job.h"
#include "frames/mailbox.h"

struct pel_answerers;

/* As many threads as `cores`, at most PEL_MOST_ANSWERERS. Answered queries are
 * posted to `box`, in the order in which they are done. */
#define PEL_MOST_ANSWERERS 4
PEL_CHECK enum pel_err pel_answerers_create(int cores, struct pel_mailbox *box,
                                            struct pel_answerers **out);

/* Any thread; queries are begun in this order. */
void pel_answerers_push(struct pel_answerers *self,
                        struct pel_surface_query *query);

/* Computes what a query about time_s will wait for from begin_ns on, while
 * nobody asks; of more than PEL_MOST_PREPARED such the oldest is left. */
#define PEL_MOST_PREPARED 3
void pel_answerers_prepare(struct pel_answerers *self,
                           const struct pel_snapshot *snapshot, double time_s,
                           bool moving, int64_t begin_ns);

/* Drops what waits, ends the work at hand, joins; false: not within 1 s, and
 * the threads are left alone. */
bool pel_answerers_stop(struct pel_answerers *self);
void pel_answerers_destroy(struct pel_answerers *self); /* after stop; NULL */
