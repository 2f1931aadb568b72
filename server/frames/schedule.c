#include <string.h>

#include "base/clock.h"
#include "base/log.h"
#include "frames/core.h"

/* Live frames that come sooner than this take waiting requests along; one that
 * found no place in them for so long gets its own. */
#define JOIN_NS 50000000
#define JOIN_LIMIT_NS 500000000
#define STUCK_NS 2000000000LL
/* The processor's time for a pixel, generously: what a large picture may take
 * beyond that without being stuck. */
#define SOFTWARE_PIXEL_NS 4000

static int64_t period_ns(const struct pel_frames *frames)
{
    return (int64_t)(1e9 / frames->max_fps);
}

static bool is_live(const struct pel_frames *frames)
{
    return frames->running_count > 0;
}

void pel_schedule_soon(struct pel_frames *frames)
{
    g_source_set_ready_time(frames->start, 0);
}

/* --- building a job ------------------------------------------------------ */

static struct pel_job *free_job(struct pel_frames *frames)
{
    for (int i = 0; i < PEL_JOB_COUNT; i++) {
        if (!frames->jobs[i].used) {
            return &frames->jobs[i];
        }
    }
    return NULL;
}

static bool has_room(struct pel_frames *frames)
{
    return frames->drawing < PEL_MAX_DRAWING && free_job(frames) != NULL;
}

struct pel_environment pel_environment_of(const struct pel_snapshot *s,
                                          double time_s)
{
    return (struct pel_environment){
        .time_s = time_s,
        .sea = s->sea,
        .sea_level_m = s->sea_level_m,
        .stale = s->mark_stale ? s->stale : 0,
        .sun = pel_snapshot_sun(s, time_s),
        .wind_mps = s->wind_mps,
        .wind_to_rad = s->wind_to_rad,
        .visibility_m = s->visibility_m,
        .water = s->water,
    };
}

static struct pel_job *begin_job(struct pel_frames *frames, double time_s,
                                 bool live)
{
    struct pel_job *job = free_job(frames);
    const struct pel_snapshot *s = pel_scene_snapshot(frames->scene);
    job->used = true;
    job->live = live;
    job->drawn = false;
    job->requested_ns = pel_now_ns();
    job->snapshot = s;
    job->host_frame = pel_scene_host_frame(frames->scene);
    job->draw_count = 0;
    job->output_count = 0;
    job->collected = 0;
    job->environment = pel_environment_of(s, time_s);
    return job;
}

static void end_job(struct pel_job *job)
{
    pel_snapshot_unref(job->snapshot);
    job->snapshot = NULL;
    job->used = false;
}

/* Draw of the view at this size, an old one or a new one. */
static bool add_draw(struct pel_job *job, size_t view, uint32_t width,
                     uint32_t height, unsigned layers, size_t *out)
{
    const struct pel_view_state *v = &job->snapshot->views[view];
    width = width ? width : v->width;
    height = height ? height : v->height;
    size_t i = 0;
    while (i < job->draw_count &&
           (job->parts[i].view != view || job->draws[i].camera.width != width ||
            job->draws[i].camera.height != height)) {
        i++;
    }
    struct pel_draw *draw = &job->draws[i];
    struct pel_job_draw *part = &job->parts[i];
    if (i == job->draw_count) {
        if (i == PEL_MAX_VIEWS) {
            return false;
        }
        *part = (struct pel_job_draw){ .job = job, .view = view };
        *draw = (struct pel_draw){ .user = part };
        pel_snapshot_camera(job->snapshot, view, job->environment.time_s, width,
                            height, &draw->camera);
        job->draw_count++;
    }
    draw->layers |= layers;
    part->bytes = pel_layer_bytes(draw->layers) * width * height;
    *out = i;
    return true;
}

static bool same_output(const struct pel_output *a, const struct pel_output *b)
{
    if (a->draw != b->draw || a->format != b->format || a->track || b->track) {
        return false;
    }
    switch (a->format) {
    case PELAGOS__FRAME_FORMAT__JPEG:
        return a->quality == b->quality;
    case PELAGOS__FRAME_FORMAT__EXR:
        return a->layers == b->layers && a->float_samples == b->float_samples;
    default:
        return true;
    }
}

/* Encoded once however many ask for it. */
static struct pel_output *add_output(struct pel_job *job,
                                     const struct pel_output *want)
{
    for (size_t i = 0; i < job->output_count; i++) {
        if (same_output(&job->outputs[i], want)) {
            return &job->outputs[i];
        }
    }
    if (job->output_count == PEL_MAX_OUTPUTS) {
        return NULL;
    }
    struct pel_output *output = &job->outputs[job->output_count++];
    *output = *want;
    output->job = job;
    atomic_fetch_add(&job->parts[want->draw].users, 1);
    return output;
}

static void add_streams(struct pel_frames *frames, struct pel_job *job)
{
    for (int i = 0; i < PEL_MAX_STREAMS; i++) {
        struct pel_stream *stream = &frames->streams[i];
        struct pel_output want = { 0 };
        int view = stream->serial
                       ? pel_snapshot_find_view(job->snapshot, stream->view)
                       : -1;
        if (view < 0 || !pel_live_output(frames, stream, &want)) {
            continue;
        }
        bool added =
            add_draw(job, (size_t)view, stream->profile.width,
                     stream->profile.height, PEL_LAYER_COLOR, &want.draw);
        if (added && want.track && want.kbps == 0) {
            const struct pel_camera *c = &job->draws[want.draw].camera;
            want.kbps = pel_video_kbps(c->width, c->height);
        }
        if (added && add_output(job, &want) && want.track) {
            pel_track_ref(want.track);
            pel_live_began(stream, want.want_key);
        }
    }
}

/* False when it has to wait for another frame. */
static bool add_request(struct pel_frames *frames, struct pel_job *job,
                        struct pel_frame_request *r)
{
    bool exr = r->format == PELAGOS__FRAME_FORMAT__EXR;
    unsigned layers = exr ? r->layers : PEL_LAYER_COLOR;
    int view = pel_snapshot_find_view(job->snapshot, r->view);
    if (view < 0) {
        struct pel_fault fault;
        pel_fault_set(&fault, PEL_ERR_NOT_FOUND, "the view was deleted");
        memcpy(fault.path, "view", sizeof "view");
        pel_request_finish(frames, r, PEL_ERR_NOT_FOUND, &fault, NULL);
        return true;
    }
    struct pel_output want = { .format = r->format,
                               .quality = r->quality,
                               .float_samples = r->float_samples,
                               .layers = layers };
    if (!add_draw(job, (size_t)view, r->width, r->height, layers, &want.draw)) {
        return false;
    }
    r->output = add_output(job, &want);
    return r->output != NULL;
}

/* Requests that a frame of this kind can take: those without a time, or those
 * with this very time. */
static void add_requests(struct pel_frames *frames, struct pel_job *job,
                         bool has_time)
{
    for (;;) {
        struct pel_frame_request *next = NULL;
        for (int i = 0; i < PEL_MAX_REQUESTS; i++) {
            struct pel_frame_request *r = &frames->requests[i];
            bool fits = r->used && !r->output && r->has_time == has_time &&
                        (!has_time || r->time_s == job->environment.time_s);
            if (fits && (!next || r->order < next->order)) {
                next = r;
            }
        }
        if (!next || !add_request(frames, job, next)) {
            return;
        }
    }
}

static void launch(struct pel_frames *frames, struct pel_job *job)
{
    if (job->draw_count == 0) {
        end_job(job);
        return;
    }
    job->number = ++frames->number;
    frames->drawing++;
    frames->last_was_live = job->live;
    frames->stats.frames_drawn++;
    frames->launched_ns = pel_now_ns();
    pel_schedule_watch(frames);
    pel_renderloop_push(frames->loop, job);
}

/* --- when ---------------------------------------------------------------- */

static void step_paced(struct pel_frames *frames)
{
    static struct pel_log_limit limit;
    const struct pel_snapshot *s = pel_scene_snapshot(frames->scene);
    if (s->mode == PEL_CLOCK_PACED) {
        struct pel_fault fault;
        if (pel_scene_step(frames->scene, s->rate / frames->max_fps, &fault) !=
            PEL_OK) {
            pel_log_limited(&limit, PEL_LOG_WARNING, "FRM-004",
                            "time stands still: %s", fault.message);
        }
    }
    pel_snapshot_unref(s);
}

void pel_schedule_tick(void *user)
{
    struct pel_frames *frames = user;
    if (!is_live(frames) || frames->stopping) {
        return;
    }
    int64_t period = period_ns(frames), now = pel_now_ns();
    int64_t late = (now - frames->next_tick_ns) / period;
    frames->stats.frames_skipped += late > 0 ? (uint64_t)late : 0;
    frames->next_tick_ns += (late > 0 ? late + 1 : 1) * period;
    g_source_set_ready_time(frames->tick, frames->next_tick_ns / 1000);
    if (!has_room(frames)) {
        frames->stats.frames_skipped++;
        return;
    }
    step_paced(frames);
    struct pel_job *job =
        begin_job(frames, pel_scene_time(frames->scene), true);
    add_streams(frames, job);
    add_requests(frames, job, false);
    launch(frames, job);
}

/* Whether a request has to wait although there is room: for a live frame that
 * comes soon, or, with a time of its own, for its turn between live frames. */
static bool must_wait(const struct pel_frames *frames,
                      const struct pel_frame_request *request)
{
    if (!is_live(frames)) {
        return false;
    }
    if (request->has_time ||
        pel_now_ns() - request->requested_ns > JOIN_LIMIT_NS) {
        return frames->drawing > 0 && !frames->last_was_live;
    }
    return period_ns(frames) <= JOIN_NS;
}

/* Oldest waiting request that may begin a frame now. */
static struct pel_frame_request *next_starter(struct pel_frames *frames)
{
    struct pel_frame_request *oldest = NULL;
    for (int i = 0; i < PEL_MAX_REQUESTS; i++) {
        struct pel_frame_request *r = &frames->requests[i];
        if (r->used && !r->output && !must_wait(frames, r) &&
            (!oldest || r->order < oldest->order)) {
            oldest = r;
        }
    }
    return oldest;
}

void pel_schedule_start(void *user)
{
    struct pel_frames *frames = user;
    while (!frames->stopping && has_room(frames)) {
        struct pel_frame_request *first = next_starter(frames);
        if (!first) {
            return;
        }
        bool has_time = first->has_time;
        double time_s =
            has_time ? first->time_s : pel_scene_time(frames->scene);
        struct pel_job *job = begin_job(frames, time_s, false);
        add_requests(frames, job, has_time);
        launch(frames, job);
    }
}

void pel_schedule_live(struct pel_frames *frames)
{
    int64_t now = pel_now_ns();
    if (!is_live(frames)) {
        g_source_set_ready_time(frames->tick, -1);
        frames->next_tick_ns = 0;
        pel_schedule_soon(frames); /* requests that waited for a live frame */
        return;
    }
    /* The first viewer gets a frame at once; later ones join the beat. */
    if (frames->next_tick_ns == 0 ||
        frames->next_tick_ns > now + period_ns(frames)) {
        frames->next_tick_ns = now;
    }
    g_source_set_ready_time(frames->tick, frames->next_tick_ns / 1000);
}

/* --- is it stuck? -------------------------------------------------------- */

static size_t job_pixels(const struct pel_job *job)
{
    size_t pixels = 0;
    for (size_t i = 0; i < job->draw_count; i++) {
        const struct pel_camera *c = &job->draws[i].camera;
        pixels += (size_t)c->width * c->height;
    }
    return pixels;
}

static int64_t patience_ns(const struct pel_frames *frames)
{
    int64_t ns = 0;
    if (!pel_renderloop_is_software(frames->loop)) {
        return 0;
    }
    for (int i = 0; i < PEL_JOB_COUNT; i++) {
        const struct pel_job *job = &frames->jobs[i];
        if (job->used && !job->drawn) {
            ns += (int64_t)job_pixels(job) * SOFTWARE_PIXEL_NS;
        }
    }
    return ns;
}

bool pel_frames_stuck(const struct pel_frames *frames)
{
    int64_t since = pel_renderloop_progress_ns(frames->loop);
    if (since < frames->launched_ns && frames->drawing == 1) {
        since = frames->launched_ns;
    }
    return frames->drawing > 0 &&
           pel_now_ns() - since > STUCK_NS + patience_ns(frames);
}

void pel_schedule_watch(void *user)
{
    struct pel_frames *frames = user;
    if (pel_frames_stuck(frames) && frames->stuck_number != frames->number) {
        frames->stuck_number = frames->number;
        pel_error("FRM-002",
                  "the renderer has been silent for more than %.1f s (%u "
                  "frames wait, the last is %llu)",
                  (double)(STUCK_NS + patience_ns(frames)) * 1e-9,
                  frames->drawing, (unsigned long long)frames->number);
    }
    if (frames->drawing > 0) {
        g_source_set_ready_time(frames->watch,
                                (pel_now_ns() + STUCK_NS / 2) / 1000);
    }
}

/* --- jobs and pictures come back ----------------------------------------- */

static void end_if_complete(struct pel_job *job)
{
    bool complete = job->drawn;
    for (size_t i = 0; i < job->output_count; i++) {
        complete = complete && job->outputs[i].delivered;
    }
    if (complete) {
        end_job(job);
    }
}

void pel_schedule_drawn(struct pel_frames *frames, struct pel_job *job)
{
    for (size_t i = 0; i < job->draw_count; i++) {
        if (job->parts[i].err == PEL_OK) {
            pel_window_add(&frames->render_ms, job->parts[i].render_ms);
            frames->stats.views_drawn++;
        }
    }
    frames->drawing--;
    job->drawn = true;
    end_if_complete(job);
    pel_schedule_soon(frames);
}

/* Whether an earlier frame of the stream is still with the encoders. */
static bool overtakes(const struct pel_frames *frames,
                      const struct pel_output *output)
{
    for (int i = 0; i < PEL_JOB_COUNT; i++) {
        const struct pel_job *job = &frames->jobs[i];
        if (!job->used || job->number >= output->job->number) {
            continue;
        }
        for (size_t k = 0; k < job->output_count; k++) {
            if (job->outputs[k].stream == output->stream &&
                !job->outputs[k].delivered) {
                return true;
            }
        }
    }
    return false;
}

static void deliver(struct pel_frames *frames, struct pel_output *output)
{
    output->delivered = true;
    if (output->stream != 0) {
        pel_live_deliver(frames, output->stream, output->err, output->why,
                         output->frame);
    }
    pel_frame_unref(output->frame);
    output->frame = NULL;
}

/* Live frames go out in order of their numbers: one that was encoded sooner
 * than its predecessor is held until that is out. */
static void deliver_ready(struct pel_frames *frames)
{
    for (bool again = true; again;) {
        again = false;
        for (int i = 0; i < PEL_JOB_COUNT; i++) {
            struct pel_job *job = &frames->jobs[i];
            for (size_t k = 0; job->used && k < job->output_count; k++) {
                struct pel_output *o = &job->outputs[k];
                if (o->done && !o->delivered && !overtakes(frames, o)) {
                    deliver(frames, o);
                    again = true;
                }
            }
        }
    }
}

void pel_schedule_output(struct pel_frames *frames, struct pel_output *output)
{
    if (output->frame) {
        frames->stats.pictures_encoded++;
        frames->stats.encoded_bytes += output->frame->size;
        bool video = output->frame->codec == PEL_CODEC_H264;
        pel_window_add(video ? &frames->video_ms : &frames->encode_ms,
                       output->frame->encode_ms);
        if (video) {
            frames->stats.video_frames++;
            frames->stats.video_bytes += output->frame->size;
            frames->stats.video_keys += output->frame->key;
        }
    }
    struct pel_fault fault;
    pel_fault_set(&fault, output->err, "the picture could not be made: %s",
                  pel_err_name(output->err));
    for (int i = 0; i < PEL_MAX_REQUESTS; i++) {
        if (frames->requests[i].used && frames->requests[i].output == output) {
            pel_request_finish(frames, &frames->requests[i], output->err,
                               output->err == PEL_OK ? NULL : &fault,
                               output->frame);
        }
    }
    output->done = true;
    if (output->stream == 0) {
        deliver(frames, output);
    } else {
        deliver_ready(frames);
    }
    for (int i = 0; i < PEL_JOB_COUNT; i++) {
        if (frames->jobs[i].used) {
            end_if_complete(&frames->jobs[i]);
        }
    }
    pel_schedule_soon(frames); /* a job may be free now */
}
