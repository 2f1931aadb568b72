/* RTSP: every view at rtsp://ADDRESS:PORT/NAME in H.264, over UDP or TCP, by
 * gst-rtsp-server. It comes to life with its first client; its own threads
 * serve the clients, and each client has its own queue, so that none waits for
 * another. Control thread. */
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "base/err.h"
#include "base/metrics.h"
#include "frames/frames.h"
#include "net/tls.h"
#include "net/token.h"
#include "scene/scene.h"

struct pel_rtsp;

struct pel_rtsp_options {
    const char *address; /* numeric IPv4 or IPv6 */
    uint16_t port;       /* 0: any free one */
    bool allow_remote;
    struct pel_token
        *token;          /* the password; NULL: none is asked for; borrowed */
    struct pel_tls *tls; /* RTSPS only, interleaved only: RTP over UDP would be
                          * plain; NULL: RTSP; borrowed */
};

/* Listens. Errors as pel_listener_tcp. */
PEL_CHECK enum pel_err pel_rtsp_create(const struct pel_rtsp_options *options,
                                       struct pel_scene *scene,
                                       struct pel_frames *frames,
                                       struct pel_rtsp **out,
                                       struct pel_fault *fault);

void pel_rtsp_stop(struct pel_rtsp *rtsp);    /* no new clients */
void pel_rtsp_destroy(struct pel_rtsp *rtsp); /* NULL allowed */

uint16_t pel_rtsp_port(const struct pel_rtsp *rtsp);

/* The scene's views may have changed. */
/* Tokens have changed: the clients of those that do not hold end. */
void pel_rtsp_revoke(struct pel_rtsp *rtsp);

void pel_rtsp_changed(struct pel_rtsp *rtsp);

void pel_rtsp_collect(const struct pel_rtsp *rtsp,
                      struct pel_metrics_page *page);
