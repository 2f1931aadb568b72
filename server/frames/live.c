#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "frames/core.h"

static struct pel_stream *find_stream(struct pel_frames *frames,
                                      const char *view, int quality)
{
    struct pel_stream *unused = NULL;
    for (int i = 0; i < PEL_MAX_STREAMS; i++) {
        struct pel_stream *stream = &frames->streams[i];
        if (stream->serial == 0) {
            unused = unused ? unused : stream;
        } else if (stream->quality == quality &&
                   strcmp(stream->view, view) == 0) {
            return stream;
        }
    }
    if (unused) {
        *unused = (struct pel_stream){ .quality = quality };
        snprintf(unused->view, sizeof unused->view, "%s", view);
    }
    return unused;
}

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

static enum pel_err check(struct pel_frames *frames, const char *view,
                          int quality, struct pel_fault *fault)
{
    if (frames->stopping) {
        return refuse(frames, fault, PEL_ERR_CONFLICT, "", "",
                      "the daemon is stopping");
    }
    if (quality < 1 || quality > 100) {
        char value[16];
        snprintf(value, sizeof value, "%d", quality);
        return refuse(frames, fault, PEL_ERR_OUT_OF_RANGE, "quality", value,
                      "quality is outside 1 .. 100");
    }
    const struct pel_snapshot *s = pel_scene_snapshot(frames->scene);
    int index = pel_snapshot_find_view(s, view);
    pel_snapshot_unref(s);
    if (index < 0) {
        return refuse(frames, fault, PEL_ERR_NOT_FOUND, "view", view,
                      "no such view");
    }
    return PEL_OK;
}

enum pel_err pel_frames_subscribe(struct pel_frames *frames, const char *view,
                                  int quality, pel_frame_callback on_frame,
                                  void *user, struct pel_subscription **out,
                                  struct pel_fault *fault)
{
    enum pel_err err = check(frames, view, quality, fault);
    if (err != PEL_OK) {
        return err;
    }
    struct pel_stream *stream = find_stream(frames, view, quality);
    if (!stream || frames->subscription_count == PEL_MAX_SUBSCRIPTIONS) {
        return refuse(frames, fault, PEL_ERR_BUSY, "", "",
                      "too many live views are open");
    }
    struct pel_subscription *subscription = calloc(1, sizeof *subscription);
    if (!subscription) {
        return pel_fault_set(fault, PEL_ERR_NO_MEMORY, "out of memory");
    }
    if (stream->serial == 0) {
        stream->serial = ++frames->last_serial;
    }
    stream->subscribers++;
    *subscription = (struct pel_subscription){
        .frames = frames,
        .stream = stream,
        .on_frame = on_frame,
        .user = user,
        .next = frames->subscriptions,
    };
    frames->subscriptions = subscription;
    frames->subscription_count++;
    *out = subscription;
    pel_schedule_live(frames);
    return PEL_OK;
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

static void detach(struct pel_subscription *subscription)
{
    struct pel_stream *stream = subscription->stream;
    if (stream) {
        subscription->stream = NULL;
        subscription->frames->subscription_count--;
        if (--stream->subscribers == 0) {
            stream->serial = 0;
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

void pel_live_deliver(struct pel_frames *frames, uint32_t serial,
                      enum pel_err err, struct pel_frame *frame)
{
    struct pel_fault fault;
    pel_fault_set(&fault, err, "the frame could not be drawn: %s",
                  pel_err_name(err));
    frames->calling++;
    /* A subscription made by a callback goes to the front: not called yet. */
    for (struct pel_subscription *s = frames->subscriptions; s; s = s->next) {
        if (!s->dead && s->stream && s->stream->serial == serial) {
            s->on_frame(s->user, err, err == PEL_OK ? NULL : &fault,
                        err == PEL_OK ? frame : NULL);
        }
    }
    frames->calling--;
    sweep(frames);
}

void pel_live_check(struct pel_frames *frames, const struct pel_snapshot *s)
{
    bool ended = false;
    frames->calling++;
    for (struct pel_subscription *p = frames->subscriptions; p; p = p->next) {
        if (p->dead || !p->stream ||
            pel_snapshot_find_view(s, p->stream->view) >= 0) {
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
