#include "net/rtspstream.h"

#include <stdio.h>

#include "base/clock.h"
#include "base/watch.h"
#include "net/gstframe.h"

#define MAX_QUEUED 8 /* pictures that wait in a client's appsrc */
#define KEY_NS 2000000000LL
/* A key frame that is forced with PLAY itself is lost on the way: the client's
 * transports are only being set up. */
#define PLAY_KEY_MS 60

struct pel_rtsp_stream {
    atomic_int references; /* the creator's, and each call's under way */
    struct pel_rtsp_hub *hub;
    char view[PEL_NAME_SIZE];
    struct pel_who who;
    GstAppSrc *source;
    /* Control thread: */
    struct pel_subscription *subscription;
    struct pel_rtsp_stream *next;
    bool open;
    int64_t key_ns; /* the last key frame */
};

/* --- references ---------------------------------------------------------- */

struct pel_rtsp_hub *pel_rtsp_hub_create(struct pel_frames *frames)
{
    struct pel_rtsp_hub *hub = g_new0(struct pel_rtsp_hub, 1);
    atomic_init(&hub->references, 1);
    hub->frames = frames;
    return hub;
}

struct pel_rtsp_hub *pel_rtsp_hub_ref(struct pel_rtsp_hub *hub)
{
    atomic_fetch_add(&hub->references, 1);
    return hub;
}

void pel_rtsp_hub_unref(struct pel_rtsp_hub *hub)
{
    if (hub && atomic_fetch_sub(&hub->references, 1) == 1) {
        g_free(hub);
    }
}

static void stream_unref(gpointer pointer)
{
    struct pel_rtsp_stream *stream = pointer;
    if (atomic_fetch_sub(&stream->references, 1) == 1) {
        gst_object_unref(stream->source);
        pel_rtsp_hub_unref(stream->hub);
        g_free(stream);
    }
}

/* Has the control thread call it; in order of asking. */
static void on_control(struct pel_rtsp_stream *stream, GSourceFunc call,
                       unsigned after_ms)
{
    GSource *source =
        after_ms ? g_timeout_source_new(after_ms) : g_idle_source_new();
    atomic_fetch_add(&stream->references, 1);
    g_source_set_priority(source, G_PRIORITY_DEFAULT);
    g_source_set_callback(source, call, stream, stream_unref);
    g_source_attach(source, NULL);
    g_source_unref(source);
}

/* --- on the control thread ----------------------------------------------- */

static void on_frame(void *user, enum pel_err err,
                     const struct pel_fault *fault, struct pel_frame *frame)
{
    struct pel_rtsp_stream *self = user;
    (void)fault;
    if (err == PEL_ERR_NOT_FOUND) {
        gst_app_src_end_of_stream(self->source);
        return;
    }
    if (err != PEL_OK) {
        return;
    }
    int64_t now = pel_now_ns();
    if (gst_app_src_get_current_level_buffers(self->source) >= MAX_QUEUED) {
        self->hub->dropped++;
        pel_frames_resync(self->subscription, false);
        return;
    }
    /* Begun before the pipeline: RTP could not say when. */
    GstClockTime time = pel_gst_running_time(self->source, frame);
    if (!GST_CLOCK_TIME_IS_VALID(time)) {
        pel_frames_resync(self->subscription, true);
        return;
    }
    self->key_ns = frame->key ? now : self->key_ns;
    if (now - self->key_ns > KEY_NS) {
        pel_frames_want_key(self->subscription, false);
    }
    self->hub->sent++;
    self->hub->bytes += frame->size;
    gst_app_src_push_buffer(self->source, pel_gst_wrap(frame, time));
}

static gboolean open_stream(gpointer user)
{
    PEL_WATCH("rtsp");
    struct pel_rtsp_stream *self = user;
    struct pel_rtsp_hub *hub = self->hub;
    const struct pel_profile profile = { .codec = PEL_CODEC_H264,
                                         .who = self->who };
    if (!hub->frames ||
        pel_frames_open(hub->frames, self->view, &profile, on_frame, self,
                        &self->subscription, NULL) != PEL_OK) {
        gst_app_src_end_of_stream(self->source);
        return G_SOURCE_REMOVE;
    }
    self->open = true;
    self->key_ns = pel_now_ns();
    self->next = hub->streams;
    hub->streams = self;
    hub->streaming++;
    return G_SOURCE_REMOVE;
}

static gboolean play_stream(gpointer user)
{
    PEL_WATCH("rtsp");
    struct pel_rtsp_stream *self = user;
    if (self->open) {
        pel_frames_want_key(self->subscription, true);
    }
    return G_SOURCE_REMOVE;
}

static gboolean close_stream(gpointer user)
{
    PEL_WATCH("rtsp");
    struct pel_rtsp_stream *self = user;
    if (self->open) {
        struct pel_rtsp_stream **link = &self->hub->streams;
        while (*link != self) {
            link = &(*link)->next;
        }
        *link = self->next;
        self->open = false;
        self->hub->streaming--;
        pel_frames_unsubscribe(self->subscription);
    }
    return G_SOURCE_REMOVE;
}

void pel_rtsp_hub_close(struct pel_rtsp_hub *hub)
{
    hub->frames = NULL;
    while (hub->streams) {
        close_stream(hub->streams);
    }
}

/* --- from any thread ----------------------------------------------------- */

struct pel_rtsp_stream *pel_rtsp_stream_create(struct pel_rtsp_hub *hub,
                                               const char *view,
                                               const struct pel_who *who,
                                               GstAppSrc *source)
{
    struct pel_rtsp_stream *stream = g_new0(struct pel_rtsp_stream, 1);
    atomic_init(&stream->references, 1);
    stream->hub = pel_rtsp_hub_ref(hub);
    stream->who = *who;
    stream->source = gst_object_ref(source);
    snprintf(stream->view, sizeof stream->view, "%s", view);
    on_control(stream, open_stream, 0);
    return stream;
}

void pel_rtsp_stream_play(struct pel_rtsp_stream *stream)
{
    on_control(stream, play_stream, PLAY_KEY_MS);
}

void pel_rtsp_stream_close(struct pel_rtsp_stream *stream)
{
    on_control(stream, close_stream, 0);
    stream_unref(stream);
}
