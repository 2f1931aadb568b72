/* One RTSP client's pictures: from a subscription on the control thread into
 * the appsrc of its media. Made on a thread of gst-rtsp-server, which asks the
 * control thread for the rest. */
#pragma once

#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>

#include <gst/app/gstappsrc.h>

#include "frames/frames.h"

/* What the streams of one server share; the last reference frees it. */
struct pel_rtsp_hub {
    atomic_int references;
    struct pel_frames *frames;       /* NULL: the server is over */
    struct pel_rtsp_stream *streams; /* control thread */
    unsigned streaming;              /* control thread */
    uint64_t sent, bytes, dropped;   /* control thread */
};
struct pel_rtsp_hub *pel_rtsp_hub_create(struct pel_frames *frames);
struct pel_rtsp_hub *pel_rtsp_hub_ref(struct pel_rtsp_hub *hub);
/* Control thread: ends every stream; later ones do not begin. */
void pel_rtsp_hub_close(struct pel_rtsp_hub *hub);
void pel_rtsp_hub_unref(struct pel_rtsp_hub *hub);

struct pel_rtsp_stream;

/* Any thread. Takes a reference to source; begins soon after. */
struct pel_rtsp_stream *pel_rtsp_stream_create(struct pel_rtsp_hub *hub,
                                               const char *view,
                                               const struct pel_who *who,
                                               GstAppSrc *source);
/* Any thread: its client plays from now on. */
void pel_rtsp_stream_play(struct pel_rtsp_stream *stream);
/* Any thread: it is over; gives the creator's reference back. */
void pel_rtsp_stream_close(struct pel_rtsp_stream *stream);
