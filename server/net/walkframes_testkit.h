/* The frame path without its threads, for walks: requests wait and live views
 * are due as ever, and the test plays renderer and encoder. */
#pragma once

#include <glib.h>
#include <stdlib.h>

#include "frames/core.h"

static inline void walk_ring(void *user)
{
    (void)user;
}

static inline void walk_receive(void *user, struct pel_mail *mail)
{
    (void)user;
    (void)mail;
}

static inline void walk_released(void *user, const struct pel_job_draw *part)
{
    (void)user;
    (void)part;
}

/* NULL: no memory, or no thread. */
static inline struct pel_frames *walk_frames(struct pel_scene *scene)
{
    struct pel_frames *frames = calloc(1, sizeof *frames);
    if (!frames) {
        return NULL;
    }
    frames->scene = scene;
    frames->max_fps = 60;
    frames->job_count = PEL_JOBS_FIRST;
    frames->jobs = calloc(PEL_JOBS_FIRST, sizeof *frames->jobs);
    frames->tick = pel_alarm_create(NULL, "tick", walk_ring, frames);
    frames->start = pel_alarm_create(NULL, "start", walk_ring, frames);
    pel_mailbox_init(&frames->box, NULL, walk_receive, frames);
    if (!frames->jobs ||
        pel_encoder_pool_create(1, &frames->box, walk_released, frames,
                                &frames->pool) != PEL_OK) {
        abort();
    }
    return frames;
}

static inline bool walk_frames_end(struct pel_frames *frames)
{
    bool joined = pel_encoder_pool_stop(frames->pool);
    if (joined) {
        pel_encoder_pool_destroy(frames->pool);
    }
    pel_mailbox_finish(&frames->box);
    g_source_destroy(frames->tick);
    g_source_unref(frames->tick);
    g_source_destroy(frames->start);
    g_source_unref(frames->start);
    free(frames->jobs);
    free(frames);
    return joined;
}

/* A picture of so many bytes, which all are `fill`. */
static inline struct pel_frame *walk_picture(size_t size, int fill)
{
    struct pel_frame *frame = pel_frame_create();
    struct pel_bytes bytes = { malloc(size + 1), size };
    if (!frame || !bytes.data) {
        abort();
    }
    for (size_t i = 0; i < size; i++) {
        bytes.data[i] = (uint8_t)fill;
    }
    pel_frame_set_bytes(frame, &bytes);
    return frame;
}
