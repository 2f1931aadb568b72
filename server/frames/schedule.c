#include <string.h>

#include "base/clock.h"
#include "base/log.h"
#include "frames/core.h"
#include "proto/formats.h"
#include "scene/place.h"
#include "scene/skyplace.h"

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
    for (int i = 0; i < frames->job_count; i++) {
        if (!frames->jobs[i].used) {
            return &frames->jobs[i];
        }
    }
    return NULL;
}

static bool has_room(struct pel_frames *frames)
{
    return pel_devices_room(frames->devices) && free_job(frames) != NULL;
}

/* The first entity's stored place stands for all eyes, in steps that are not
 * seen in rough water: what the sea mirrors is computed once. */
static void place_clouds(const struct pel_snapshot *s,
                         struct pel_environment *env)
{
    const double step_m = 50;
    const struct pel_entity_state *e = s->entity_count ? s->entities : NULL;
    double x = (e ? e->east_m : 0) - env->clouds.east_mps * env->time_s;
    double y = (e ? e->north_m : 0) - env->clouds.north_mps * env->time_s;
    env->clouds_x_m = step_m * round(x / step_m);
    env->clouds_y_m = step_m * round(y / step_m);
    env->own_east_m = e ? e->east_m : 0;
    env->own_north_m = e ? e->north_m : 0;
}

struct pel_environment pel_environment_of(const struct pel_snapshot *s,
                                          double time_s)
{
    struct pel_environment env = {
        .time_s = time_s,
        .sea_level_m = s->sea_level_m,
        .stale = s->mark_stale ? pel_snapshot_stale(s, time_s) : 0,
        .wind_mps = s->wind_mps,
        .wind_to_rad = s->wind_to_rad,
        .visibility_m = s->visibility_m,
        .rain_mm_h = s->rain_mm_h,
        .snow_mm_h = s->snow_mm_h,
        .clouds = s->clouds,
        .water = s->water,
        .orders = s->water_orders,
        .seabed = s->seabed,
        .motes = s->motes,
        .caustics = s->caustics,
        .sparkle = s->sparkle,
        .origin_latitude_rad = s->origin_latitude_rad,
        .origin_longitude_rad = s->origin_longitude_rad,
        .continents = true,
        .weather = s->weather,
        .weather_unix_s = s->epoch_unix_s + time_s + s->weather_shift_s,
    };
    env.lights[PEL_LIGHT_SUN].direction = pel_snapshot_sun(s, time_s);
    if (s->panorama) {
        pel_panorama_lights(s, env.lights);
        env.panorama = s->panorama;
        env.clouds.cover = 0; /* the picture has its own */
        env.panorama_scale = s->panorama_scale;
        env.panorama_azimuth_rad = s->panorama_azimuth_rad;
    }
    place_clouds(s, &env);
    memcpy(env.fog, s->fog, sizeof env.fog);
    env.fog_count = s->fog_count;
    return env;
}

void pel_environment_light_at(const struct pel_snapshot *s,
                              const struct pel_place *place,
                              struct pel_environment *env)
{
    pel_place_lights(s, env->time_s, place, env->lights);
    if (s->panorama) {
        pel_panorama_lights(s, env->lights);
    } else {
        pel_place_night(s, env->time_s, place,
                        env->lights[PEL_LIGHT_SUN].direction, &env->night);
    }
}

void pel_environment_light(const struct pel_snapshot *s,
                           struct pel_environment *env)
{
    const struct pel_place origin = { .origin = true };
    pel_environment_light_at(s, &origin, env);
}

/* The first frame that showed this moment, 0: none did lately. */
static uint64_t first_number(const struct pel_frames *frames,
                             const struct pel_job *job)
{
    for (size_t i = 0; i < PEL_MOMENTS; i++) {
        const struct pel_moment *m = &frames->moments[i];
        if (m->number && m->revision == job->snapshot->revision &&
            m->time_s == job->environment.time_s &&
            m->stale == job->environment.stale) {
            return m->number;
        }
    }
    return 0;
}

/* Every live frame has a number of its own; pictures that are asked for have
 * the one of their moment. */
static void number_job(const struct pel_frames *frames, struct pel_job *job)
{
    uint64_t next =
        frames->sealed.snapshot ? frames->sealed.number : frames->number + 1;
    job->moment = first_number(frames, job);
    job->moment = job->moment ? job->moment : next;
    job->number = job->live ? next : job->moment;
}

static void keep_number(struct pel_frames *frames, const struct pel_job *job)
{
    if (job->moment > frames->number) {
        frames->moments[frames->next_moment] =
            (struct pel_moment){ job->moment, job->snapshot->revision,
                                 job->environment.stale,
                                 job->environment.time_s };
        frames->next_moment = (frames->next_moment + 1) % PEL_MOMENTS;
    }
    if (job->number > frames->number) {
        frames->number = job->number;
    }
}

static struct pel_job *begin_job(struct pel_frames *frames, double time_s,
                                 bool live)
{
    struct pel_job *job = free_job(frames);
    const struct pel_snapshot *s = pel_shown_snapshot(frames);
    job->used = true;
    job->live = live;
    job->large = false;
    job->drawn = false;
    job->requested_ns = pel_now_ns();
    job->present_ns =
        frames->sealed.snapshot
            ? frames->sealed.present_ns
            : job->requested_ns + (int64_t)(frames->present.delay_ms * 1e6);
    job->present_unix_ns =
        frames->sealed.snapshot ? frames->sealed.present_unix_ns : 0;
    job->scale = pel_shown_scale(frames);
    job->snapshot = s;
    job->host_frame = frames->sealed.snapshot
                          ? frames->sealed.host_frame
                          : pel_scene_host_frame(frames->scene);
    job->draw_count = 0;
    job->place_count = 1;
    job->output_count = 0;
    job->asked_pixels = 0;
    job->begun = 0;
    atomic_store(&job->collected, 0);
    job->environment = pel_environment_of(s, time_s);
    job->stale = frames->sealed.coasts ? PEL_STALE_EXERCISE : 0;
    job->environment.stale |= s->mark_stale ? job->stale : 0;
    number_job(frames, job);
    return job;
}

static void end_job(struct pel_job *job)
{
    pel_job_end(job);
    pel_snapshot_unref(job->snapshot);
    job->snapshot = NULL;
    job->used = false;
}

/* Draw of the view at this size, an old one or a new one; live: at the scale
 * of live views, within the same frustum. */
static bool add_draw(struct pel_job *job, size_t view, uint32_t width,
                     uint32_t height, bool live, unsigned layers, size_t *out)
{
    const struct pel_view_state *v = &job->snapshot->views[view];
    width = width ? width : v->width;
    height = height ? height : v->height;
    size_t i = 0;
    bool coarse = live && job->scale < 1;
    while (i < job->draw_count &&
           (job->parts[i].view != view || job->parts[i].width != width ||
            job->parts[i].height != height || job->parts[i].coarse != coarse)) {
        i++;
    }
    struct pel_draw *draw = &job->draws[i];
    struct pel_job_draw *part = &job->parts[i];
    if (i == job->draw_count) {
        if (i == PEL_MAX_VIEWS) {
            return false;
        }
        *part = (struct pel_job_draw){ .job = job,
                                       .view = view,
                                       .width = width,
                                       .height = height,
                                       .coarse = coarse,
                                       .radar = v->radar.on };
        *draw = (struct pel_draw){ .user = part };
        pel_snapshot_camera(job->snapshot, view, job->environment.time_s, width,
                            height, &draw->camera);
        pel_job_settle_place(job, i);
        if (coarse) {
            draw->camera.width = pel_quality_size(job->scale, width);
            draw->camera.height = pel_quality_size(job->scale, height);
        }
        job->draw_count++;
    }
    draw->layers |= layers;
    part->live = part->live || live;
    part->bytes = part->radar ? 0
                              : pel_layer_bytes(draw->layers) *
                                    draw->camera.width * draw->camera.height;
    *out = i;
    return true;
}

static bool same_output(const struct pel_output *a, const struct pel_output *b)
{
    if (a->draw != b->draw || a->format != b->format || a->track || b->track) {
        return false;
    }
    unsigned uses = pel_format_of(a->format)->uses;
    return (!(uses & PEL_FORMAT_QUALITY) || a->quality == b->quality) &&
           (!(uses & PEL_FORMAT_LAYERS) ||
            (a->layers == b->layers && a->float_samples == b->float_samples));
}

/* Encoded once however many ask for it. */
static struct pel_output *add_output(struct pel_job *job,
                                     const struct pel_output *want)
{
    for (size_t i = 0; i < job->output_count; i++) {
        /* One output feeds one stream, and requests of the same number. */
        bool numbered_alike = job->outputs[i].stream == want->stream ||
                              (job->number == job->moment && want->stream == 0);
        if (numbered_alike && same_output(&job->outputs[i], want)) {
            job->outputs[i].low = job->outputs[i].low && want->low;
            return &job->outputs[i];
        }
    }
    if (job->output_count == PEL_MAX_OUTPUTS) {
        return NULL;
    }
    struct pel_output *output = &job->outputs[job->output_count++];
    *output = *want;
    atomic_init(&output->cancel, false);
    output->job = job;
    atomic_fetch_add(&job->parts[want->draw].users, 1);
    return output;
}

static void publish_quality(struct pel_frames *frames)
{
    static struct pel_log_limit limit;
    pel_log_limited(&limit, PEL_LOG_INFO, "FRM-006",
                    "live views are drawn at %.2f of their size to hold %.3g "
                    "Hz",
                    pel_shown_scale(frames), frames->max_fps);
    pel_present_anew(&frames->present);
}

/* Chooses the scale by what is about to be drawn. */
static void expect_streams(struct pel_frames *frames, struct pel_job *job)
{
    struct {
        int view;
        uint32_t width, height;
    } seen[PEL_MAX_STREAMS];
    size_t count = 0;
    uint64_t pixels = 0;
    for (int i = 0; i < PEL_MAX_STREAMS; i++) {
        const struct pel_stream *s = &frames->streams[i];
        int view = s->serial && s->paused < s->subscribers &&
                           s->lane != PEL_LANE_BEHIND
                       ? pel_snapshot_find_view(job->snapshot, s->view)
                       : -1;
        if (view < 0) {
            continue;
        }
        const struct pel_view_state *v = &job->snapshot->views[view];
        uint32_t width = s->profile.width ? s->profile.width : v->width;
        uint32_t height = s->profile.height ? s->profile.height : v->height;
        size_t k = 0;
        while (k < count && (seen[k].view != view || seen[k].width != width ||
                             seen[k].height != height)) {
            k++;
        }
        if (k == count) {
            seen[count].view = view;
            seen[count].width = width;
            seen[count++].height = height;
            pixels += (uint64_t)width * height;
        }
    }
    if (pel_quality_expect(&frames->quality, pixels,
                           1000.0 / frames->max_fps)) {
        job->scale = pel_shown_scale(frames);
        publish_quality(frames);
    }
}

/* False: it is not drawn now. */
static bool add_stream(struct pel_frames *frames, struct pel_job *job,
                       struct pel_stream *stream)
{
    struct pel_output want = { 0 };
    int view = pel_snapshot_find_view(job->snapshot, stream->view);
    if (view < 0 || !pel_live_output(frames, stream, &want) ||
        !add_draw(job, (size_t)view, stream->profile.width,
                  stream->profile.height, true, PEL_LAYER_COLOR, &want.draw)) {
        return false;
    }
    if (want.track && want.kbps == 0) {
        const struct pel_job_draw *part = &job->parts[want.draw];
        want.kbps = pel_video_kbps(part->width, part->height);
    }
    if (!add_output(job, &want)) {
        return false;
    }
    if (want.track) {
        pel_track_ref(want.track);
        pel_live_began(stream, want.want_key);
    }
    return true;
}

/* Those in front, and beside them. */
static void add_streams(struct pel_frames *frames, struct pel_job *job)
{
    static struct pel_log_limit limit;
    uint64_t pixels = 0;
    pel_lanes_sort(frames);
    bool full = pel_lanes_full(frames);
    expect_streams(frames, job);
    for (int i = 0; i < PEL_MAX_STREAMS; i++) {
        struct pel_stream *stream = &frames->streams[i];
        if (!stream->serial) {
            continue;
        }
        uint64_t more =
            pel_live_pixels(job->snapshot, stream->view, &stream->profile);
        if (pixels + more > PEL_LIVE_PIXELS) {
            /* They fitted when they were opened: views have grown since. */
            frames->stats.streams_left_out++;
            pel_log_limited(&limit, PEL_LOG_WARNING, "FRM-007",
                            "live view %s stands still: together they have "
                            "more than %.0f million pixels; make views smaller",
                            stream->view, PEL_LIVE_PIXELS * 1e-6);
            continue;
        }
        pixels += more;
        if (stream->lane == PEL_LANE_FRONT ||
            (stream->lane == PEL_LANE_BESIDE && !full)) {
            add_stream(frames, job, stream);
        }
    }
}

/* False when it has to wait for another frame. */
static bool add_request(struct pel_frames *frames, struct pel_job *job,
                        struct pel_frame_request *r)
{
    const unsigned layers = r->layers;
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
                               .low = r->rank >= PEL_RANK_WATCH &&
                                      is_live(frames) && frames->lanes.high,
                               .layers = layers };
    if (!add_draw(job, (size_t)view, r->width, r->height, false, layers,
                  &want.draw)) {
        return false;
    }
    r->output = add_output(job, &want);
    return r->output != NULL;
}

/* A set goes into one frame whole, or waits for another. */
static bool has_place(const struct pel_job *job,
                      const struct pel_frame_request *r)
{
    if (!r->set || pel_set_begun(r->set)) {
        return true;
    }
    size_t count = pel_set_count(r->set);
    return job->draw_count + count <= PEL_MAX_VIEWS &&
           job->output_count + count <= PEL_MAX_OUTPUTS;
}

/* Requests that a frame of this kind can take: those without a time, or those
 * with this very time; a large job takes its first one, or set, whatever it
 * has. */
static void add_requests(struct pel_frames *frames, struct pel_job *job,
                         bool has_time)
{
    for (;;) {
        struct pel_frame_request *next = NULL;
        for (int i = 0; i < PEL_MAX_REQUESTS; i++) {
            struct pel_frame_request *r = &frames->requests[i];
            bool fits = r->used && !r->output && r->has_time == has_time &&
                        (!has_time || r->time_s == job->environment.time_s);
            if (fits && (!next || r->order < next->order) &&
                pel_fair_join(frames, job, r)) {
                next = r;
            }
        }
        if (!next || !has_place(job, next)) {
            return;
        }
        if (!pel_fair_has_draw(job, next)) {
            job->asked_pixels += pel_request_pixels(job->snapshot, next);
        }
        if (next->set) {
            pel_set_begin(next->set);
        }
        if (!add_request(frames, job, next)) {
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
    job->order = ++frames->job_order;
    keep_number(frames, job);
    pel_surface_keep(frames, job);
    frames->stats.frames_drawn++;
    frames->stats.large_drawn += job->large;
    job->launched_ns = pel_now_ns();
    if (job->large) {
        frames->drawing_large++;
    } else {
        frames->drawing++;
        frames->drawing_live += job->live;
        frames->last_was_live = job->live;
        pel_fair_note(frames, job);
        pel_schedule_watch(frames);
    }
    pel_devices_set_band(frames->devices, pel_fair_band(frames));
    pel_devices_push(frames->devices, job);
}

/* --- when ---------------------------------------------------------------- */

static void step_paced(struct pel_frames *frames)
{
    static struct pel_log_limit limit;
    const struct pel_snapshot *s = pel_scene_snapshot(frames->scene);
    if (s->mode == PEL_CLOCK_PACED && !pel_scene_holds(frames->scene)) {
        struct pel_fault fault;
        if (pel_scene_step(frames->scene, s->rate / frames->max_fps, &fault) !=
            PEL_OK) {
            pel_log_limited(&limit, PEL_LOG_WARNING, "FRM-004",
                            "simulated time could not be advanced: %s",
                            fault.message);
        }
    }
    pel_snapshot_unref(s);
}

static bool has_room_for_large(struct pel_frames *frames);

/* Some streams of low ranks, of the frame that has just begun (0: none has). */
static void draw_behind(struct pel_frames *frames, double time_s,
                        uint64_t number)
{
    uint64_t pixels = 0, turn = frames->job_order + 1;
    if (!pel_lanes_next(frames, turn) || pel_lanes_full(frames) ||
        !has_room_for_large(frames)) {
        return;
    }
    struct pel_job *job = begin_job(frames, time_s, true);
    job->large = true;
    job->number = number ? number : job->number;
    for (struct pel_stream *s; (s = pel_lanes_next(frames, turn));) {
        uint64_t more = pel_live_pixels(job->snapshot, s->view, &s->profile);
        more = (uint64_t)((double)more * job->scale * job->scale);
        if (pixels > 0 && pixels + more > pel_fair_band(frames)) {
            break;
        }
        s->turn = turn;
        pixels += add_stream(frames, job, s) ? more : 0;
    }
    frames->stats.behind_drawn += job->output_count;
    launch(frames, job);
}

/* One frame of every stream and the requests that wait for it. */
static void draw_live(struct pel_frames *frames)
{
    if (!has_room(frames) || frames->drawing_live >= PEL_MAX_DRAWING) {
        frames->stats.frames_skipped++;
        return;
    }
    double time_s = pel_shown_time(frames);
    struct pel_job *job = begin_job(frames, time_s, true);
    add_streams(frames, job);
    frames->live_pixels = pel_fair_job_pixels(job);
    add_requests(frames, job, false);
    uint64_t number = job->draw_count > 0 ? job->number : 0;
    launch(frames, job);
    draw_behind(frames, time_s, number);
}

void pel_schedule_shown(struct pel_frames *frames)
{
    if (is_live(frames) && !frames->stopping) {
        draw_live(frames);
    }
    pel_schedule_soon(frames);
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
    if (frames->sealed.snapshot) {
        return; /* those who seal draw */
    }
    if (has_room(frames) && frames->drawing_live < PEL_MAX_DRAWING) {
        step_paced(frames);
    }
    draw_live(frames);
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
static struct pel_frame_request *next_starter(struct pel_frames *frames,
                                              bool large)
{
    struct pel_frame_request *oldest = NULL;
    for (int i = 0; i < PEL_MAX_REQUESTS; i++) {
        struct pel_frame_request *r = &frames->requests[i];
        if (r->used && !r->output && (!oldest || r->order < oldest->order) &&
            pel_fair_is_large(frames, r) == large &&
            (large || !must_wait(frames, r))) {
            oldest = r;
        }
    }
    return oldest;
}

static void start_with(struct pel_frames *frames,
                       const struct pel_frame_request *first, bool large)
{
    bool has_time = first->has_time;
    double time_s = has_time ? first->time_s : pel_shown_time(frames);
    struct pel_job *job = begin_job(frames, time_s, false);
    job->large = large;
    add_requests(frames, job, has_time);
    launch(frames, job);
}

/* One at a time for each device, and memory may wait for encoders: half of the
 * jobs are left to the others. */
static bool has_room_for_large(struct pel_frames *frames)
{
    int count = 0;
    for (int i = 0; i < frames->job_count; i++) {
        count += frames->jobs[i].used && frames->jobs[i].large;
    }
    return frames->drawing_large < pel_devices_standing(frames->devices) &&
           count < frames->job_count / 2 && free_job(frames);
}

void pel_schedule_start(void *user)
{
    struct pel_frames *frames = user;
    while (!frames->stopping && has_room(frames)) {
        const struct pel_frame_request *first = next_starter(frames, false);
        if (!first) {
            break;
        }
        start_with(frames, first, false);
    }
    while (!frames->stopping && has_room_for_large(frames)) {
        const struct pel_frame_request *first = next_starter(frames, true);
        if (!first) {
            break;
        }
        start_with(frames, first, true);
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

static int64_t patience_ns(const struct pel_frames *frames)
{
    int64_t ns = 0;
    if (!pel_devices_software(frames->devices)) {
        return 0;
    }
    for (int i = 0; i < frames->job_count; i++) {
        const struct pel_job *job = &frames->jobs[i];
        if (job->used && !job->drawn) {
            ns += SOFTWARE_PIXEL_NS * (int64_t)(job->large
                                                    ? PEL_LONE_PIXELS
                                                    : pel_fair_job_pixels(job));
        }
    }
    return ns;
}

static bool is_silent(const struct pel_frames *frames)
{
    return frames->drawing > 0 &&
           pel_now_ns() - pel_devices_progress_ns(frames->devices) >
               STUCK_NS + patience_ns(frames);
}

bool pel_frames_stuck(const struct pel_frames *frames)
{
    return is_silent(frames) && !pel_devices_compute(frames->devices);
}

void pel_schedule_watch(void *user)
{
    struct pel_frames *frames = user;
    if (is_silent(frames) && !pel_frames_stuck(frames) &&
        frames->slow_order != frames->job_order) {
        frames->slow_order = frames->job_order;
        pel_info("FRM-013",
                 "a picture takes more than %.1f s: programs are compiled, or "
                 "the machine is busy (%u frames wait)",
                 (double)(STUCK_NS + patience_ns(frames)) * 1e-9,
                 frames->drawing);
    }
    if (pel_frames_stuck(frames) && frames->stuck_order != frames->job_order) {
        frames->stuck_order = frames->job_order;
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

/* How long the renderer was busy with live views alone, and what follows. */
static void feed_quality(struct pel_frames *frames, const struct pel_job *job)
{
    int64_t since = job->launched_ns > frames->last_drawn_ns
                        ? job->launched_ns
                        : frames->last_drawn_ns;
    double busy_ms = (double)(job->drawn_ns - since) * 1e-6;
    double period_ms = 1000.0 / frames->max_fps;
    bool alone = true;
    uint64_t pixels = 0;
    for (size_t i = 0; i < job->draw_count; i++) {
        const struct pel_job_draw *part = &job->parts[i];
        pixels += (uint64_t)part->width * part->height;
        alone = alone && part->live && part->err == PEL_OK;
    }
    frames->last_drawn_ns = job->drawn_ns;
    if (job->live && !job->large) {
        pel_lanes_feed(&frames->lanes, busy_ms, period_ms, job->drawn_ns);
    }
    alone = alone && frames->drawing_large == 0;
    if (alone && pel_quality_feed(&frames->quality, job->scale, pixels, busy_ms,
                                  period_ms, job->drawn_ns)) {
        publish_quality(frames);
    }
}

void pel_schedule_drawn(struct pel_frames *frames, struct pel_job *job)
{
    for (size_t i = 0; i < job->draw_count; i++) {
        if (job->parts[i].err == PEL_OK && !job->parts[i].radar) {
            pel_window_add(&frames->render_ms, job->parts[i].render_ms);
            frames->stats.views_drawn++;
        }
    }
    pel_devices_note(frames->devices, job);
    feed_quality(frames, job);
    if (job->large) {
        frames->drawing_large--;
    } else {
        frames->drawing--;
        frames->drawing_live -= job->live;
    }
    job->drawn = true;
    end_if_complete(job);
    pel_schedule_soon(frames);
}

/* Whether an earlier frame of the stream is still with the encoders. */
static bool overtakes(const struct pel_frames *frames,
                      const struct pel_output *output)
{
    for (int i = 0; i < frames->job_count; i++) {
        const struct pel_job *job = &frames->jobs[i];
        if (!job->used || job->order >= output->job->order) {
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
        for (int i = 0; i < frames->job_count; i++) {
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
        bool video = output->frame->codec != PEL_CODEC_PICTURE;
        if (output->stream && !output->low) {
            pel_present_feed(&frames->present,
                             (double)(output->frame->encoded_ns -
                                      output->frame->requested_ns) *
                                 1e-6);
        }
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
                  *output->why ? output->why : pel_err_name(output->err));
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
    for (int i = 0; i < frames->job_count; i++) {
        if (frames->jobs[i].used) {
            end_if_complete(&frames->jobs[i]);
        }
    }
    pel_schedule_soon(frames); /* a job may be free now */
}
