#include "pelagosctl/clip.h"

#include <errno.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

#include <glib.h>
#include <gst/app/gstappsrc.h>
#include <gst/gst.h>

struct clip {
    FILE *file; /* .mjpeg; else the pipeline */
    GstElement *pipeline;
    GstAppSrc *source;
    double fps;
    const volatile int *stop;
    bool failed; /* nothing more is written */
};

#define MOST_WAITING 4 /* pictures before GStreamer */

/* Elements, the Debian packages that bring them. */
static const struct {
    const char *element, *package;
} packages[] = {
    { "matroskamux", "gstreamer1.0-plugins-good" },
    { "jpegdec", "gstreamer1.0-plugins-good" },
    { "mp4mux", "gstreamer1.0-plugins-good" },
    { "videoconvert", "gstreamer1.0-plugins-base" },
};

static int has_element(const char *name)
{
    GstElementFactory *factory = gst_element_factory_find(name);
    if (factory) {
        gst_object_unref(factory);
    }
    return factory != NULL;
}

/* What follows the source for `path`; NULL and *why. */
static const char *find_chain(const char *path, char **why)
{
    for (size_t i = 0; i < G_N_ELEMENTS(packages); i++) {
        if (!has_element(packages[i].element)) {
            *why = g_strdup_printf("GStreamer's %s is missing: install %s",
                                   packages[i].element, packages[i].package);
            return NULL;
        }
    }
    if (g_str_has_suffix(path, ".mkv")) {
        return "matroskamux";
    }
    if (!g_str_has_suffix(path, ".mp4")) {
        *why = g_strdup_printf("%s: the ending says the format: .mkv, .mp4 or "
                               ".mjpeg",
                               path);
        return NULL;
    }
    if (has_element("x264enc")) {
        return "jpegdec ! videoconvert ! video/x-raw,format=I420 ! "
               "x264enc speed-preset=veryfast pass=qual quantizer=21 ! "
               "mp4mux faststart=true";
    }
    if (has_element("openh264enc") && has_element("h264parse")) {
        return "jpegdec ! videoconvert ! video/x-raw,format=I420 ! "
               "openh264enc bitrate=8000000 ! h264parse ! mp4mux "
               "faststart=true";
    }
    *why = g_strdup("H.264 needs GStreamer's x264enc: install "
                    "gstreamer1.0-plugins-ugly, or record to .mkv");
    return NULL;
}

static int start_pipeline(struct clip *clip, const char *path,
                          const char *chain, uint32_t width, uint32_t height,
                          char **why)
{
    g_autofree char *text =
        g_strdup_printf("appsrc name=source format=time ! %s ! "
                        "filesink name=sink buffer-mode=unbuffered",
                        chain);
    g_autoptr(GError) error = NULL;
    clip->pipeline = gst_parse_launch(text, &error);
    if (!clip->pipeline) {
        *why = g_strdup(error ? error->message : "no pipeline");
        return -1;
    }
    GstElement *sink = gst_bin_get_by_name(GST_BIN(clip->pipeline), "sink");
    g_object_set(sink, "location", path, NULL);
    gst_object_unref(sink);
    clip->source =
        GST_APP_SRC(gst_bin_get_by_name(GST_BIN(clip->pipeline), "source"));
    GstCaps *caps = gst_caps_new_simple(
        "image/jpeg", "width", G_TYPE_INT, (int)width, "height", G_TYPE_INT,
        (int)height, "framerate", GST_TYPE_FRACTION, (int)(clip->fps * 1000),
        1000, NULL);
    gst_app_src_set_caps(clip->source, caps);
    gst_caps_unref(caps);
    if (gst_element_set_state(clip->pipeline, GST_STATE_PLAYING) ==
        GST_STATE_CHANGE_FAILURE) {
        *why = g_strdup_printf("cannot write %s", path);
        return -1;
    }
    return 0;
}

static void free_clip(struct clip *clip)
{
    if (clip->pipeline) {
        gst_element_set_state(clip->pipeline, GST_STATE_NULL);
        gst_object_unref(clip->pipeline);
    }
    if (clip->source) {
        gst_object_unref(clip->source);
    }
    g_free(clip);
}

struct clip *clip_open(const char *path, uint32_t width, uint32_t height,
                       double fps, const volatile int *stop, char **why)
{
    struct clip *clip = g_new0(struct clip, 1);
    clip->fps = fps;
    clip->stop = stop;
    if (g_str_has_suffix(path, ".mjpeg") || g_str_has_suffix(path, ".mjpg")) {
        clip->file = fopen(path, "wb");
        if (clip->file) {
            return clip;
        }
        *why = g_strdup_printf("%s: %s", path, strerror(errno));
        free_clip(clip);
        return NULL;
    }
    g_autoptr(GError) error = NULL;
    const char *chain = NULL;
    if (!gst_init_check(NULL, NULL, &error)) {
        *why = g_strdup(error ? error->message : "GStreamer does not start");
    } else {
        chain = find_chain(path, why);
    }
    if (!chain || start_pipeline(clip, path, chain, width, height, why) != 0) {
        free_clip(clip);
        return NULL;
    }
    return clip;
}

/* The first error on the bus; g_free(), NULL: none. */
static char *bus_error(struct clip *clip, GstClockTime wait)
{
    GstBus *bus = gst_element_get_bus(clip->pipeline);
    GstMessage *message = gst_bus_timed_pop_filtered(
        bus, wait, GST_MESSAGE_ERROR | GST_MESSAGE_EOS);
    gst_object_unref(bus);
    char *text = NULL;
    if (!message) {
        return wait > 0 ? g_strdup("the file was not finished in time") : NULL;
    }
    if (GST_MESSAGE_TYPE(message) == GST_MESSAGE_ERROR) {
        g_autoptr(GError) error = NULL;
        gst_message_parse_error(message, &error, NULL);
        text = g_strdup(error->message);
    }
    gst_message_unref(message);
    return text;
}

/* Waits for it. GStreamer's own wait would outlast a file that can no longer be
 * written, and a signal. */
static bool has_room(struct clip *clip, char **why)
{
    while (gst_app_src_get_current_level_buffers(clip->source) >=
           MOST_WAITING) {
        *why = bus_error(clip, 0);
        if (!*why && *clip->stop) {
            *why = g_strdup("interrupted while the file was not taken");
        }
        if (*why) {
            clip->failed = true;
            return false;
        }
        g_usleep(2000);
    }
    return true;
}

int clip_add(struct clip *clip, const uint8_t *jpeg, size_t size, double time_s,
             char **why)
{
    if (clip->file) {
        if (fwrite(jpeg, 1, size, clip->file) == size) {
            return 0;
        }
        *why = g_strdup(strerror(errno));
        return -1;
    }
    if (!has_room(clip, why)) {
        return -1;
    }
    GstBuffer *buffer = gst_buffer_new_memdup(jpeg, size);
    GST_BUFFER_PTS(buffer) = (GstClockTime)(time_s * GST_SECOND);
    GST_BUFFER_DURATION(buffer) = (GstClockTime)(GST_SECOND / clip->fps);
    if (gst_app_src_push_buffer(clip->source, buffer) == GST_FLOW_OK) {
        return 0;
    }
    *why = bus_error(clip, 0);
    *why = *why ? *why : g_strdup("GStreamer takes no more frames");
    return -1;
}

int clip_close(struct clip *clip, char **why)
{
    int result = 0;
    if (clip->file) {
        if (fclose(clip->file) != 0) {
            *why = g_strdup(strerror(errno));
            result = -1;
        }
    } else {
        gst_app_src_end_of_stream(clip->source);
        char *text = clip->failed ? NULL : bus_error(clip, 30 * GST_SECOND);
        if (text) {
            *why = text;
            result = -1;
        }
    }
    free_clip(clip);
    return result;
}
