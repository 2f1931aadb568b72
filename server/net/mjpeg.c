#include "net/mjpeg.h"

#include <stdio.h>
#include <string.h>
#include <time.h>

#include <glib.h>

#include "base/clock.h"
#include "json.h"

#define TAIL "\r\n--pelagos\r\n"

struct pel_viewer {
    struct pel_subscription *subscription;
    struct pel_mjpeg_stats *stats;
    void (*wake)(void *user);
    void *user;
    struct pel_frame *pending, *current;
    char head[640];
    size_t head_size, offset;
    int64_t interval_ns, due_ns; /* of the next picture wanted */
    unsigned missed;             /* pictures passed over for newer ones */
    bool begun, idle, over;
};

/* Frames come at their own rate; the nearest ones to the wanted rhythm are
 * taken, so that 10 of 30 fps are every third. */
static bool due(struct pel_viewer *self)
{
    if (self->interval_ns == 0) {
        return true;
    }
    int64_t now = pel_now_ns();
    if (now < self->due_ns - self->interval_ns / 8) {
        return false;
    }
    self->due_ns = MAX(self->due_ns + self->interval_ns, now);
    return true;
}

static void on_frame(void *user, enum pel_err err,
                     const struct pel_fault *fault, struct pel_frame *frame)
{
    (void)fault;
    struct pel_viewer *self = user;
    if (err != PEL_OK) {
        self->over = true;
    } else if (!due(self)) {
        return;
    } else {
        self->stats->dropped += self->pending != NULL;
        self->missed += self->pending != NULL;
        pel_frame_unref(self->pending);
        self->pending = pel_frame_ref(frame);
    }
    if (self->idle) {
        self->idle = false;
        self->wake(self->user);
    }
}

enum pel_err pel_viewer_create(struct pel_frames *frames, const char *view,
                               int quality, double fps,
                               const struct pel_who *who,
                               struct pel_mjpeg_stats *stats,
                               void (*wake)(void *user), void *user,
                               struct pel_viewer **out, struct pel_fault *fault)
{
    struct pel_viewer *self = g_new0(struct pel_viewer, 1);
    self->stats = stats;
    self->wake = wake;
    self->user = user;
    self->interval_ns = fps > 0.0 ? (int64_t)(1e9 / fps) : 0;
    const struct pel_profile profile = { .quality = quality, .who = *who };
    enum pel_err err = pel_frames_open(frames, view, &profile, on_frame, self,
                                       &self->subscription, fault);
    if (err != PEL_OK) {
        g_free(self);
        return err;
    }
    stats->viewers++;
    *out = self;
    return PEL_OK;
}

void pel_viewer_destroy(struct pel_viewer *self)
{
    if (self) {
        pel_frames_unsubscribe(self->subscription);
        pel_frame_unref(self->pending);
        pel_frame_unref(self->current);
        self->stats->viewers--;
        g_free(self);
    }
}

/* Microseconds since 1970 when the frame was begun. */
static int64_t stamp_us(const struct pel_frame *frame)
{
    return (pel_unix_ns() - (pel_now_ns() - frame->requested_ns)) / 1000;
}

/* The boundary follows each picture at once: browsers show a part when they
 * see the next boundary. */
static void begin_picture(struct pel_viewer *self)
{
    self->current = self->pending;
    self->pending = NULL;
    self->offset = 0;
    char stale[PEL_STALE_TEXT], time[32];
    int64_t present_us =
        pel_frame_present_us(self->current, pel_now_ns(), pel_unix_ns());
    pel_json_number(self->current->time_s, time);
    int n = snprintf(
        self->head, sizeof self->head,
        "%sContent-Type: image/jpeg\r\nContent-Length: %zu\r\n"
        "X-Pelagos-Frame: %llu\r\nX-Pelagos-Time: %s\r\n"
        "X-Pelagos-Revision: %llu\r\nX-Pelagos-Stale: %s\r\n%s"
        "X-Pelagos-Host-Frame: %u\r\nX-Pelagos-Drawn: %ux%u\r\n"
        "X-Pelagos-Present: %lld.%06lld\r\nX-Pelagos-Stamp: %lld\r\n"
        "X-Timestamp: %.6f\r\nX-Pelagos-Missed: %u\r\n\r\n",
        self->begun ? "" : "--pelagos\r\n", self->current->size,
        (unsigned long long)self->current->number, time,
        (unsigned long long)self->current->revision,
        pel_stale_text(self->current->stale, stale),
        self->current->in_ground ? "X-Pelagos-Ground: inside\r\n" : "",
        self->current->host_frame, self->current->drawn_width,
        self->current->drawn_height, (long long)(present_us / 1000000),
        (long long)(present_us % 1000000), (long long)stamp_us(self->current),
        1e-6 * (double)stamp_us(self->current), self->missed);
    self->head_size = (size_t)n;
    self->begun = true;
}

/* Copies from one of the three parts of a picture, `start` being where the
 * part begins; returns how much. */
static size_t copy_part(const struct pel_viewer *self, const void *part,
                        size_t start, size_t length, char *out, size_t size)
{
    if (self->offset < start || self->offset >= start + length) {
        return 0;
    }
    size_t n = MIN(start + length - self->offset, size);
    memcpy(out, (const char *)part + (self->offset - start), n);
    return n;
}

ssize_t pel_viewer_read(struct pel_viewer *self, char *out, size_t size)
{
    if (!self->current && !self->pending) {
        self->idle = !self->over;
        return self->over ? -1 : 0;
    }
    if (!self->current) {
        begin_picture(self);
    }
    const struct pel_frame *frame = self->current;
    size_t tail = self->head_size + frame->size;
    size_t total = tail + strlen(TAIL);
    size_t done = 0;
    while (done < size && self->offset < total) {
        size_t n = copy_part(self, self->head, 0, self->head_size, out + done,
                             size - done);
        n = n ? n
              : copy_part(self, frame->data, self->head_size, frame->size,
                          out + done, size - done);
        n = n ? n
              : copy_part(self, TAIL, tail, strlen(TAIL), out + done,
                          size - done);
        self->offset += n;
        done += n;
    }
    if (self->offset == total) {
        pel_frame_unref(self->current);
        self->current = NULL;
        self->stats->sent++;
    }
    self->stats->bytes += done;
    return (ssize_t)done;
}
