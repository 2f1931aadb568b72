/* The encoder threads: pictures to bytes. Live pictures go first; slow work
 * (PNG, EXR, large pictures, numbers of light) leaves one thread to them, and
 * live pictures of low ranks have threads of their own, of lower priority. */
#pragma once

#include "frames/job.h"
#include "frames/mailbox.h"

struct pel_encoder_pool;

/* `released` is called (any encoder thread) after the picture of a draw was
 * given back to the renderer. */
PEL_CHECK enum pel_err pel_encoder_pool_create(
    int threads, struct pel_mailbox *box,
    void (*released)(void *user, const struct pel_job_draw *part), void *user,
    struct pel_encoder_pool **out);

/* Drops what waits, ends the work at hand, joins; false: not within 1 s, and
 * the threads are left alone. */
bool pel_encoder_pool_stop(struct pel_encoder_pool *pool);
void pel_encoder_pool_destroy(
    struct pel_encoder_pool *pool); /* after stop; NULL allowed */

/* Ends a stream's encoder off the control thread; takes its reference. low: as
 * its last pictures. */
void pel_encoder_pool_push_track(struct pel_encoder_pool *pool,
                                 struct pel_track *track, bool low);
/* What tells a long encoding to give up. */
const atomic_bool *pel_encoder_pool_cancel(const struct pel_encoder_pool *pool);

/* Any thread. Outputs whose draw failed come back with its error. */
void pel_encoder_pool_push_output(struct pel_encoder_pool *pool,
                                  struct pel_output *output);
void pel_encoder_pool_push_optics(struct pel_encoder_pool *pool,
                                  struct pel_optics_query *query);
