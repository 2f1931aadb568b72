#include "frames/loss.h"

#include <stdio.h>
#include <string.h>

#include "base/clock.h"
#include "base/log.h"

/* PEL_MANY_LOSSES within this, and the software device draws from then on; for
 * how long encoders may keep pictures of a renderer that goes; how long a
 * device may take to come back where no other draws, and how often it is asked;
 * where others draw, which wait for the driver meanwhile, half as often each
 * time; and how long they draw in peace between two pieces of what it held. */
#define MANY_LOSSES_NS (300 * INT64_C(1000000000))
#define RELEASE_NS (10 * INT64_C(1000000000))
#define RETURN_NS (10 * INT64_C(1000000000))
#define RETURN_ASK_NS INT64_C(100000000)
#define REST_NS INT64_C(4000000)
#define RETURN_SELDOM_NS (10 * INT64_C(1000000000))
/* No device has this number. */
#define WITHDRAWN "-1"

void pel_loss_note_device(struct pel_renderloop *loop, int at)
{
    snprintf(loop->devices[at], sizeof loop->devices[at], "%s",
             pel_renderer_description(loop->renderer));
    atomic_store(&loop->device_now, at);
    atomic_store(&loop->software, pel_renderer_is_software(loop->renderer));
}

/* Whether it was lost so often that it is not to be trusted. */
static bool lost_often(struct pel_renderloop *loop, int64_t now)
{
    memmove(&loop->lost_ns[1], &loop->lost_ns[0],
            (PEL_MANY_LOSSES - 1) * sizeof loop->lost_ns[0]);
    loop->lost_ns[0] = now;
    return loop->lost_ns[PEL_MANY_LOSSES - 1] != 0 &&
           now - loop->lost_ns[PEL_MANY_LOSSES - 1] < MANY_LOSSES_NS;
}

/* A draw of a job that is not large, whose memory is held. */
void pel_loss_put_again(struct pel_renderloop *loop, struct pel_job_draw *part)
{
    if (++part->losses > PEL_LOSS_MOST_AGAIN) {
        pel_renderloop_fail(loop, part, PEL_ERR_GPU);
    } else {
        atomic_fetch_sub(&loop->held_bytes, part->bytes);
        pel_parts_put(&loop->again, part);
        loop->put_again++;
    }
}

/* A draw of the large job. */
static void begin_anew(struct pel_renderloop *loop, struct pel_job_draw *part)
{
    if (part->rows_begun > 0) {
        atomic_fetch_sub(&loop->held_large, part->bytes);
        part->rows_begun = 0;
        part->losses++;
    }
}

/* Draws that were under way are to be made again. */
static void take_back(struct pel_renderloop *loop)
{
    void *users[PEL_MOST_LOST];
    size_t count = pel_renderer_abandon(loop->renderer, users, PEL_MOST_LOST);
    for (size_t i = 0; i < count; i++) {
        struct pel_job_draw *part = users[i];
        struct pel_job *job = part->job;
        size_t at = (size_t)(part - job->parts);
        if (!job->large) {
            pel_loss_put_again(loop, part);
            continue;
        }
        begin_anew(loop, part);
        /* It goes on with the first of them. */
        loop->large = job;
        job->begun = at < job->begun ? at : job->begun;
    }
    if (loop->large) {
        begin_anew(loop, &loop->large->parts[loop->large->begun]);
    }
}

static void wait_ns(struct pel_renderloop *loop, int64_t ns)
{
    pthread_mutex_lock(&loop->lock);
    pel_cond_wait_ns(&loop->wake, &loop->lock, ns);
    pthread_mutex_unlock(&loop->lock);
}

/* Encoders read pictures of the renderer that goes. */
static bool wait_unused(struct pel_renderloop *loop)
{
    int64_t end_ns = pel_now_ns() + RELEASE_NS;
    while (!pel_renderer_unused(loop->renderer) && pel_now_ns() < end_ns) {
        pel_renderloop_pass_on(loop);
        wait_ns(loop, 1000000);
        pel_renderloop_progress(loop);
    }
    return pel_renderer_unused(loop->renderer);
}

/* While peers draw, which wait for the driver with each piece. */
static void rest(void *user)
{
    struct pel_renderloop *loop = user;
    if (!atomic_load(&loop->software) && !atomic_load(&loop->stop) &&
        pel_renderloop_pass_on(loop)) {
        pel_renderloop_progress(loop);
        wait_ns(loop, REST_NS);
    }
}

/* A renderer on hardware where hardware was before, while there is a hope. */
static enum pel_err try_again(struct pel_renderloop *loop, bool software,
                              bool hopes, struct pel_fault *fault)
{
    struct pel_renderer_options options = loop->options;
    options.device = software ? "software" : options.device;
    enum pel_err err = pel_renderer_create(&options, &loop->renderer, fault);
    if (err == PEL_OK && hopes && pel_renderer_is_software(loop->renderer) &&
        !atomic_load(&loop->software)) {
        pel_renderer_destroy(loop->renderer);
        err = PEL_ERR_GPU;
    }
    loop->renderer = err == PEL_OK ? loop->renderer : NULL;
    return err;
}

static void say_device(struct pel_renderloop *loop)
{
    if (!loop->renderer || atomic_load(&loop->software) ||
        !pel_renderer_is_software(loop->renderer)) {
        return;
    }
    loop->options.device = "software";
    pel_loss_note_device(loop, 1);
    pel_error("FRM-008",
              "the device was lost too often, or is gone: drawing on the "
              "processor (%s) until the daemon is started anew",
              loop->devices[1]);
}

/* Tries until a renderer stands, or a peer draws what is to be drawn. */
static void stand_again(struct pel_renderloop *loop, bool software)
{
    struct pel_fault fault = { 0 };
    int64_t end_ns = pel_now_ns() + RETURN_NS;
    for (int i = 0; !atomic_load(&loop->stop); i++) {
        bool peers = pel_renderloop_pass_on(loop);
        bool hopes = !software && (peers || pel_now_ns() < end_ns);
        /* Without a software device the other stays the only one. */
        bool processor = !hopes && i % 2 == 0;
        if (try_again(loop, processor, hopes, &fault) == PEL_OK || peers) {
            break;
        }
        if (processor) {
            continue; /* to the other at once */
        }
        if (!hopes) {
            static struct pel_log_limit limit;
            pel_log_limited(&limit, PEL_LOG_ERROR, "FRM-009",
                            "no device draws any more: %s", fault.message);
        }
        wait_ns(loop, RETURN_ASK_NS);
    }
    say_device(loop);
    atomic_store(&loop->standing, loop->renderer != NULL);
    pel_renderloop_progress(loop);
}

static void ask_later(struct pel_renderloop *loop, int64_t ns)
{
    loop->ask_ns = ns < RETURN_SELDOM_NS ? ns : RETURN_SELDOM_NS;
    loop->ask_at_ns = pel_now_ns() + loop->ask_ns;
}

void pel_loss_return(struct pel_renderloop *loop)
{
    bool peers = pel_renderloop_pass_on(loop);
    bool due = !loop->out && pel_now_ns() >= loop->ask_at_ns;
    if (!peers || due) {
        stand_again(loop, loop->out && !atomic_load(&loop->software));
        ask_later(loop, 2 * loop->ask_ns);
    }
    if (!loop->renderer) {
        wait_ns(loop, RETURN_ASK_NS);
    }
}

static void note_loss(struct pel_renderloop *loop, double ms, uint64_t again)
{
    pthread_mutex_lock(&loop->lock);
    struct pel_loss_stats *l = &loop->losses;
    l->losses++;
    l->again += again;
    l->last_ms = ms;
    l->worst_ms = ms > l->worst_ms ? ms : l->worst_ms;
    l->fallen_back = atomic_load(&loop->device_now) == 1;
    pthread_mutex_unlock(&loop->lock);
    /* What is lost for good is told of however lately it came back. */
    static struct pel_log_limit back, gone;
    if (loop->renderer) {
        pel_log_limited(&back, PEL_LOG_WARNING, "FRM-010",
                        "the device was lost; %s draws after %.0f ms, %llu "
                        "pictures again",
                        loop->devices[atomic_load(&loop->device_now)], ms,
                        (unsigned long long)again);
    } else {
        pel_log_limited(&gone, PEL_LOG_WARNING, "FRM-012",
                        "device %u (%s) was lost%s; the others draw for it, "
                        "%llu pictures again",
                        loop->device, loop->devices[0],
                        loop->out ? " too often to be trusted" : "",
                        (unsigned long long)again);
    }
}

void pel_loss_recover(struct pel_renderloop *loop)
{
    int64_t begun_ns = pel_now_ns();
    uint64_t before = loop->put_again;
    bool often = lost_often(loop, begun_ns);
    take_back(loop);
    atomic_store(&loop->standing, false);
    bool peers = pel_renderloop_pass_on(loop);
    if (wait_unused(loop)) {
        pel_renderer_leave(loop->renderer, rest, loop);
    } /* else it is left: its memory is still read */
    loop->renderer = NULL;
    if (loop->options.lose_for_good) {
        loop->options.device = WITHDRAWN;
    }
    loop->out = often && peers;
    if (!loop->out) {
        stand_again(loop, often && !atomic_load(&loop->software));
        ask_later(loop, RETURN_ASK_NS);
    }
    note_loss(loop, (double)(pel_now_ns() - begun_ns) * 1e-6,
              loop->put_again - before);
}

/* Whether it is lost, or there is none. */
bool pel_loss_noticed(struct pel_renderloop *loop)
{
    if (!loop->renderer) {
        return true;
    }
    if (!pel_renderer_lost(loop->renderer)) {
        return false;
    }
    pel_loss_recover(loop);
    return true;
}
