/* Authentication of RTSP clients by the token as password (Basic), where there
 * is one. Called by gst-rtsp-server's threads. */
#pragma once

#include <gst/rtsp-server/rtsp-server.h>

#include "net/token.h"

/* token: borrowed until the last reference is gone. */
/* `admit`, on any thread: whether a client that gave a token has a place; if
 * not it is told 503. */
typedef bool (*pel_rtsp_admit)(void *user, GstRTSPClient *client,
                               const struct pel_who *who);
GstRTSPAuth *pel_rtsp_auth_new(struct pel_token *token, pel_rtsp_admit admit,
                               void *user);
