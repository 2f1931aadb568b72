/* The render thread: the only user of GL. Takes jobs in order, submits the
 * next before it collects the one at hand, and gives each picture to the
 * encoders as it comes. Where the device is lost it makes a renderer anew and
 * draws again what was not collected: pictures are functions of the state. */
#pragma once

#include "frames/encoder_pool.h"
#include "frames/job.h"

struct pel_renderloop;

/* Starts the thread; `device` is its number among its peers. */
PEL_CHECK enum pel_err
pel_renderloop_create(const struct pel_renderer_options *o, unsigned device,
                      struct pel_encoder_pool *pool, struct pel_mailbox *box,
                      struct pel_renderloop **out, struct pel_fault *fault);

/* Waits until its renderer stands or failed. From then on it passes on what it
 * cannot draw to its peers, `count` of them, which live as long. */
PEL_CHECK enum pel_err pel_renderloop_wait(struct pel_renderloop *loop,
                                           struct pel_renderloop *const *peers,
                                           size_t count,
                                           struct pel_fault *fault);

/* Any thread; another one after losses of the device. Lives as long as the
 * loop. */
const char *pel_renderloop_device(const struct pel_renderloop *loop);
bool pel_renderloop_is_software(const struct pel_renderloop *loop);

/* How often the device was lost so far, pictures drawn again for it, and the
 * longest time until a renderer stood again. Any thread. */
struct pel_loss_stats {
    uint64_t losses, again;
    double last_ms, worst_ms;
    bool fallen_back; /* to the software device */
};
void pel_renderloop_losses(struct pel_renderloop *loop,
                           struct pel_loss_stats *out);

/* Whether the last frame was shaded in compute; any thread. */
bool pel_renderloop_in_compute(struct pel_renderloop *loop);

/* Hands over what is to be drawn here of a job; when all of it is drawn, the
 * job is returned as PEL_MAIL_JOB_DRAWN. Control thread. */
void pel_renderloop_push(struct pel_renderloop *loop, struct pel_share *share);

/* The same for a large job whole; large jobs are drawn one after the other, in
 * bands, one band after each other share, and band after band while there is no
 * other. Draws that no client waits for any more are skipped. */
void pel_renderloop_push_large(struct pel_renderloop *loop,
                               struct pel_job *job);

/* Whether it has a device; pixels, and shares of jobs, that it has not drawn
 * yet. Any thread. */
bool pel_renderloop_stands(const struct pel_renderloop *loop);
uint64_t pel_renderloop_work(const struct pel_renderloop *loop);
unsigned pel_renderloop_shares(const struct pel_renderloop *loop);

/* About the pixels of a band, from the next one on. Any thread. */
void pel_renderloop_set_band(struct pel_renderloop *loop, uint64_t pixels);

/* The same for a query; it is returned as PEL_MAIL_OPTICS. Control thread. */
void pel_renderloop_push_optics(struct pel_renderloop *loop,
                                struct pel_optics_query *query);

/* A readback buffer is free again; any thread. */
void pel_renderloop_released(struct pel_renderloop *loop,
                             const struct pel_job_draw *part);

/* When the thread last made progress, or had nothing to do (CLOCK_MONOTONIC);
 * any thread. */
int64_t pel_renderloop_progress_ns(const struct pel_renderloop *loop);

/* It draws on the processor, and since then this process has been computing
 * besides what clients ask of the thread that made this, for two minutes and a
 * minute of a core at most: programs are compiled, or the machine is busy. Any
 * thread. */
bool pel_renderloop_computes(const struct pel_renderloop *loop);

/* Drops what waits and joins; false: not within 2 s, the thread is left. The
 * encoders must have stopped. */
bool pel_renderloop_stop(struct pel_renderloop *loop);
void pel_renderloop_destroy(struct pel_renderloop *loop); /* after stop */
