#include "net/tsviewer.h"

#include <string.h>

#include <glib.h>

#include "encode/ts.h"

#define MAX_WAITING 6

struct pel_ts_viewer {
    struct pel_subscription *subscription;
    struct pel_ts_stats *stats;
    void (*wake)(void *user);
    void *user;
    struct pel_ts ts;
    struct pel_bytes waiting[MAX_WAITING];
    unsigned first, count;
    size_t offset; /* taken of the first */
    bool starved, idle, over;
};

static void add(struct pel_ts_viewer *self, const struct pel_frame *frame)
{
    unsigned at = (self->first + self->count) % MAX_WAITING;
    /* The same clock in every view: those of one frame have one time. */
    if (pel_ts_write(&self->ts, frame->data, frame->size, frame->requested_ns,
                     frame->key, &self->waiting[at]) == PEL_OK) {
        self->count++;
        self->stats->sent++;
    } else {
        pel_frames_resync(self->subscription, false);
    }
}

static void on_frame(void *user, enum pel_err err,
                     const struct pel_fault *fault, struct pel_frame *frame)
{
    struct pel_ts_viewer *self = user;
    (void)fault;
    if (err == PEL_ERR_NOT_FOUND) {
        self->over = true;
    } else if (err != PEL_OK) {
        return;
    } else if (self->count == MAX_WAITING) {
        self->starved = true;
        self->stats->starved++;
        pel_frames_pause(self->subscription);
        return;
    } else {
        add(self, frame);
    }
    if (self->idle) {
        self->idle = false;
        self->wake(self->user);
    }
}

enum pel_err pel_ts_viewer_create(struct pel_frames *frames, const char *view,
                                  const struct pel_profile *profile,
                                  struct pel_ts_stats *stats,
                                  void (*wake)(void *user), void *user,
                                  struct pel_ts_viewer **out,
                                  struct pel_fault *fault)
{
    struct pel_ts_viewer *self = g_new0(struct pel_ts_viewer, 1);
    self->stats = stats;
    self->wake = wake;
    self->user = user;
    enum pel_err err = pel_frames_open(frames, view, profile, on_frame, self,
                                       &self->subscription, fault);
    if (err != PEL_OK) {
        g_free(self);
        return err;
    }
    stats->viewers++;
    *out = self;
    return PEL_OK;
}

static void drop_first(struct pel_ts_viewer *self)
{
    pel_bytes_finish(&self->waiting[self->first]);
    self->first = (self->first + 1) % MAX_WAITING;
    self->count--;
    self->offset = 0;
}

void pel_ts_viewer_destroy(struct pel_ts_viewer *self)
{
    if (self) {
        pel_frames_unsubscribe(self->subscription);
        while (self->count > 0) {
            drop_first(self);
        }
        self->stats->viewers--;
        g_free(self);
    }
}

ssize_t pel_ts_viewer_read(struct pel_ts_viewer *self, char *out, size_t size)
{
    size_t done = 0;
    while (done < size && self->count > 0) {
        const struct pel_bytes *bytes = &self->waiting[self->first];
        size_t n = MIN(size - done, bytes->size - self->offset);
        memcpy(out + done, bytes->data + self->offset, n);
        done += n;
        self->offset += n;
        if (self->offset == bytes->size) {
            drop_first(self);
        }
    }
    if (self->starved && self->count == 0) {
        self->starved = false;
        pel_frames_resync(self->subscription, false);
    }
    self->stats->bytes += done;
    self->idle = done == 0 && !self->over;
    return done == 0 && self->over ? -1 : (ssize_t)done;
}
