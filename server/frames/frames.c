#include "frames/frames.h"

#include <math.h>
#include <stdlib.h>
#include <unistd.h>

#include "base/clock.h"
#include "base/lock.h"
#include "base/log.h"
#include "encode/video.h"
#include "frames/core.h"

/* One core's time for a pixel of a sea, before any was drawn. */
#define SOFTWARE_PIXEL_MS 2.2e-4

static void receive(void *user, struct pel_mail *mail)
{
    struct pel_frames *frames = user;
    switch (mail->kind) {
    case PEL_MAIL_JOB_DRAWN:
        pel_schedule_drawn(frames, (struct pel_job *)mail);
        break;
    case PEL_MAIL_OUTPUT:
        pel_schedule_output(frames, (struct pel_output *)mail);
        break;
    case PEL_MAIL_SURFACE:
        pel_surface_answer(frames, (struct pel_surface_query *)mail);
        break;
    case PEL_MAIL_OPTICS:
        pel_optics_answer(frames, (struct pel_optics_query *)mail);
        break;
    case PEL_MAIL_TRACK:
        break;
    }
}

static void scene_changed(void *user)
{
    struct pel_frames *frames = user;
    if (frames->subscription_count > 0) {
        const struct pel_snapshot *s = pel_shown_snapshot(frames);
        pel_live_check(frames, s);
        pel_snapshot_unref(s);
    }
}

static void picture_released(void *user, const struct pel_job_draw *part)
{
    struct pel_frames *frames = user;
    pel_devices_released(frames->devices, part);
}

static int encoder_threads(int wanted)
{
    long cores = sysconf(_SC_NPROCESSORS_ONLN);
    if (wanted > 0) {
        return wanted;
    }
    cores = cores > 4 ? cores - 1 : cores; /* one is for drawing */
    return cores < 1                  ? 1
           : cores > PEL_MAX_ENCODERS ? PEL_MAX_ENCODERS
                                      : (int)cores;
}

static enum pel_err make_jobs(struct pel_frames *frames,
                              struct pel_fault *fault)
{
    size_t more = pel_devices_count(frames->devices) - 1;
    size_t count = PEL_JOBS_FIRST + PEL_JOBS_MORE * more;
    frames->jobs = calloc(count, sizeof *frames->jobs);
    if (!frames->jobs) {
        return pel_fault_set(fault, PEL_ERR_NO_MEMORY, "out of memory");
    }
    frames->job_count = (int)count;
    for (size_t i = 0; i < count; i++) {
        pel_lock_init(&frames->jobs[i].standing);
    }
    return PEL_OK;
}

enum pel_err pel_frames_create(const struct pel_frames_options *o,
                               struct pel_scene *scene, struct pel_frames **out,
                               struct pel_fault *fault)
{
    struct pel_fault why;
    if (o->video_encoder && pel_video_check_encoder(o->video_encoder, &why)) {
        return pel_fault_set(fault, why.code, "--video-encoder: %.240s",
                             why.message);
    }
    GMainContext *context = g_main_context_default();
    struct pel_frames *frames = calloc(1, sizeof *frames);
    if (!frames) {
        return pel_fault_set(fault, PEL_ERR_NO_MEMORY, "out of memory");
    }
    pel_mailbox_init(&frames->box, context, receive, frames);
    frames->scene = scene;
    frames->max_fps = pel_clamp(o->max_fps, 1, 240);
    pel_present_begin(&frames->present);
    pel_lanes_begin(&frames->lanes);
    frames->video_encoder = o->video_encoder;
    enum pel_err err = pel_encoder_pool_create(
        encoder_threads(o->encoder_threads), &frames->box, picture_released,
        frames, &frames->pool);
    if (err != PEL_OK) {
        pel_fault_set(fault, err, "cannot start the encoder threads");
        goto fail;
    }
    err = pel_surface_pool_create((int)sysconf(_SC_NPROCESSORS_ONLN),
                                  &frames->box, &frames->surface_pool);
    if (err != PEL_OK) {
        pel_fault_set(fault, err, "cannot start the threads of queries");
        goto fail;
    }
    struct pel_devices_options devices = {
        .list = o->device,
        .lose_only = o->lose_only,
        .renderer = {
            .shader_dir = o->shader_dir,
            .shading = o->shading,
            .debug = o->gl_debug,
            .lose_after = o->lose_after,
            .lose_for_good = o->lose_for_good,
            .filtering.paper = o->paper_form,
        },
    };
    err = pel_devices_create(&devices, frames->pool, &frames->box,
                             &frames->devices, fault);
    if (err == PEL_OK) {
        err = make_jobs(frames, fault);
    }
    if (err != PEL_OK) {
        goto fail;
    }
    if (pel_devices_software(frames->devices)) {
        long cores = sysconf(_SC_NPROCESSORS_ONLN);
        frames->quality.pixel_ms = SOFTWARE_PIXEL_MS / (cores > 1 ? cores : 1);
    }
    pel_frames_set_quality(frames, o->quality);
    frames->tick =
        pel_alarm_create(context, "live frames", pel_schedule_tick, frames);
    frames->start =
        pel_alarm_create(context, "frame requests", pel_schedule_start, frames);
    frames->watch =
        pel_alarm_create(context, "frame watchdog", pel_schedule_watch, frames);
    pel_scene_on_commit(scene, scene_changed, frames);
    *out = frames;
    return PEL_OK;
fail:
    if (!pel_frames_destroy(frames)) {
        pel_fault_set(fault, err, "a thread hangs");
    }
    return err;
}

static void drop_alarm(GSource **source)
{
    if (*source) {
        g_source_destroy(*source);
        g_source_unref(*source);
        *source = NULL;
    }
}

static void drop_jobs(struct pel_frames *frames)
{
    for (int i = 0; frames->jobs && i < frames->job_count; i++) {
        struct pel_job *job = &frames->jobs[i];
        for (size_t k = 0; job->used && k < job->output_count; k++) {
            pel_frame_unref(job->outputs[k].frame);
            pel_track_unref(job->outputs[k].track);
        }
        if (job->used) {
            pel_job_settle(job);
            pel_job_end(job);
            pel_snapshot_unref(job->snapshot);
        }
        pthread_mutex_destroy(&job->standing);
    }
    free(frames->jobs);
    pel_snapshot_unref(frames->sealed.snapshot);
}

bool pel_frames_retire(struct pel_frames *frames)
{
    frames->stopping = true;
    pel_requests_finish_all(frames);
    pel_live_check(frames, NULL);
    if (frames->subscriptions) {
        return false;
    }
    drop_alarm(&frames->tick);
    drop_alarm(&frames->start);
    drop_alarm(&frames->watch);
    g_source_destroy(frames->box.source);
    return true;
}

bool pel_frames_destroy(struct pel_frames *frames)
{
    if (!frames) {
        return true;
    }
    frames->stopping = true;
    drop_alarm(&frames->tick);
    drop_alarm(&frames->start);
    drop_alarm(&frames->watch);
    bool joined = !frames->pool || pel_encoder_pool_stop(frames->pool);
    joined = joined && (!frames->surface_pool ||
                        pel_surface_pool_stop(frames->surface_pool));
    joined = joined && (!frames->devices || pel_devices_stop(frames->devices));
    pel_requests_finish_all(frames);
    pel_surface_finish_all(frames);
    pel_optics_finish_all(frames, joined);
    pel_live_finish(frames);
    if (!joined) {
        /* They still use all this: leaving it is the only safe way. */
        pel_error("FRM-005", "a thread does not end in time and is abandoned");
        return false;
    }
    pel_devices_destroy(frames->devices);
    pel_encoder_pool_destroy(frames->pool);
    pel_surface_pool_destroy(frames->surface_pool);
    pel_mailbox_finish(&frames->box);
    drop_jobs(frames);
    for (int i = 0; i < PEL_MAX_STREAMS; i++) {
        pel_track_unref(frames->streams[i].track);
    }
    free(frames);
    return true;
}

const char *pel_frames_device(const struct pel_frames *frames)
{
    return pel_devices_describe(frames->devices);
}

void pel_frames_get_stats(const struct pel_frames *frames,
                          struct pel_frames_stats *out)
{
    *out = frames->stats;
    pel_surface_pool_used(frames->surface_pool, &out->surfaces_urgent_ns,
                          &out->surfaces_behind_ns);
    out->subscriptions = frames->subscription_count;
    const struct pel_snapshot *s = pel_shown_snapshot(frames);
    for (int i = 0; i < PEL_MAX_STREAMS; i++) {
        const struct pel_stream *stream = &frames->streams[i];
        if (stream->serial) {
            out->live_megapixels +=
                (double)pel_live_pixels(s, stream->view, &stream->profile) *
                1e-6;
        }
    }
    pel_snapshot_unref(s);
    out->render_ms_median = pel_window_rank(&frames->render_ms, 0.5);
    out->render_ms_p95 = pel_window_rank(&frames->render_ms, 0.95);
    out->encode_ms_median = pel_window_rank(&frames->encode_ms, 0.5);
    out->quality = pel_shown_scale(frames);
    out->quality_wanted = pel_quality_scale(&frames->quality);
    out->quality_fixed = frames->quality.fixed;
    out->quality_changes = frames->quality.changes;
    out->present_delay_ms = frames->present.delay_ms;
    out->in_compute = pel_devices_in_compute(frames->devices);
    for (size_t i = 0; i < pel_devices_count(frames->devices); i++) {
        struct pel_device_stats d;
        pel_devices_stats(frames->devices, i, &d);
        out->losses += d.losses.losses;
        out->views_again += d.losses.again;
        out->loss_worst_ms = fmax(out->loss_worst_ms, d.losses.worst_ms);
        out->fallen_back = out->fallen_back || d.losses.fallen_back;
    }
    out->video_ms_median = pel_window_rank(&frames->video_ms, 0.5);
}

double pel_frames_rate(struct pel_frames *frames)
{
    int64_t now_ns = pel_now_ns(), since_ns = now_ns - frames->rate.at_ns;
    uint64_t drawn = frames->stats.frames_drawn;
    if (since_ns > 1000000000) {
        frames->rate.per_s =
            (double)(drawn - frames->rate.drawn) / ((double)since_ns * 1e-9);
        frames->rate.drawn = drawn;
        frames->rate.at_ns = now_ns;
    }
    return frames->rate.per_s;
}

void pel_frames_set_quality(struct pel_frames *frames, double quality)
{
    pel_quality_set(&frames->quality,
                    quality > 0 ? pel_clamp(quality, PEL_QUALITY_MIN, 1) : 0);
}

void pel_frames_set_max_fps(struct pel_frames *frames, double max_fps)
{
    frames->max_fps = pel_clamp(max_fps, 1, 240);
    if (frames->running_count > 0) {
        pel_schedule_live(frames);
    }
}
