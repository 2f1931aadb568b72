#include "pelagosctl/clip.h"

#include <stdbool.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include <glib.h>
#include <gst/gst.h>

#define LOOK_MS 100
#define FINISH_S 30

struct recorder {
    const struct clip_stream *wish;
    GstElement *pipeline;
    gint frames; /* atomic, as what follows: counted by GStreamer's thread */
    GMutex lock; /* protects first, last */
    GstClockTime first, last;
};

/* Elements, and the Debian packages that bring them. */
static const struct {
    const char *element, *package;
} needed[] = {
    { "souphttpsrc", "gstreamer1.0-plugins-good" },
    { "matroskamux", "gstreamer1.0-plugins-good" },
    { "mp4mux", "gstreamer1.0-plugins-good" },
    { "tsdemux", "gstreamer1.0-plugins-bad" },
    { "h264parse", "gstreamer1.0-plugins-bad" },
};

static bool has_all(char **why)
{
    for (size_t i = 0; i < G_N_ELEMENTS(needed); i++) {
        GstElementFactory *factory =
            gst_element_factory_find(needed[i].element);
        if (!factory) {
            *why = g_strdup_printf("GStreamer's %s is missing: install %s",
                                   needed[i].element, needed[i].package);
            return false;
        }
        gst_object_unref(factory);
    }
    return true;
}

/* --- counting ------------------------------------------------------------ */

static GstPadProbeReturn count_picture(GstPad *pad, GstPadProbeInfo *info,
                                       gpointer user)
{
    struct recorder *r = user;
    const GstBuffer *buffer = GST_PAD_PROBE_INFO_BUFFER(info);
    (void)pad;
    g_atomic_int_inc(&r->frames);
    if (GST_BUFFER_PTS_IS_VALID(buffer)) {
        g_mutex_lock(&r->lock);
        r->last = GST_BUFFER_PTS(buffer);
        r->first = r->first == GST_CLOCK_TIME_NONE ? r->last : r->first;
        g_mutex_unlock(&r->lock);
    }
    return GST_PAD_PROBE_OK;
}

static double seconds_of(struct recorder *r)
{
    g_mutex_lock(&r->lock);
    double seconds = r->first == GST_CLOCK_TIME_NONE || r->last < r->first
                         ? 0.0
                         : (double)(r->last - r->first) / GST_SECOND;
    g_mutex_unlock(&r->lock);
    return seconds;
}

/* --- the pipeline -------------------------------------------------------- */

static GstElement *named(struct recorder *r, const char *name)
{
    return gst_bin_get_by_name(GST_BIN(r->pipeline), name);
}

static bool build(struct recorder *r, char **why)
{
    const struct clip_stream *wish = r->wish;
    bool mkv = g_str_has_suffix(wish->path, ".mkv");
    if (!mkv && !g_str_has_suffix(wish->path, ".mp4")) {
        *why =
            g_strdup_printf("%s: a stream goes into .mkv or .mp4", wish->path);
        return false;
    }
    g_autoptr(GError) error = NULL;
    g_autofree char *text = g_strdup_printf(
        "souphttpsrc name=source timeout=15 retries=0 ! tsdemux ! "
        "h264parse name=parse ! %s ! "
        "filesink name=sink buffer-mode=unbuffered",
        mkv ? "matroskamux" : "mp4mux faststart=true");
    r->pipeline = gst_parse_launch(text, &error);
    if (!r->pipeline) {
        *why = g_strdup(error ? error->message : "no pipeline");
        return false;
    }
    GstElement *source = named(r, "source"), *sink = named(r, "sink");
    GstElement *parse = named(r, "parse");
    GstPad *pad = gst_element_get_static_pad(parse, "src");
    g_object_set(source, "location", wish->url, NULL);
    if (wish->token) {
        g_autofree char *bearer = g_strdup_printf("Bearer %s", wish->token);
        GstStructure *headers = gst_structure_new("headers", "Authorization",
                                                  G_TYPE_STRING, bearer, NULL);
        g_object_set(source, "extra-headers", headers, NULL);
        gst_structure_free(headers);
    }
    g_object_set(sink, "location", wish->path, NULL);
    gst_pad_add_probe(pad, GST_PAD_PROBE_TYPE_BUFFER, count_picture, r, NULL);
    gst_object_unref(pad);
    gst_object_unref(parse);
    gst_object_unref(sink);
    gst_object_unref(source);
    return true;
}

/* True: the file is finished, or *why says why it is not. */
static bool ended(struct recorder *r, char **why)
{
    GstBus *bus = gst_element_get_bus(r->pipeline);
    GstMessage *message = gst_bus_timed_pop_filtered(
        bus, LOOK_MS * GST_MSECOND, GST_MESSAGE_ERROR | GST_MESSAGE_EOS);
    gst_object_unref(bus);
    if (message && GST_MESSAGE_TYPE(message) == GST_MESSAGE_ERROR) {
        g_autoptr(GError) error = NULL;
        g_autofree char *details = NULL;
        gst_message_parse_error(message, &error, &details);
        bool source = strcmp(GST_OBJECT_NAME(message->src), "source") == 0;
        /* All that the source says of a refused connection. */
        bool silent = source && error->domain == GST_STREAM_ERROR;
        *why = silent
                   ? g_strdup_printf("%s: no answer, or it broke off; is this "
                                     "pelagosd's HTTP port (--url)?",
                                     r->wish->url)
                   : g_strdup_printf("%s: %s",
                                     source ? r->wish->url : r->wish->path,
                                     error->message);
    }
    if (message) {
        gst_message_unref(message);
    }
    return message != NULL;
}

static void run(struct recorder *r, char **why)
{
    const struct clip_stream *wish = r->wish;
    gint64 limit = 0; /* of finishing */
    while (!ended(r, why)) {
        double seconds = seconds_of(r);
        if (wish->progress) {
            wish->progress(wish->user, seconds, (size_t)r->frames);
        }
        if (limit == 0 && (*wish->stop || seconds >= wish->seconds)) {
            GstElement *source = named(r, "source");
            gst_element_send_event(source, gst_event_new_eos());
            gst_object_unref(source);
            limit = g_get_monotonic_time() + FINISH_S * G_USEC_PER_SEC;
        }
        if (limit != 0 && g_get_monotonic_time() > limit) {
            *why = g_strdup("the file was not finished in time");
            return;
        }
    }
}

int clip_stream(const struct clip_stream *wish, size_t *frames, char **why)
{
    struct recorder r = { .wish = wish,
                          .first = GST_CLOCK_TIME_NONE,
                          .last = GST_CLOCK_TIME_NONE };
    g_autoptr(GError) error = NULL;
    *why = NULL;
    g_mutex_init(&r.lock);
    if (!gst_init_check(NULL, NULL, &error)) {
        *why = g_strdup(error ? error->message : "GStreamer does not start");
    } else if (has_all(why) && build(&r, why)) {
        if (gst_element_set_state(r.pipeline, GST_STATE_PLAYING) ==
            GST_STATE_CHANGE_FAILURE) {
            *why = g_strdup_printf("cannot write %s", wish->path);
        } else {
            run(&r, why);
        }
    }
    if (r.pipeline) {
        gst_element_set_state(r.pipeline, GST_STATE_NULL);
        gst_object_unref(r.pipeline);
    }
    struct stat made;
    if (*why && r.frames == 0 && r.pipeline && stat(wish->path, &made) == 0 &&
        S_ISREG(made.st_mode) && made.st_size == 0) {
        unlink(wish->path); /* so that the next attempt need not overwrite */
    }
    g_mutex_clear(&r.lock);
    *frames = (size_t)r.frames;
    return *why ? -1 : 0;
}
