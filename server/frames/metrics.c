#include <stdio.h>

#include "frames/core.h"

static void counter(struct pel_metrics_page *page, const char *name,
                    const char *help, uint64_t value)
{
    pel_metric(page, name, PEL_METRIC_COUNTER, help, NULL, (double)value);
}

static void gauge(struct pel_metrics_page *page, const char *name,
                  const char *help, double value)
{
    pel_metric(page, name, PEL_METRIC_GAUGE, help, NULL, value);
}

/* One quantile of the last 256, in seconds. */
static void quantile(struct pel_metrics_page *page, const char *name,
                     const char *help, const char *label, double ms)
{
    pel_metric(page, name, PEL_METRIC_SUMMARY, help, label, ms * 1e-3);
}

/* By device, where there are several. */
static void collect_devices(struct pel_frames *frames,
                            struct pel_metrics_page *page)
{
    static const struct {
        const char *name, *help;
        enum pel_metric_type type;
    } rows[] = {
        { "pelagos_device_standing", "1: the device draws; 0: it was lost.",
          PEL_METRIC_GAUGE },
        { "pelagos_device_views_total", "Views that the device drew.",
          PEL_METRIC_COUNTER },
        { "pelagos_device_megapixel_seconds",
          "What a million pixels of a usual view last took.",
          PEL_METRIC_GAUGE },
    };
    size_t count = pel_devices_count(frames->devices);
    for (int row = 0; row < 3 && count > 1; row++) {
        for (size_t i = 0; i < count; i++) {
            struct pel_device_stats d;
            char label[32];
            pel_devices_stats(frames->devices, i, &d);
            const double values[] = { d.standing, (double)d.views,
                                      d.ms_per_mpixel * 1e-3 };
            snprintf(label, sizeof label, "device=\"%zu\"", i);
            pel_metric(page, rows[row].name, rows[row].type, rows[row].help,
                       label, values[row]);
        }
    }
}

#define SURFACE_HELP                                                           \
    "Processor time of surface queries, before and behind the threads that "   \
    "draw."

void pel_frames_collect(void *user, struct pel_metrics_page *page)
{
    struct pel_frames_stats s;
    pel_frames_get_stats(user, &s);
    counter(page, "pelagos_frames_drawn_total", "Frames (moments) drawn.",
            s.frames_drawn);
    counter(page, "pelagos_frames_views_total", "Views drawn.", s.views_drawn);
    counter(page, "pelagos_frames_skipped_total",
            "Live frames left out because the renderer was busy.",
            s.frames_skipped);
    counter(page, "pelagos_frames_encoded_total", "Pictures encoded.",
            s.pictures_encoded);
    counter(page, "pelagos_frames_encoded_bytes_total",
            "Bytes of encoded pictures.", s.encoded_bytes);
    counter(page, "pelagos_frames_refused_total",
            "Requests for pictures and queries refused.", s.requests_refused);
    counter(page, "pelagos_surface_queries_total", "Surface queries taken.",
            s.surfaces);
    counter(page, "pelagos_surface_prefetched_total",
            "Surface queries about now, answered for a moment that was "
            "prepared.",
            s.surfaces_prefetched);
    pel_metric(page, "pelagos_surface_processor_seconds_total",
               PEL_METRIC_COUNTER, SURFACE_HELP, "lane=\"urgent\"",
               (double)s.surfaces_urgent_ns * 1e-9);
    pel_metric(page, "pelagos_surface_processor_seconds_total",
               PEL_METRIC_COUNTER, SURFACE_HELP, "lane=\"behind\"",
               (double)s.surfaces_behind_ns * 1e-9);
    quantile(page, "pelagos_frames_render_seconds",
             "From submission to pixels, of the last 256 views.",
             "quantile=\"0.5\"", s.render_ms_median);
    quantile(page, "pelagos_frames_render_seconds",
             "From submission to pixels, of the last 256 views.",
             "quantile=\"0.95\"", s.render_ms_p95);
    quantile(page, "pelagos_frames_encode_seconds",
             "Encoding, of the last 256 pictures.", "quantile=\"0.5\"",
             s.encode_ms_median);
    gauge(page, "pelagos_frames_quality",
          "Scale of width and height that live views are drawn at.", s.quality);
    counter(page, "pelagos_frames_quality_changes_total",
            "Times that the scale changed.", s.quality_changes);
    gauge(page, "pelagos_frames_present_delay_seconds",
          "From the stamp of a live frame to its time of presentation.",
          s.present_delay_ms * 1e-3);
    gauge(page, "pelagos_render_shading_in_compute",
          "1: pixels are shaded in compute; 0: as fragments.", s.in_compute);
    gauge(page, "pelagos_render_programs",
          "Programs that are loaded in the drivers of all devices.",
          pel_renderer_programs());
    counter(page, "pelagos_video_frames_total",
            "Pictures of H.264 and VP8 encoded.", s.video_frames);
    counter(page, "pelagos_video_keys_total", "H.264 key frames encoded.",
            s.video_keys);
    counter(page, "pelagos_video_bytes_total", "Bytes of encoded H.264.",
            s.video_bytes);
    quantile(page, "pelagos_video_encode_seconds",
             "Encoding H.264, of the last 256 pictures.", "quantile=\"0.5\"",
             s.video_ms_median);
    gauge(page, "pelagos_frames_live_pixels",
          "Pixels of all live views together; they may be 67108864.",
          s.live_megapixels * 1e6);
    counter(page, "pelagos_frames_streams_left_out_total",
            "Live pictures not drawn: views have too many pixels together.",
            s.streams_left_out);
    gauge(page, "pelagos_frames_subscriptions", "Live views being watched.",
          s.subscriptions);
    counter(page, "pelagos_frames_large_total",
            "Frames drawn in bands between the others'.", s.large_drawn);
    counter(page, "pelagos_frames_behind_total",
            "Live pictures drawn behind those of higher roles.",
            s.behind_drawn);
    counter(page, "pelagos_device_losses_total",
            "Times that the graphics device was lost and a renderer made anew.",
            s.losses);
    counter(page, "pelagos_device_views_again_total",
            "Views drawn again for a loss of the device.", s.views_again);
    gauge(page, "pelagos_device_loss_worst_seconds",
          "Longest time from a loss until a renderer stood again.",
          s.loss_worst_ms * 1e-3);
    gauge(page, "pelagos_device_fallen_back",
          "1: after losses the processor draws, until the daemon is started "
          "anew.",
          s.fallen_back);
    collect_devices(user, page);
    counter(page, "pelagos_frames_dropped_total",
            "Pictures that nobody waited for any more.", s.pictures_dropped);
    gauge(page, "pelagos_frames_requests_waiting", "Pictures not yet answered.",
          s.requests_waiting);
}
