/* The inside of a render loop, for its own files: renderloop.c, loss.c. */
#pragma once

#include <pthread.h>

#include "frames/renderloop.h"

/* Losses that are remembered; draws that are under way at most. */
#define PEL_MANY_LOSSES 3
#define PEL_MOST_LOST (PEL_MAX_VIEWS * 4)

struct pel_renderloop {
    pthread_t thread;
    /* protects queue, given, ready, ended, err, fault, in_compute, losses */
    pthread_mutex_t lock;
    pthread_cond_t wake; /* CLOCK_MONOTONIC */
    struct pel_queue queue;
    struct pel_job *given; /* a large one, not begun */
    bool ready, joined;
    int ended; /* 1: the thread has */
    enum pel_err err;
    struct pel_fault fault;
    bool in_compute;
    struct pel_renderer_options options;
    struct pel_renderer *renderer; /* render thread */
    struct pel_encoder_pool *pool;
    struct pel_mailbox *box;
    int submitted;         /* jobs with GL; render thread, the next too */
    struct pel_job *large; /* in hand; NULL: none */
    unsigned jobs_since;   /* its last band */
    _Atomic uint64_t band_pixels;
    int64_t drawn_ns; /* when the last picture was there; render thread */
    atomic_bool stop;
    atomic_size_t held_bytes, held_large;
    _Atomic int64_t progress_ns;
    /* Device: of the first renderer, and of the software one that follows. */
    char devices[2][256];
    atomic_int device;
    atomic_bool software;
    struct pel_loss_stats losses;
    int64_t lost_ns[PEL_MANY_LOSSES]; /* the last ones; render thread */
    struct pel_job_draw *again[PEL_MOST_LOST];
    size_t again_count; /* to be drawn again; render thread */
};

/* That the thread is alive; render thread. */
void pel_renderloop_progress(struct pel_renderloop *loop);

/* Draws [first, first + count) of a job that is not large, whose memory is
 * held, failed. Render thread. */
void pel_renderloop_fail(struct pel_renderloop *loop, struct pel_job *job,
                         size_t first, size_t count, enum pel_err err);
