#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "frames/core.h"

/* Between two key frames of a stream: that newcomers make, that those who fell
 * behind make. */
#define JOIN_KEY_NS 200000000LL
#define RESYNC_KEY_NS 1000000000LL
/* Pictures of an H.264 stream under way: one being drawn, one being encoded,
 * one to spare. More would only be late. */
#define MAX_UNDER_WAY 3

/* --- streams ------------------------------------------------------------- */

static bool same_profile(const struct pel_profile *a,
                         const struct pel_profile *b)
{
    return a->codec == b->codec && a->width == b->width &&
           a->height == b->height &&
           (a->codec != PEL_CODEC_PICTURE ? a->kbps == b->kbps
                                          : a->quality == b->quality);
}

static struct pel_stream *find_stream(struct pel_frames *frames,
                                      const char *view,
                                      const struct pel_profile *profile)
{
    for (int i = 0; i < PEL_MAX_STREAMS; i++) {
        struct pel_stream *stream = &frames->streams[i];
        if (stream->serial != 0 && same_profile(&stream->profile, profile) &&
            strcmp(stream->view, view) == 0) {
            return stream;
        }
    }
    return NULL;
}

/* NULL: no room, or no memory. */
static struct pel_stream *make_stream(struct pel_frames *frames,
                                      const char *view,
                                      const struct pel_profile *profile)
{
    struct pel_stream *stream = NULL;
    for (int i = 0; !stream && i < PEL_MAX_STREAMS; i++) {
        stream = frames->streams[i].serial == 0 ? &frames->streams[i] : NULL;
    }
    if (!stream) {
        return NULL;
    }
    *stream = (struct pel_stream){ .profile = *profile };
    snprintf(stream->view, sizeof stream->view, "%s", view);
    if (profile->codec != PEL_CODEC_PICTURE) {
        struct pel_video_config config = {
            .vp8 = profile->codec == PEL_CODEC_VP8,
            .encoder = frames->video_encoder,
            .fps = frames->max_fps,
            .cancel = pel_encoder_pool_cancel(frames->pool),
        };
        stream->track = pel_track_create(&config);
        if (!stream->track) {
            return NULL;
        }
    }
    stream->opened_ns = pel_now_ns();
    stream->serial = ++frames->last_serial;
    return stream;
}

static void end_stream(struct pel_frames *frames, struct pel_stream *stream)
{
    if (stream->track) {
        pel_encoder_pool_push_track(frames->pool, stream->track, stream->low);
    }
    *stream = (struct pel_stream){ 0 };
}

/* A key frame from `wait` after the last one on, or sooner if that was
 * wanted already. */
static void want_key(struct pel_stream *stream, int64_t wait)
{
    int64_t now = pel_now_ns();
    int64_t due = stream->key_ns ? stream->key_ns + wait : now;
    due = due > now ? due : now;
    if (stream->key_due_ns == 0 || due < stream->key_due_ns) {
        stream->key_due_ns = due;
    }
}

/* --- refusals ------------------------------------------------------------ */

static enum pel_err refuse(struct pel_frames *frames, struct pel_fault *fault,
                           enum pel_err code, const char *path,
                           const char *value, const char *message)
{
    frames->stats.requests_refused++;
    pel_fault_set(fault, code, "%s", message);
    if (fault) {
        snprintf(fault->path, sizeof fault->path, "%s", path);
        snprintf(fault->value, sizeof fault->value, "%s", value);
    }
    return code;
}

/* Whether a number of a profile is within its range; 0 may stand for none. */
static enum pel_err check_number(struct pel_frames *frames, const char *name,
                                 unsigned value, bool or_zero, unsigned minimum,
                                 unsigned maximum, struct pel_fault *fault)
{
    char text[16], message[96];
    if ((or_zero && value == 0) || (value >= minimum && value <= maximum)) {
        return PEL_OK;
    }
    snprintf(text, sizeof text, "%d", (int)value);
    snprintf(message, sizeof message, "%s is outside %u .. %u", name, minimum,
             maximum);
    refuse(frames, fault, PEL_ERR_OUT_OF_RANGE, name, text, message);
    if (fault) {
        fault->minimum = minimum;
        fault->maximum = maximum;
    }
    return PEL_ERR_OUT_OF_RANGE;
}

static enum pel_err check_profile(struct pel_frames *frames,
                                  const struct pel_profile *p,
                                  struct pel_fault *fault)
{
    enum pel_err err =
        check_number(frames, "width", p->width, true, PEL_VIDEO_MIN_SIZE,
                     PEL_VIDEO_MAX_SIZE, fault);
    if (err == PEL_OK) {
        err = check_number(frames, "height", p->height, true,
                           PEL_VIDEO_MIN_SIZE, PEL_VIDEO_MAX_SIZE, fault);
    }
    if (err == PEL_OK && p->codec != PEL_CODEC_PICTURE) {
        err = check_number(frames, "bitrate", p->kbps, true, PEL_VIDEO_MIN_KBPS,
                           PEL_VIDEO_MAX_KBPS, fault);
    } else if (err == PEL_OK) {
        err = check_number(frames, "quality", (unsigned)p->quality, false, 1,
                           100, fault);
    }
    return err;
}

static enum pel_err check(struct pel_frames *frames, const char *view,
                          const struct pel_profile *profile,
                          struct pel_fault *fault)
{
    if (frames->stopping) {
        return refuse(frames, fault, PEL_ERR_CONFLICT, "", "",
                      "the daemon is stopping");
    }
    const struct pel_snapshot *s = pel_shown_snapshot(frames);
    int index = pel_snapshot_find_view(s, view);
    pel_snapshot_unref(s);
    if (index < 0) {
        char text[96];
        snprintf(text, sizeof text, "there is no view called \"%.64s\"", view);
        return refuse(frames, fault, PEL_ERR_NOT_FOUND, "view", view, text);
    }
    return check_profile(frames, profile, fault);
}

/* --- what there may be --------------------------------------------------- */

uint64_t pel_live_pixels(const struct pel_snapshot *s, const char *view,
                         const struct pel_profile *profile)
{
    int index = pel_snapshot_find_view(s, view);
    const struct pel_view_state *v = index >= 0 ? &s->views[index] : NULL;
    uint64_t width = profile->width ? profile->width : v ? v->width : 0;
    return width * (profile->height ? profile->height : v ? v->height : 0);
}

/* A stream counts in the share of the highest who watches it. */
void pel_live_owners(const struct pel_frames *frames,
                     struct pel_who owners[PEL_MAX_STREAMS])
{
    for (int i = 0; i < PEL_MAX_STREAMS; i++) {
        owners[i] = (struct pel_who){ PEL_RANK_NOBODY, 0 };
    }
    for (const struct pel_subscription *s = frames->subscriptions; s;
         s = s->next) {
        struct pel_who *owner =
            s->stream && !s->dead ? &owners[s->stream - frames->streams] : NULL;
        if (owner && s->who.rank <= owner->rank) {
            *owner = s->who;
        }
    }
}

/* Streams and pixels of all but `instead`. */
struct budget {
    struct pel_taken streams, pixels;
};

static void add_up(struct pel_frames *frames, const struct pel_who *asker,
                   const struct pel_stream *instead, struct budget *out)
{
    struct pel_who owners[PEL_MAX_STREAMS];
    const struct pel_snapshot *s = pel_shown_snapshot(frames);
    *out = (struct budget){ .streams = { { 0 }, 0 } };
    pel_live_owners(frames, owners);
    for (int i = 0; i < PEL_MAX_STREAMS; i++) {
        const struct pel_stream *stream = &frames->streams[i];
        if (stream->serial && stream != instead) {
            pel_taken_add(&out->streams, asker, &owners[i], 1);
            pel_taken_add(&out->pixels, asker, &owners[i],
                          pel_live_pixels(s, stream->view, &stream->profile));
        }
    }
    pel_snapshot_unref(s);
}

static double all_of(const struct pel_taken *taken)
{
    double all = 0.0;
    for (int rank = 0; rank < PEL_RANKS; rank++) {
        all += (double)taken->of_rank[rank];
    }
    return all;
}

static void end_with(struct pel_frames *frames, uint32_t serial,
                     const struct pel_fault *fault);

/* Ends the newest of the lowest rank below the asker's; false: there is none.
 */
static bool make_room(struct pel_frames *frames, const struct pel_who *asker,
                      const struct pel_stream *instead)
{
    struct pel_who owners[PEL_MAX_STREAMS];
    const struct pel_stream *last = NULL;
    enum pel_rank lowest = asker->rank;
    pel_live_owners(frames, owners);
    for (int i = 0; i < PEL_MAX_STREAMS; i++) {
        const struct pel_stream *stream = &frames->streams[i];
        if (stream->serial && stream != instead && stream->subscribers > 0 &&
            owners[i].rank > asker->rank &&
            (owners[i].rank > lowest || (last && owners[i].rank == lowest &&
                                         stream->serial > last->serial))) {
            last = stream;
            lowest = owners[i].rank;
        }
    }
    if (last) {
        struct pel_fault fault;
        pel_fault_set(&fault, PEL_ERR_NOT_FOUND,
                      "the live view ended: a client of a higher role took "
                      "its place; ask again later");
        end_with(frames, last->serial, &fault);
    }
    return last != NULL;
}

/* Whether there may be one more stream, in the place of `instead` if that is
 * not NULL: an encoder takes some 10 bytes a pixel for as long as it lives. */
static enum pel_err check_budget(struct pel_frames *frames, const char *view,
                                 const struct pel_profile *profile,
                                 const struct pel_stream *instead,
                                 struct pel_fault *fault)
{
    const struct pel_who *who = &profile->who;
    const struct pel_snapshot *s = pel_shown_snapshot(frames);
    uint64_t asked = pel_live_pixels(s, view, profile);
    pel_snapshot_unref(s);
    struct budget has;
    enum pel_share_answer streams, pixels;
    do {
        add_up(frames, who, instead, &has);
        streams = pel_share_ask(PEL_MAX_STREAMS, &has.streams, who, 1);
        pixels = pel_share_ask(PEL_LIVE_PIXELS, &has.pixels, who, asked);
    } while ((streams || pixels) && asked <= PEL_LIVE_PIXELS &&
             who->rank < PEL_RANK_WATCH && make_room(frames, who, instead));
    char message[256];
    if (streams) {
        snprintf(message, sizeof message,
                 "all %d live views %s are taken: watch a view in a profile "
                 "that somebody watches already",
                 (int)(streams == PEL_SHARE_TOKEN_FULL
                           ? pel_share_of_token(PEL_MAX_STREAMS, who->rank)
                           : pel_share_of_rank(PEL_MAX_STREAMS, who->rank)),
                 pel_share_words(streams, who->rank));
    } else if (pixels) {
        snprintf(
            message, sizeof message,
            "live views %s may have %.0f million pixels together, %.1f "
            "are taken by all, and this has %.1f: ask for a smaller one",
            pel_share_words(pixels, who->rank),
            1e-6 *
                (double)(pixels == PEL_SHARE_TOKEN_FULL
                             ? pel_share_of_token(PEL_LIVE_PIXELS, who->rank)
                             : pel_share_of_rank(PEL_LIVE_PIXELS, who->rank)),
            all_of(&has.pixels) * 1e-6, (double)asked * 1e-6);
    } else {
        return PEL_OK;
    }
    return refuse(frames, fault, PEL_ERR_BUSY, "", "", message);
}

/* One more subscription, of a stream that there is or not. */
static enum pel_err check_subscriptions(struct pel_frames *frames,
                                        const struct pel_who *who,
                                        struct pel_fault *fault)
{
    struct pel_taken taken = { { 0 }, 0 };
    for (const struct pel_subscription *s = frames->subscriptions; s;
         s = s->next) {
        if (s->stream && !s->dead) {
            pel_taken_add(&taken, who, &s->who, 1);
        }
    }
    return pel_share_ask(PEL_MAX_SUBSCRIPTIONS, &taken, who, 1)
               ? refuse(frames, fault, PEL_ERR_BUSY, "", "",
                        "too many live views are open")
               : PEL_OK;
}

/* --- subscriptions ------------------------------------------------------- */

static void attach(struct pel_subscription *subscription,
                   struct pel_stream *stream)
{
    struct pel_frames *frames = subscription->frames;
    bool video = stream->profile.codec != PEL_CODEC_PICTURE;
    subscription->stream = stream;
    subscription->flow = video ? PEL_FLOW_AWAITS_KEY : PEL_FLOW_RUNS;
    stream->subscribers++;
    frames->subscription_count++;
    frames->running_count++;
    if (video) {
        want_key(stream, JOIN_KEY_NS);
    }
}

static void detach(struct pel_subscription *subscription)
{
    struct pel_frames *frames = subscription->frames;
    struct pel_stream *stream = subscription->stream;
    if (stream) {
        bool paused = subscription->flow == PEL_FLOW_PAUSED;
        subscription->stream = NULL;
        frames->subscription_count--;
        frames->running_count -= !paused;
        stream->paused -= paused;
        if (--stream->subscribers == 0) {
            end_stream(frames, stream);
        }
    }
}

enum pel_err pel_frames_open(struct pel_frames *frames, const char *view,
                             const struct pel_profile *profile,
                             pel_frame_callback on_frame, void *user,
                             struct pel_subscription **out,
                             struct pel_fault *fault)
{
    enum pel_err err = check(frames, view, profile, fault);
    if (err != PEL_OK) {
        return err;
    }
    err = check_subscriptions(frames, &profile->who, fault);
    struct pel_stream *stream = find_stream(frames, view, profile);
    if (err == PEL_OK && !stream) {
        err = check_budget(frames, view, profile, NULL, fault);
    }
    if (err != PEL_OK) {
        return err;
    }
    if (!stream) {
        stream = make_stream(frames, view, profile);
    }
    if (!stream) {
        return refuse(frames, fault, PEL_ERR_BUSY, "", "",
                      "too many live views are open");
    }
    struct pel_subscription *subscription = calloc(1, sizeof *subscription);
    if (!subscription) {
        if (stream->subscribers == 0) {
            end_stream(frames, stream);
        }
        return pel_fault_set(fault, PEL_ERR_NO_MEMORY, "out of memory");
    }
    *subscription = (struct pel_subscription){
        .frames = frames,
        .who = profile->who,
        .on_frame = on_frame,
        .user = user,
        .next = frames->subscriptions,
    };
    attach(subscription, stream);
    frames->subscriptions = subscription;
    *out = subscription;
    pel_schedule_live(frames);
    return PEL_OK;
}

enum pel_err pel_frames_subscribe(struct pel_frames *frames, const char *view,
                                  int quality, pel_frame_callback on_frame,
                                  void *user, struct pel_subscription **out,
                                  struct pel_fault *fault)
{
    struct pel_profile profile = { .quality = quality };
    return pel_frames_open(frames, view, &profile, on_frame, user, out, fault);
}

enum pel_err pel_frames_change(struct pel_subscription *subscription,
                               const struct pel_profile *profile,
                               struct pel_fault *fault)
{
    struct pel_frames *frames = subscription->frames;
    struct pel_stream *stream = subscription->stream;
    if (!stream) {
        return pel_fault_set(fault, PEL_ERR_CONFLICT, "the view is gone");
    }
    enum pel_err err = check(frames, stream->view, profile, fault);
    if (err != PEL_OK || same_profile(&stream->profile, profile)) {
        return err;
    }
    struct pel_profile rate = stream->profile;
    rate.kbps = profile->kbps;
    struct pel_stream *other = find_stream(frames, stream->view, profile);
    if (!other && stream->subscribers == 1 && same_profile(&rate, profile)) {
        stream->profile = *profile;
        return PEL_OK;
    }
    if (!other) {
        const struct pel_stream *last =
            stream->subscribers == 1 ? stream : NULL;
        err = check_budget(frames, stream->view, profile, last, fault);
        if (err != PEL_OK) {
            return err;
        }
        other = make_stream(frames, stream->view, profile);
    }
    if (!other) {
        return refuse(frames, fault, PEL_ERR_BUSY, "", "",
                      "too many live views are open");
    }
    detach(subscription);
    attach(subscription, other);
    pel_schedule_live(frames);
    return PEL_OK;
}

void pel_frames_claim(struct pel_subscription *subscription,
                      const struct pel_who *who)
{
    subscription->who = *who;
}

void pel_frames_pause(struct pel_subscription *subscription)
{
    struct pel_frames *frames = subscription->frames;
    if (subscription->stream && subscription->flow != PEL_FLOW_PAUSED) {
        subscription->flow = PEL_FLOW_PAUSED;
        subscription->stream->paused++;
        frames->running_count--;
        pel_schedule_live(frames);
    }
}

void pel_frames_resync(struct pel_subscription *subscription, bool urgent)
{
    struct pel_frames *frames = subscription->frames;
    struct pel_stream *stream = subscription->stream;
    if (!stream) {
        return;
    }
    if (subscription->flow == PEL_FLOW_PAUSED) {
        stream->paused--;
        frames->running_count++;
    }
    subscription->flow = PEL_FLOW_RUNS;
    if (stream->profile.codec != PEL_CODEC_PICTURE) {
        subscription->flow = PEL_FLOW_AWAITS_KEY;
        want_key(stream, urgent ? JOIN_KEY_NS : RESYNC_KEY_NS);
    }
    pel_schedule_live(frames);
}

void pel_frames_want_key(struct pel_subscription *subscription, bool urgent)
{
    if (subscription->stream && subscription->stream->track) {
        want_key(subscription->stream, urgent ? JOIN_KEY_NS : RESYNC_KEY_NS);
    }
}

/* Frees what was unsubscribed; not while the list is being walked. */
static void sweep(struct pel_frames *frames)
{
    if (frames->calling > 0) {
        return;
    }
    struct pel_subscription **link = &frames->subscriptions;
    while (*link) {
        struct pel_subscription *subscription = *link;
        if (subscription->dead) {
            *link = subscription->next;
            free(subscription);
        } else {
            link = &subscription->next;
        }
    }
}

void pel_frames_unsubscribe(struct pel_subscription *subscription)
{
    if (subscription) {
        struct pel_frames *frames = subscription->frames;
        detach(subscription);
        subscription->dead = true;
        sweep(frames);
        pel_schedule_live(frames);
    }
}

/* --- frames -------------------------------------------------------------- */

unsigned pel_live_under_way(const struct pel_frames *frames, uint32_t serial)
{
    unsigned count = 0;
    for (int i = 0; i < frames->job_count; i++) {
        const struct pel_job *job = &frames->jobs[i];
        for (size_t k = 0; job->used && k < job->output_count; k++) {
            count +=
                job->outputs[k].stream == serial && !job->outputs[k].delivered;
        }
    }
    return count;
}

/* Whether all who are not paused wait for a key frame. */
static bool all_await_key(const struct pel_frames *frames,
                          const struct pel_stream *stream)
{
    for (const struct pel_subscription *s = frames->subscriptions; s;
         s = s->next) {
        if (s->stream == stream && s->flow == PEL_FLOW_RUNS) {
            return false;
        }
    }
    return true;
}

bool pel_live_output(struct pel_frames *frames, struct pel_stream *stream,
                     struct pel_output *want)
{
    *want = (struct pel_output){ .format = PELAGOS__FRAME_FORMAT__JPEG,
                                 .quality = stream->profile.quality,
                                 .stream = stream->serial,
                                 .low = stream->low };
    if (stream->paused == stream->subscribers) {
        return false;
    }
    if (stream->profile.codec == PEL_CODEC_PICTURE) {
        return true;
    }
    bool due = stream->key_due_ns && pel_now_ns() >= stream->key_due_ns;
    want->track = stream->track;
    want->kbps = stream->profile.kbps;
    want->want_key = due;
    return pel_live_under_way(frames, stream->serial) < MAX_UNDER_WAY &&
           (due || !all_await_key(frames, stream));
}

void pel_live_began(struct pel_stream *stream, bool key)
{
    if (key) {
        stream->key_due_ns = 0;
        stream->key_ns = pel_now_ns();
    }
}

static struct pel_stream *stream_of(struct pel_frames *frames, uint32_t serial)
{
    for (int i = 0; i < PEL_MAX_STREAMS; i++) {
        if (frames->streams[i].serial == serial) {
            return &frames->streams[i];
        }
    }
    return NULL;
}

static bool takes(struct pel_subscription *s, uint32_t serial,
                  const struct pel_frame *frame)
{
    if (s->dead || !s->stream || s->stream->serial != serial ||
        s->flow == PEL_FLOW_PAUSED) {
        return false;
    }
    if (s->flow == PEL_FLOW_AWAITS_KEY && frame) {
        s->flow = frame->key ? PEL_FLOW_RUNS : PEL_FLOW_AWAITS_KEY;
    }
    return s->flow == PEL_FLOW_RUNS || !frame;
}

static void deliver(struct pel_frames *frames, uint32_t serial,
                    enum pel_err err, const struct pel_fault *fault,
                    struct pel_frame *frame)
{
    frames->calling++;
    /* A subscription made by a callback goes to the front: not called yet. */
    for (struct pel_subscription *s = frames->subscriptions; s; s = s->next) {
        if (takes(s, serial, frame)) {
            s->on_frame(s->user, err, fault, frame);
        }
    }
    frames->calling--;
    sweep(frames);
}

/* The stream and its subscriptions are over. */
static void end_with(struct pel_frames *frames, uint32_t serial,
                     const struct pel_fault *fault)
{
    frames->calling++;
    for (struct pel_subscription *s = frames->subscriptions; s; s = s->next) {
        if (!s->dead && s->stream && s->stream->serial == serial) {
            detach(s);
            s->on_frame(s->user, PEL_ERR_NOT_FOUND, fault, NULL);
        }
    }
    frames->calling--;
    sweep(frames);
    pel_schedule_live(frames);
}

void pel_live_deliver(struct pel_frames *frames, uint32_t serial,
                      enum pel_err err, const char *why,
                      struct pel_frame *frame)
{
    struct pel_stream *stream = stream_of(frames, serial);
    struct pel_fault fault;
    if (!stream) {
        return;
    }
    if (err == PEL_OK) {
        deliver(frames, serial, err, NULL, frame);
        return;
    }
    pel_fault_set(&fault, err, "the frame could not be drawn: %s",
                  *why ? why : pel_err_name(err));
    if (stream->track && err == PEL_ERR_NOT_FOUND) {
        snprintf(fault.path, sizeof fault.path, "codec");
        snprintf(fault.message, sizeof fault.message, "%s", why);
        end_with(frames, serial, &fault);
        return;
    }
    if (stream->track) {
        want_key(stream, RESYNC_KEY_NS); /* it may have been this one */
    }
    deliver(frames, serial, err, &fault, NULL);
}

void pel_live_check(struct pel_frames *frames, const struct pel_snapshot *s)
{
    bool ended = false;
    frames->calling++;
    for (struct pel_subscription *p = frames->subscriptions; p; p = p->next) {
        if (p->dead || !p->stream ||
            (s && pel_snapshot_find_view(s, p->stream->view) >= 0)) {
            continue;
        }
        struct pel_fault fault;
        pel_fault_set(&fault, PEL_ERR_NOT_FOUND, "the view was deleted");
        snprintf(fault.path, sizeof fault.path, "view");
        snprintf(fault.value, sizeof fault.value, "%.63s", p->stream->view);
        detach(p);
        p->on_frame(p->user, PEL_ERR_NOT_FOUND, &fault, NULL);
        ended = true;
    }
    frames->calling--;
    sweep(frames);
    if (ended) {
        pel_schedule_live(frames);
    }
}

void pel_live_finish(struct pel_frames *frames)
{
    while (frames->subscriptions) {
        struct pel_subscription *next = frames->subscriptions->next;
        free(frames->subscriptions);
        frames->subscriptions = next;
    }
}

size_t pel_frames_watched(const struct pel_frames *frames,
                          const char *names[PEL_MAX_VIEWS])
{
    size_t count = 0;
    for (const struct pel_subscription *s = frames->subscriptions; s;
         s = s->next) {
        const char *name = s->stream && !s->dead ? s->stream->view : NULL;
        for (size_t i = 0; name && i < count; i++) {
            name = strcmp(names[i], name) == 0 ? NULL : name;
        }
        if (name && count < PEL_MAX_VIEWS) {
            names[count++] = name;
        }
    }
    return count;
}
