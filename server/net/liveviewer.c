#include "net/liveviewer.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <glib.h>

#include "base/clock.h"
#include "encode/video.h"
#include "json.h"
#include "net/websocket.h"

#define MAX_LEVEL 4                     /* each halves the rate */
#define LEVEL_DOWN_NS (1000000000LL)    /* at most one step down in */
#define LEVEL_UP_NS (10 * 1000000000LL) /* without trouble: one step up */
#define LEVEL_UP_MAX_NS (160 * 1000000000LL)
#define CHANGE_NS (500000000LL) /* between two profiles that are asked for */
#define CODE_GONE 4404          /* of close frames: there is nothing to see */

struct pel_live_viewer {
    struct pel_frames *frames;
    struct pel_subscription *subscription;
    struct pel_websocket *ws;
    struct pel_live_stats *stats;
    void (*closed)(void *user);
    void *user;
    struct pel_live_wish wish; /* what the viewer asked for */

    uint64_t in_flight[PEL_WEBSOCKET_MAX_PICTURES]; /* frame numbers, oldest
                                                     * first */
    unsigned in_flight_count;
    bool starved;         /* no credit: nothing is sent */
    bool gap;             /* since the last picture */
    uint64_t last_number; /* 0: none sent */
    uint32_t missed;

    unsigned level; /* how often the rate was halved */
    int64_t level_ns, up_wait_ns, change_ns;
    uint32_t width, height; /* of the last picture */
    uint32_t drawn_width, drawn_height;
    unsigned told_kbps;
};

/* --- bytes --------------------------------------------------------------- */

static void put(uint8_t *at, uint64_t value, size_t bytes)
{
    for (size_t i = 0; i < bytes; i++) {
        at[i] = (uint8_t)(value >> (8 * i));
    }
}

static uint64_t get(const uint8_t *at, size_t bytes)
{
    uint64_t value = 0;
    for (size_t i = 0; i < bytes; i++) {
        value |= (uint64_t)at[i] << (8 * i);
    }
    return value;
}

static uint32_t since_us(int64_t begin_ns, int64_t end_ns)
{
    int64_t us = (end_ns - begin_ns) / 1000;
    return us < 0 ? 0 : us > UINT32_MAX ? UINT32_MAX : (uint32_t)us;
}

void pel_live_header(const struct pel_frame *frame, int64_t now_ns,
                     int64_t unix_ns, uint32_t missed, bool gap,
                     uint8_t out[PEL_LIVE_HEADER])
{
    int64_t stamp_ns = unix_ns - (now_ns - frame->requested_ns);
    uint64_t time;
    memcpy(&time, &frame->time_s, sizeof time);
    memset(out, 0, PEL_LIVE_HEADER);
    out[0] = PEL_LIVE_VERSION;
    out[1] = frame->codec == PEL_CODEC_H264 ? 1 : 2;
    out[2] = (uint8_t)((frame->key ? 1 : 0) | (gap ? 2 : 0) |
                       (frame->stale ? 4 : 0) |
                       (frame->stale & PEL_STALE_POSES ? 8 : 0) |
                       (frame->in_ground ? 16 : 0));
    out[3] = PEL_LIVE_HEADER;
    put(out + 4, frame->width, 2);
    put(out + 6, frame->height, 2);
    put(out + 8, frame->number, 8);
    put(out + 16, time, 8);
    put(out + 24, frame->host_frame, 8);
    put(out + 32, (uint64_t)(stamp_ns / 1000), 8);
    put(out + 40, since_us(frame->requested_ns, frame->drawn_ns), 4);
    put(out + 44, since_us(frame->requested_ns, frame->encoded_ns), 4);
    put(out + 48, since_us(frame->requested_ns, now_ns), 4);
    put(out + 52, missed, 4);
    put(out + 56, frame->revision, 8);
    put(out + 64, (uint64_t)pel_frame_present_us(frame, now_ns, unix_ns), 8);
    put(out + 72, frame->drawn_width, 2);
    put(out + 74, frame->drawn_height, 2);
}

bool pel_live_read(const uint8_t *data, size_t size, struct pel_live_order *out)
{
    *out = (struct pel_live_order){ 0 };
    if (size != PEL_LIVE_MESSAGE || data[0] < PEL_LIVE_ACK ||
        data[0] > PEL_LIVE_TIME) {
        return false;
    }
    out->type = (enum pel_live_message)data[0];
    switch (out->type) {
    case PEL_LIVE_ACK:
        out->frame = get(data + 8, 8);
        break;
    case PEL_LIVE_PROFILE:
        out->profile.quality = data[1];
        out->profile.kbps = (unsigned)get(data + 4, 4);
        out->profile.width = (uint32_t)get(data + 8, 2);
        out->profile.height = (uint32_t)get(data + 10, 2);
        break;
    case PEL_LIVE_TIME:
        out->echo = get(data + 8, 8);
        break;
    case PEL_LIVE_KEY:
        break;
    }
    return true;
}

/* --- telling ------------------------------------------------------------- */

static void send_fault(struct pel_live_viewer *self, const char *type,
                       enum pel_err err, const struct pel_fault *fault)
{
    char *message = pel_json_string(
        fault && *fault->message ? fault->message : pel_err_name(err));
    char *text =
        g_strdup_printf("{\"type\":\"%s\",\"code\":\"%s\",\"message\":%s}",
                        type, pel_err_name(err), message);
    pel_websocket_text(self->ws, text);
    g_free(text);
    free(message);
}

/* Rate that the stream has now [kbit/s]; 0 before the first picture of a
 * stream whose rate comes from its size. */
static unsigned rate_at(const struct pel_live_viewer *self, unsigned level)
{
    unsigned kbps = self->wish.profile.kbps;
    if (kbps == 0 && self->width > 0) {
        kbps = pel_video_kbps(self->width, self->height);
    }
    return MAX(kbps >> level, kbps ? PEL_VIDEO_MIN_KBPS : 0);
}

static void send_stream(struct pel_live_viewer *self)
{
    char text[384];
    bool video = self->wish.profile.codec == PEL_CODEC_H264;
    unsigned kbps = video ? rate_at(self, self->level) : 0;
    snprintf(text, sizeof text,
             "{\"type\":\"stream\",\"view\":\"%s\",\"codec\":\"%s\","
             "\"width\":%u,\"height\":%u,\"drawnWidth\":%u,"
             "\"drawnHeight\":%u,\"bitrate\":%u,\"credit\":%u}",
             self->wish.view, video ? "h264" : "jpeg", self->width,
             self->height, self->drawn_width, self->drawn_height, kbps,
             self->wish.credit);
    self->told_kbps = kbps;
    pel_websocket_text(self->ws, text);
}

/* --- rate ---------------------------------------------------------------- */

/* Level 0 with no wish of the viewer's is the same profile for everybody. */
static void set_level(struct pel_live_viewer *self, unsigned level)
{
    struct pel_profile profile = self->wish.profile;
    profile.kbps = level == 0 ? profile.kbps : rate_at(self, level);
    if (pel_frames_change(self->subscription, &profile, NULL) == PEL_OK) {
        self->level = level;
        self->gap = true; /* until a key frame comes */
        send_stream(self);
    }
}

static void fall_behind(struct pel_live_viewer *self)
{
    int64_t now = pel_now_ns();
    bool video = self->wish.profile.codec == PEL_CODEC_H264;
    self->starved = true;
    self->gap = true;
    self->stats->starved++;
    if (video && self->level < MAX_LEVEL && self->width > 0 &&
        now - self->level_ns > LEVEL_DOWN_NS &&
        rate_at(self, self->level) > PEL_VIDEO_MIN_KBPS) {
        /* Up again too soon: next time later. */
        if (now - self->level_ns < 2 * self->up_wait_ns) {
            self->up_wait_ns = MIN(2 * self->up_wait_ns, LEVEL_UP_MAX_NS);
        }
        self->level_ns = now;
        set_level(self, self->level + 1);
    }
    if (video) {
        pel_frames_pause(self->subscription);
    }
}

static void recover(struct pel_live_viewer *self)
{
    int64_t now = pel_now_ns();
    if (self->level > 0 && now - self->level_ns > self->up_wait_ns) {
        self->level_ns = now;
        set_level(self, self->level - 1);
    }
}

/* --- pictures ------------------------------------------------------------ */

/* How many frames were left out just before this one. */
static uint64_t left_out(const struct pel_live_viewer *self, uint64_t number)
{
    bool gap = self->last_number && self->gap;
    return gap ? number - self->last_number - 1 : 0;
}

static void send_picture(struct pel_live_viewer *self, struct pel_frame *frame)
{
    uint8_t header[PEL_LIVE_HEADER];
    bool first = self->last_number == 0;
    bool resized = frame->width != self->width ||
                   frame->height != self->height ||
                   frame->drawn_width != self->drawn_width ||
                   frame->drawn_height != self->drawn_height;
    self->width = frame->width;
    self->height = frame->height;
    self->drawn_width = frame->drawn_width;
    self->drawn_height = frame->drawn_height;
    uint64_t lost = left_out(self, frame->number);
    uint32_t missed = self->missed + (uint32_t)MIN(lost, UINT32_MAX);
    pel_live_header(frame, pel_now_ns(), pel_unix_ns(), missed, lost > 0,
                    header);
    if (first || resized) {
        send_stream(self);
    }
    if (pel_websocket_picture(self->ws, header, sizeof header, frame)) {
        self->in_flight[self->in_flight_count++] = frame->number;
        self->gap = false;
        self->last_number = frame->number;
        self->missed = missed;
        self->stats->skipped += lost;
        self->stats->sent++;
        self->stats->bytes += sizeof header + frame->size;
    } else {
        fall_behind(self);
    }
}

/* Of the stream that the viewer has just changed to, and no newer than what
 * the one before has shown. */
static void skip_old(struct pel_live_viewer *self)
{
    self->gap = true;
    if (self->wish.profile.codec == PEL_CODEC_H264) {
        pel_frames_resync(self->subscription, false);
    }
}

static void on_frame(void *user, enum pel_err err,
                     const struct pel_fault *fault, struct pel_frame *frame)
{
    struct pel_live_viewer *self = user;
    if (err == PEL_ERR_NOT_FOUND) {
        send_fault(self, "end", err, fault);
        pel_websocket_close(self->ws, CODE_GONE, "there is nothing to see");
    } else if (err != PEL_OK) {
        self->gap = true;
    } else if (frame->number <= self->last_number) {
        skip_old(self);
    } else if (self->in_flight_count >= self->wish.credit) {
        fall_behind(self);
    } else {
        send_picture(self, frame);
    }
}

/* --- the viewer's messages ----------------------------------------------- */

static void acknowledge(struct pel_live_viewer *self, uint64_t number)
{
    unsigned done = 0;
    while (done < self->in_flight_count && self->in_flight[done] <= number) {
        done++;
    }
    self->in_flight_count -= done;
    memmove(self->in_flight, self->in_flight + done,
            self->in_flight_count * sizeof *self->in_flight);
    if (self->starved && self->in_flight_count < (self->wish.credit + 1) / 2) {
        self->starved = false;
        pel_frames_resync(self->subscription, false);
    } else if (!self->starved && done > 0) {
        recover(self);
    }
}

static void change(struct pel_live_viewer *self, const struct pel_profile *wish)
{
    struct pel_fault fault;
    struct pel_profile profile = self->wish.profile;
    int64_t now = pel_now_ns();
    profile.width = wish->width;
    profile.height = wish->height;
    profile.kbps = wish->kbps;
    profile.quality = wish->quality ? wish->quality : profile.quality;
    enum pel_err err = PEL_ERR_BUSY;
    if (now - self->change_ns < CHANGE_NS) {
        pel_fault_set(&fault, err, "at most two profiles a second");
    } else {
        self->change_ns = now;
        err = pel_frames_change(self->subscription, &profile, &fault);
    }
    if (err != PEL_OK) {
        send_fault(self, "error", err, &fault);
        return;
    }
    if (self->starved && profile.codec == PEL_CODEC_H264) {
        pel_frames_pause(self->subscription); /* as it was */
    }
    self->wish.profile = profile;
    self->gap = true;
    self->level = 0;
    self->level_ns = now;
    send_stream(self);
}

static void send_time(struct pel_live_viewer *self, uint64_t echo)
{
    char text[128];
    snprintf(text, sizeof text,
             "{\"type\":\"time\",\"echo\":\"%016llx\",\"unix\":%.6f}",
             (unsigned long long)echo, (double)pel_unix_ns() * 1e-9);
    pel_websocket_text(self->ws, text);
}

static void on_message(void *user, const uint8_t *data, size_t size)
{
    struct pel_live_viewer *self = user;
    struct pel_live_order order;
    if (!pel_live_read(data, size, &order)) {
        self->stats->malformed++;
        pel_websocket_close(self->ws, 1008, "a message that is not known");
        return;
    }
    if (!self->subscription) {
        return;
    }
    switch (order.type) {
    case PEL_LIVE_ACK:
        acknowledge(self, order.frame);
        break;
    case PEL_LIVE_KEY:
        if (!self->starved) {
            self->gap = true;
            pel_frames_resync(self->subscription, false);
        }
        break;
    case PEL_LIVE_PROFILE:
        change(self, &order.profile);
        break;
    case PEL_LIVE_TIME:
        send_time(self, order.echo);
        break;
    }
}

static void on_broken(void *user)
{
    struct pel_live_viewer *self = user;
    self->stats->malformed++;
}

static void on_closed(void *user)
{
    struct pel_live_viewer *self = user;
    self->closed(self->user);
}

/* --- life ---------------------------------------------------------------- */

struct pel_live_viewer *pel_live_viewer_create(
    struct pel_frames *frames, const struct pel_live_wish *wish, int fd,
    const char *early, size_t early_size, struct pel_live_stats *stats,
    void (*closed)(void *user), void *user, struct pel_fault *fault)
{
    static const struct pel_websocket_handlers handlers = {
        .on_message = on_message,
        .on_broken = on_broken,
        .on_closed = on_closed,
    };
    struct pel_live_viewer *self = g_new0(struct pel_live_viewer, 1);
    self->frames = frames;
    self->stats = stats;
    self->closed = closed;
    self->user = user;
    self->wish = *wish;
    self->up_wait_ns = LEVEL_UP_NS;
    self->ws = pel_websocket_create(fd, early, early_size, &handlers, self);
    if (!self->ws) {
        g_free(self);
        pel_fault_set(fault, PEL_ERR_NO_MEMORY, "out of memory");
        return NULL;
    }
    stats->viewers++;
    enum pel_err err =
        pel_frames_open(frames, wish->view, &wish->profile, on_frame, self,
                        &self->subscription, fault);
    if (err != PEL_OK) {
        send_fault(self, "end", err, fault);
        pel_websocket_close(self->ws, err == PEL_ERR_BUSY ? 1013 : CODE_GONE,
                            pel_err_name(err));
    }
    return self;
}

void pel_live_viewer_destroy(struct pel_live_viewer *self)
{
    if (self) {
        pel_frames_unsubscribe(self->subscription);
        pel_websocket_destroy(self->ws);
        self->stats->viewers--;
        g_free(self);
    }
}

void pel_live_collect(const struct pel_live_stats *stats,
                      struct pel_metrics_page *page)
{
    const struct {
        const char *name, *help;
        uint64_t value;
    } counters[] = {
        { "pelagos_live_frames_sent_total", "Pictures sent over WebSockets.",
          stats->sent },
        { "pelagos_live_sent_bytes_total", "Bytes sent over WebSockets.",
          stats->bytes },
        { "pelagos_live_frames_skipped_total",
          "Pictures that slow WebSocket viewers were not sent.",
          stats->skipped },
        { "pelagos_live_starved_total",
          "Times that a WebSocket viewer fell behind.", stats->starved },
    };
    pel_metric(page, "pelagos_live_viewers", PEL_METRIC_GAUGE,
               "WebSocket viewers.", NULL, stats->viewers);
    for (size_t i = 0; i < G_N_ELEMENTS(counters); i++) {
        pel_metric(page, counters[i].name, PEL_METRIC_COUNTER, counters[i].help,
                   NULL, (double)counters[i].value);
    }
    pel_metric(page, "pelagos_malformed_total", PEL_METRIC_COUNTER,
               "Messages that could not be read.", "input=\"live\"",
               (double)stats->malformed);
}
