/* GStreamer in this process. It is started at its first use, so that a daemon
 * that streams no video does not load it. */
#pragma once

#include "base/err.h"

/* Starts GStreamer; later calls return the first one's result. The first one
 * takes some 20 ms, seconds where the registry of plugins is not written yet.
 * Any thread, not the control thread. NOT_FOUND when it does not start. */
PEL_CHECK enum pel_err pel_gst_start(struct pel_fault *fault);
