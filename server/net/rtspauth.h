/* Authentication of RTSP clients by the token as password (Basic), where there
 * is one. Called by gst-rtsp-server's threads. */
#pragma once

#include <gst/rtsp-server/rtsp-server.h>

#include "net/token.h"

/* token: borrowed until the last reference is gone. */
GstRTSPAuth *pel_rtsp_auth_new(struct pel_token *token);
