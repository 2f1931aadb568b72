/* Frames as GStreamer's buffers, for those who stream them by it. Control
 * thread. */
#pragma once

#include <gst/app/gstappsrc.h>

#include "frames/frames.h"

/* The frame's stamp in the pipeline's running time. RTP's sender reports tie
 * that to the wall's clock, the same for every view: players can align them.
 * NONE where the pipeline does not run yet. */
GstClockTime pel_gst_running_time(GstAppSrc *source,
                                  const struct pel_frame *frame);

/* The encoder's bytes themselves; the buffer holds the frame. */
GstBuffer *pel_gst_wrap(struct pel_frame *frame, GstClockTime time);
