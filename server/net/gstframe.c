#include "net/gstframe.h"

#include "base/clock.h"

GstClockTime pel_gst_running_time(GstAppSrc *source,
                                  const struct pel_frame *frame)
{
    GstClockTime time = GST_CLOCK_TIME_NONE;
    GstClock *clock = gst_element_get_clock(GST_ELEMENT(source));
    if (clock) {
        GstClockTime base = gst_element_get_base_time(GST_ELEMENT(source));
        int64_t age_ns = pel_now_ns() - frame->requested_ns;
        GstClockTimeDiff at =
            GST_CLOCK_DIFF(base, gst_clock_get_time(clock)) - age_ns;
        time = at >= 0 ? (GstClockTime)at : GST_CLOCK_TIME_NONE;
        gst_object_unref(clock);
    }
    return time;
}

GstBuffer *pel_gst_wrap(struct pel_frame *frame, GstClockTime time)
{
    GstBuffer *buffer = gst_buffer_new_wrapped_full(
        GST_MEMORY_FLAG_READONLY, (gpointer)frame->data, frame->size, 0,
        frame->size, pel_frame_ref(frame), (GDestroyNotify)pel_frame_unref);
    GST_BUFFER_PTS(buffer) = time;
    if (!frame->key) {
        GST_BUFFER_FLAG_SET(buffer, GST_BUFFER_FLAG_DELTA_UNIT);
    }
    return buffer;
}
