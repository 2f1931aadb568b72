/* The devices that draw, a render thread each. The views of a frame are spread
 * over them by the time that views and devices were seen to take; a device that
 * is lost leaves its views to the others. Which device draws a picture does not
 * show in it, as long as they are alike. Control thread, where nothing else is
 * said. */
#pragma once

#include "frames/renderloop.h"

struct pel_devices;

struct pel_devices_options {
    /* What pel_renderer_options.device names, or several of that with commas
     * between, at most PEL_MAX_DEVICES; "all": every device of hardware, or the
     * software device where there is none. NULL: "auto". */
    const char *list;
    struct pel_renderer_options renderer; /* of each; its device is not read */
    int lose_only; /* which one renderer.lose_after is for; -1: each */
};

/* Starts a thread each and waits until all draw. OUT_OF_RANGE, GPU, NO_MEMORY,
 * IO with a fault. */
PEL_CHECK enum pel_err pel_devices_create(const struct pel_devices_options *o,
                                          struct pel_encoder_pool *pool,
                                          struct pel_mailbox *box,
                                          struct pel_devices **out,
                                          struct pel_fault *fault);

size_t pel_devices_count(const struct pel_devices *devices);

/* What draws now, the first of them first; until the next call. */
const char *pel_devices_describe(struct pel_devices *devices);

/* Whether the first, or the only one left, is the processor. */
bool pel_devices_software(const struct pel_devices *devices);

/* How many have a device, at least 1. */
size_t pel_devices_standing(const struct pel_devices *devices);

/* Whether one of them would begin another job soon. */
bool pel_devices_room(const struct pel_devices *devices);

/* Spreads a job, or gives it to one if it is large; it comes back as
 * PEL_MAIL_JOB_DRAWN. */
void pel_devices_push(struct pel_devices *devices, struct pel_job *job);

/* Learns from what a job took, when it is back. */
void pel_devices_note(struct pel_devices *devices, const struct pel_job *job);

void pel_devices_push_optics(struct pel_devices *devices,
                             struct pel_optics_query *query);
void pel_devices_set_band(struct pel_devices *devices, uint64_t pixels);

/* A readback buffer is free again; any thread. */
void pel_devices_released(struct pel_devices *devices,
                          const struct pel_job_draw *part);

/* When the one that has been silent longest with work to do last made progress;
 * now, if there is none. */
int64_t pel_devices_progress_ns(const struct pel_devices *devices);

/* That one computes (pel_renderloop_computes). */
bool pel_devices_compute(const struct pel_devices *devices);

bool pel_devices_in_compute(const struct pel_devices *devices);

struct pel_device_stats {
    const char *name; /* GL_RENDERER and GL_VERSION, lives as long */
    bool standing;
    uint64_t views;       /* drawn */
    double ms_per_mpixel; /* as last seen; 0: nothing drawn yet */
    struct pel_loss_stats losses;
};
void pel_devices_stats(struct pel_devices *devices, size_t device,
                       struct pel_device_stats *out);

/* As pel_renderloop_stop, of all. The encoders must have stopped. */
bool pel_devices_stop(struct pel_devices *devices);
void pel_devices_destroy(struct pel_devices *devices); /* after stop */
