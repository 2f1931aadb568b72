/* How much is drawn at once: as many pixels as a frame of the others has, so
 * that nobody waits for somebody else's picture longer than for his own. */
#include "base/clock.h"
#include "frames/core.h"

/* So long a job is an example of what others ask for. */
#define USUAL_NS 2000000000LL
#define LONE_PIXELS_GPU (4 * PEL_LONE_PIXELS)
#define LEAST_PIXELS (1u << 16) /* less would be mostly fixed work */

uint64_t pel_fair_job_pixels(const struct pel_job *job)
{
    uint64_t pixels = 0;
    for (size_t i = 0; i < job->draw_count; i++) {
        const struct pel_camera *c = &job->draws[i].camera;
        pixels += (uint64_t)c->width * c->height;
    }
    return pixels;
}

void pel_fair_note(struct pel_frames *frames, const struct pel_job *job)
{
    frames->usual_pixels =
        job->live ? frames->live_pixels : pel_fair_job_pixels(job);
    frames->usual_until_ns = pel_now_ns() + USUAL_NS;
}

static uint64_t bounded(const struct pel_frames *frames, uint64_t pixels)
{
    uint64_t most = pel_devices_software(frames->devices) ? PEL_LONE_PIXELS
                                                          : LONE_PIXELS_GPU;
    return pixels < LEAST_PIXELS ? LEAST_PIXELS : pixels < most ? pixels : most;
}

uint64_t pel_fair_band(const struct pel_frames *frames)
{
    bool others = pel_now_ns() < frames->usual_until_ns;
    return bounded(frames, others ? frames->usual_pixels : UINT64_MAX);
}

/* Pixels that a job may have beside live views. */
static uint64_t most_at_once(const struct pel_frames *frames)
{
    return bounded(frames, frames->running_count > 0 ? frames->live_pixels
                                                     : UINT64_MAX);
}

static uint64_t pixels_asked(const struct pel_frames *frames,
                             const struct pel_snapshot *s,
                             const struct pel_frame_request *request)
{
    uint64_t pixels = pel_request_pixels(s, request);
    for (int i = 0; request->set && i < PEL_MAX_REQUESTS; i++) {
        const struct pel_frame_request *r = &frames->requests[i];
        if (r->used && r != request && r->set == request->set) {
            pixels += pel_request_pixels(s, r);
        }
    }
    return pixels;
}

bool pel_fair_is_large(const struct pel_frames *frames,
                       const struct pel_frame_request *request)
{
    const struct pel_snapshot *s = pel_shown_snapshot(frames);
    uint64_t pixels = pixels_asked(frames, s, request);
    pel_snapshot_unref(s);
    return pixels > most_at_once(frames);
}

bool pel_fair_has_draw(const struct pel_job *job,
                       const struct pel_frame_request *r)
{
    int view = pel_snapshot_find_view(job->snapshot, r->view);
    for (size_t i = 0; view >= 0 && i < job->draw_count; i++) {
        const struct pel_job_draw *part = &job->parts[i];
        const struct pel_view_state *v = &job->snapshot->views[view];
        if ((int)part->view == view && !part->coarse &&
            part->width == (r->width ? r->width : v->width) &&
            part->height == (r->height ? r->height : v->height)) {
            return true;
        }
    }
    return false;
}

bool pel_fair_join(const struct pel_frames *frames, const struct pel_job *job,
                   const struct pel_frame_request *r)
{
    if (r->set ? pel_set_begun(r->set) : pel_fair_has_draw(job, r)) {
        return true;
    }
    uint64_t pixels = pixels_asked(frames, job->snapshot, r);
    return job->large ? job->draw_count == 0
                      : job->asked_pixels + pixels <= most_at_once(frames);
}
