/* The inside of a render loop, for its own files: renderloop.c, loss.c. */
#pragma once

#include <pthread.h>

#include "frames/mailbox.h"
#include "frames/renderloop.h"

/* Losses that are remembered; draws that are under way at most. */
#define PEL_MANY_LOSSES 3
#define PEL_MOST_LOST (PEL_MAX_VIEWS * 4)

/* Draws in order. */
struct pel_parts {
    struct pel_job_draw *first, *last;
};

struct pel_renderloop {
    pthread_t thread;
    /* protects queue, handed, given, ready, ended, err, fault, in_compute,
     * losses */
    pthread_mutex_t lock;
    pthread_cond_t wake; /* CLOCK_MONOTONIC */
    struct pel_queue queue;
    struct pel_parts handed; /* by others that lost their device */
    struct pel_queue given;  /* large jobs, not begun */
    bool ready, joined;
    int ended; /* 1: the thread has */
    enum pel_err err;
    struct pel_fault fault;
    bool in_compute;
    struct pel_renderer_options options;
    struct pel_renderer *renderer; /* render thread */
    struct pel_encoder_pool *pool;
    struct pel_mailbox *box;
    unsigned device;                     /* which of the peers it is */
    struct pel_renderloop *const *peers; /* all, itself too */
    size_t peer_count;
    atomic_bool standing;     /* it has a device */
    _Atomic uint64_t work;    /* pixels that wait here or are drawn */
    _Atomic uint32_t shares;  /* of jobs, likewise */
    _Atomic int64_t awake_ns; /* when work came and there was none */
    int submitted;            /* shares with GL; render thread, the next too */
    const struct pel_share *share; /* in hand; its draws from `at` to `end` */
    size_t at, end;
    struct pel_draw draws[PEL_MAX_VIEWS]; /* of one submission */
    struct pel_job *large;                /* in hand; NULL: none */
    const struct pel_job *large_drawn;    /* begun, not all of it is there */
    unsigned jobs_since;                  /* its last band */
    _Atomic uint64_t band_pixels;
    int64_t drawn_ns; /* when the last picture was there; render thread */
    bool drew;        /* since it rested; render thread */
    atomic_bool stop;
    atomic_size_t held_bytes, held_large;
    clockid_t control; /* what the thread that made this has computed */
    _Atomic int64_t progress_ns, progress_used_ns; /* clock; processor's */
    /* Device: of the first renderer, and of the software one that follows. */
    char devices[2][256];
    atomic_int device_now;
    atomic_bool software;
    struct pel_loss_stats losses;
    int64_t ask_ns, ask_at_ns; /* whether the device is back: how often, when */
    int64_t lost_ns[PEL_MANY_LOSSES]; /* the last ones; render thread */
    struct pel_parts again;           /* to be drawn again; render thread */
    uint64_t put_again;               /* by losses; render thread */
    bool out; /* lost too often: peers draw; render thread */
};

void pel_parts_put(struct pel_parts *parts, struct pel_job_draw *part);
struct pel_job_draw *pel_parts_take(struct pel_parts *parts); /* NULL: none */

/* That the thread is alive; render thread. */
void pel_renderloop_progress(struct pel_renderloop *loop);

/* A draw of a job that is not large, whose memory is held, failed. Render
 * thread. */
void pel_renderloop_fail(struct pel_renderloop *loop, struct pel_job_draw *part,
                         enum pel_err err);

/* What is waiting here goes to a peer that has a device, with `again`; false:
 * none has. Render thread, without a device. */
bool pel_renderloop_pass_on(struct pel_renderloop *loop);
