#include "encode/video.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <gst/app/gstappsink.h>
#include <gst/app/gstappsrc.h>
#include <gst/gst.h>
#include <gst/video/video.h>

#include "base/clock.h"
#include "base/log.h"
#include "encode/gst.h"
#include "encode/planes.h"

#define POOL_BUFFERS 2
#define SLICE_NS (50 * 1000000LL) /* how long a cancel may wait */
#define MAX_SLOW 10.0
#define PATIENCE_NS 2000000000LL

/* Encoders and what makes them give one access unit for one picture, at once,
 * without B-frames, and key frames only when asked. A property that this
 * version does not know is passed over. */
static const struct kind {
    const char *name;
    GstVideoFormat format;
    unsigned rate_unit; /* bit/s of its rate */
    const char *properties;
} kinds[] = {
    { "nvh264enc", GST_VIDEO_FORMAT_NV12, 1000,
      "preset=low-latency-hq zerolatency=true rc-mode=cbr gop-size=-1 "
      "bframes=0" },
    { "vah264enc", GST_VIDEO_FORMAT_NV12, 1000,
      "rate-control=cbr key-int-max=1024 b-frames=0 ref-frames=1 "
      "target-usage=6" },
    { "vah264lpenc", GST_VIDEO_FORMAT_NV12, 1000,
      "rate-control=cbr key-int-max=1024 b-frames=0 ref-frames=1 "
      "target-usage=6" },
    { "x264enc", GST_VIDEO_FORMAT_NV12, 1000,
      "speed-preset=ultrafast tune=zerolatency threads=1 bframes=0 "
      "key-int-max=1073741824 byte-stream=true vbv-buf-capacity=400" },
    { "openh264enc", GST_VIDEO_FORMAT_I420, 1,
      "complexity=low rate-control=bitrate gop-size=1000000000 num-slices=1 "
      "slice-mode=n-slices multi-thread=1 usage-type=camera" },
    { "vp8enc", GST_VIDEO_FORMAT_I420, 1,
      "deadline=1 cpu-used=8 end-usage=cbr lag-in-frames=0 threads=1 "
      "keyframe-mode=disabled min-quantizer=4 buffer-size=1000 "
      "buffer-initial-size=500 buffer-optimal-size=600 "
      "max-intra-bitrate=400" },
};

static bool is_vp8(const struct kind *kind)
{
    return g_str_has_prefix(kind->name, "vp8");
}

struct pel_video {
    struct pel_video_config config;
    const struct kind *kind; /* NULL: none chosen yet */
    unsigned refused;        /* bits of kinds that did not work */
    uint32_t width, height;  /* of the pipeline, even */
    unsigned kbps;           /* of the stream */
    double period_ns;        /* between pictures, a mean of the last ones */
    double slow, set_slow;   /* nominal rate over the real one: now, as set */
    GstElement *pipeline, *source, *encoder, *sink;
    GstBufferPool *pool;
    GstVideoInfo info;
    int64_t first_ns, last_ns;
    uint8_t *headers; /* last SPS and PPS seen */
    size_t header_size;
    struct pel_planes_scratch scratch;
};

unsigned pel_video_kbps(uint32_t width, uint32_t height)
{
    double pixels = (double)width * height;
    double kbps = 5000.0 * pow(pixels / (1280.0 * 720.0), 0.75);
    return kbps < 300.0 ? 300 : kbps > 40000.0 ? 40000 : (unsigned)kbps;
}

struct pel_video *pel_video_create(const struct pel_video_config *config)
{
    struct pel_video *video = calloc(1, sizeof *video);
    if (video) {
        video->config = *config;
    }
    return video;
}

/* --- the pipeline -------------------------------------------------------- */

static void tear_down(struct pel_video *video)
{
    if (video->pipeline) {
        gst_element_set_state(video->pipeline, GST_STATE_NULL);
        gst_object_unref(video->pipeline);
    }
    if (video->pool) {
        gst_buffer_pool_set_active(video->pool, FALSE);
        gst_object_unref(video->pool);
    }
    video->pipeline = video->source = video->encoder = video->sink = NULL;
    video->pool = NULL;
}

void pel_video_destroy(struct pel_video *video)
{
    if (video) {
        tear_down(video);
        pel_planes_scratch_finish(&video->scratch);
        free(video->headers);
        free(video);
    }
}

static void set_properties(GstElement *element, const char *text)
{
    char **pairs = g_strsplit(text, " ", 0);
    for (int i = 0; pairs[i]; i++) {
        char *equals = strchr(pairs[i], '=');
        if (!equals) {
            continue;
        }
        *equals = '\0';
        if (g_object_class_find_property(G_OBJECT_GET_CLASS(element),
                                         pairs[i])) {
            gst_util_set_object_arg(G_OBJECT(element), pairs[i], equals + 1);
        }
    }
    g_strfreev(pairs);
}

/* Without latency an encoder counts bits by its nominal frame rate; where
 * pictures come less often each may have more of them. */
static void set_rate(struct pel_video *video, unsigned kbps)
{
    double rate = MIN(kbps * video->slow, (double)PEL_VIDEO_MAX_KBPS);
    g_object_set(video->encoder,
                 is_vp8(video->kind) ? "target-bitrate" : "bitrate",
                 (guint)(rate * 1000.0 / video->kind->rate_unit), NULL);
    video->kbps = kbps;
    video->set_slow = video->slow;
}

static void follow_rate(struct pel_video *video, unsigned kbps,
                        int64_t period_ns)
{
    double period = CLAMP((double)period_ns, 1e6, 1e9);
    video->period_ns += (period - video->period_ns) / 8.0;
    video->slow =
        CLAMP(video->period_ns * 1e-9 * video->config.fps, 1.0, MAX_SLOW);
    double ratio = video->slow / video->set_slow;
    if (kbps != video->kbps || ratio > 1.25 || ratio < 0.8) {
        set_rate(video, kbps);
    }
}

static bool make_pool(struct pel_video *video, GstCaps *caps)
{
    video->pool = gst_video_buffer_pool_new();
    GstStructure *config = gst_buffer_pool_get_config(video->pool);
    gst_buffer_pool_config_set_params(config, caps, (guint)video->info.size, 0,
                                      POOL_BUFFERS);
    return gst_buffer_pool_set_config(video->pool, config) &&
           gst_buffer_pool_set_active(video->pool, TRUE);
}

static bool make_elements(struct pel_video *video)
{
    video->pipeline = gst_pipeline_new(NULL);
    video->source = gst_element_factory_make("appsrc", NULL);
    video->encoder = gst_element_factory_make(video->kind->name, NULL);
    video->sink = gst_element_factory_make("appsink", NULL);
    GstElement *all[] = { video->source, video->encoder, video->sink };
    bool made = true;
    for (size_t i = 0; i < G_N_ELEMENTS(all); i++) {
        if (all[i]) {
            gst_bin_add(GST_BIN(video->pipeline), all[i]);
        }
        made = made && all[i];
    }
    return made;
}

static bool link_elements(struct pel_video *video)
{
    GstCaps *stream = gst_caps_from_string(
        is_vp8(video->kind)
            ? "video/x-vp8"
            : "video/x-h264,stream-format=byte-stream,alignment=au");
    bool linked =
        gst_element_link(video->source, video->encoder) &&
        gst_element_link_filtered(video->encoder, video->sink, stream);
    gst_caps_unref(stream);
    return linked;
}

/* BT.601: what libyuv makes of RGB. */
static bool set_up(struct pel_video *video, unsigned kbps)
{
    if (!make_elements(video)) {
        return false;
    }
    gst_video_info_set_format(&video->info, video->kind->format, video->width,
                              video->height);
    video->info.fps_n = (gint)(video->config.fps * 1000.0 + 0.5);
    video->info.fps_d = 1000;
    gst_video_colorimetry_from_string(&video->info.colorimetry,
                                      GST_VIDEO_COLORIMETRY_BT601);
    GstCaps *caps = gst_video_info_to_caps(&video->info);
    g_object_set(video->source, "caps", caps, "format", GST_FORMAT_TIME,
                 "max-buffers", (guint64)1, "max-bytes", (guint64)0, "max-time",
                 (guint64)0, NULL);
    g_object_set(video->sink, "sync", FALSE, "async", FALSE, "max-buffers", 4,
                 NULL);
    set_properties(video->encoder, video->kind->properties);
    set_rate(video, kbps);
    bool good = make_pool(video, caps) && link_elements(video) &&
                gst_element_set_state(video->pipeline, GST_STATE_PLAYING) !=
                    GST_STATE_CHANGE_FAILURE;
    gst_caps_unref(caps);
    return good;
}

/* --- one picture --------------------------------------------------------- */

/* From the readback buffer itself into the encoder's memory. Of the same size
 * an odd last column or row is left out; else the whole picture is scaled. */
static bool convert(struct pel_video *video, const struct pel_video_picture *p,
                    GstBuffer *buffer)
{
    GstVideoFrame frame;
    if (!gst_video_frame_map(&frame, &video->info, buffer, GST_MAP_WRITE)) {
        return false;
    }
    bool planar = video->kind->format == GST_VIDEO_FORMAT_I420;
    const struct pel_planes out = {
        .y = GST_VIDEO_FRAME_PLANE_DATA(&frame, 0),
        .u = GST_VIDEO_FRAME_PLANE_DATA(&frame, 1),
        .v = planar ? GST_VIDEO_FRAME_PLANE_DATA(&frame, 2) : NULL,
        .y_stride = GST_VIDEO_FRAME_PLANE_STRIDE(&frame, 0),
        .u_stride = GST_VIDEO_FRAME_PLANE_STRIDE(&frame, 1),
        .v_stride = planar ? GST_VIDEO_FRAME_PLANE_STRIDE(&frame, 2) : 0,
        .width = video->width,
        .height = video->height,
    };
    bool scaled = p->out_width != 0;
    enum pel_err err =
        p->rgba ? pel_planes_fill(p->rgba, (int)p->width * 4,
                                  scaled ? p->width : video->width,
                                  scaled ? p->height : video->height, false,
                                  &video->scratch, &out)
                : pel_planes_take(p->planes, scaled, &video->scratch, &out);
    gst_video_frame_unmap(&frame);
    return err == PEL_OK;
}

static bool push(struct pel_video *video, const struct pel_video_picture *p)
{
    GstBufferPoolAcquireParams params = {
        .flags = GST_BUFFER_POOL_ACQUIRE_FLAG_DONTWAIT,
    };
    GstBuffer *buffer = NULL;
    if (gst_buffer_pool_acquire_buffer(video->pool, &buffer, &params) !=
        GST_FLOW_OK) {
        return false;
    }
    if (!convert(video, p, buffer)) {
        gst_buffer_unref(buffer);
        return false;
    }
    if (p->key) {
        GstPad *pad = gst_element_get_static_pad(video->encoder, "src");
        gst_pad_send_event(pad, gst_video_event_new_upstream_force_key_unit(
                                    GST_CLOCK_TIME_NONE, TRUE, 0));
        gst_object_unref(pad);
    }
    /* Encoders refuse time that stands still. */
    int64_t stamp = p->stamp_ns - video->first_ns;
    stamp = MAX(stamp, video->last_ns + 1000000);
    video->last_ns = stamp;
    GST_BUFFER_PTS(buffer) = (GstClockTime)stamp;
    GST_BUFFER_DURATION(buffer) = GST_CLOCK_TIME_NONE;
    return gst_app_src_push_buffer(GST_APP_SRC(video->source), buffer) ==
           GST_FLOW_OK;
}

static bool failed(struct pel_video *video, char *why, size_t size)
{
    GstBus *bus = gst_element_get_bus(video->pipeline);
    GstMessage *message = gst_bus_pop_filtered(bus, GST_MESSAGE_ERROR);
    gst_object_unref(bus);
    if (message) {
        GError *error = NULL;
        gst_message_parse_error(message, &error, NULL);
        g_strlcpy(why, error->message, size);
        g_error_free(error);
        gst_message_unref(message);
    }
    return message != NULL;
}

static bool cancelled(const struct pel_video *video)
{
    return video->config.cancel && atomic_load(video->config.cancel);
}

static GstSample *pull(struct pel_video *video, char *why, size_t size)
{
    int64_t end = pel_now_ns() + PATIENCE_NS;
    GstSample *sample = NULL;
    g_strlcpy(why, "it gave nothing for 2 s", size);
    while (!sample && !cancelled(video) && pel_now_ns() < end) {
        sample =
            gst_app_sink_try_pull_sample(GST_APP_SINK(video->sink), SLICE_NS);
        if (!sample && failed(video, why, size)) {
            break;
        }
    }
    return sample;
}

/* Where the NAL unit after the one at `at` begins, start code included. */
static size_t next_nal(const uint8_t *data, size_t size, size_t at)
{
    for (size_t i = at + 3; i + 3 < size; i++) {
        if (data[i] == 0 && data[i + 1] == 0 && data[i + 2] == 1) {
            return data[i - 1] == 0 ? i - 1 : i;
        }
    }
    return size;
}

static int nal_type(const uint8_t *data, size_t size, size_t at)
{
    size_t code = at + 2 < size && data[at + 2] == 1 ? 3 : 4;
    return at + code < size ? data[at + code] & 31 : 0;
}

/* Size of the SPS and PPS at the front (an AUD before them included); 0:
 * there are none. */
static size_t headers_of(const uint8_t *data, size_t size)
{
    bool found = false;
    size_t at = 0;
    while (at < size) {
        int type = nal_type(data, size, at);
        if (type != 7 && type != 8 && type != 9 && type != 6) {
            break;
        }
        found = found || type == 7;
        at = next_nal(data, size, at);
    }
    return found ? at : 0;
}

/* A key frame carries its parameter sets: those who join know nothing. */
static enum pel_err take_unit(struct pel_video *video, GstSample *sample,
                              struct pel_bytes *out, bool *key)
{
    GstBuffer *buffer = gst_sample_get_buffer(sample);
    GstMapInfo map;
    if (!buffer || !gst_buffer_map(buffer, &map, GST_MAP_READ)) {
        return PEL_ERR_INTERNAL;
    }
    *key = !GST_BUFFER_FLAG_IS_SET(buffer, GST_BUFFER_FLAG_DELTA_UNIT);
    size_t own =
        *key && !is_vp8(video->kind) ? headers_of(map.data, map.size) : 0;
    size_t add = *key && own == 0 ? video->header_size : 0; /* VP8: none */
    enum pel_err err = PEL_OK;
    if (own > 0) {
        uint8_t *headers = realloc(video->headers, own);
        video->headers = headers ? headers : video->headers;
        video->header_size = headers ? own : 0;
        if (headers) {
            memcpy(headers, map.data, own);
        }
    }
    out->data = malloc(add + map.size);
    if (out->data) {
        if (add > 0) {
            memcpy(out->data, video->headers, add);
        }
        memcpy(out->data + add, map.data, map.size);
        out->size = add + map.size;
    } else {
        err = PEL_ERR_NO_MEMORY;
    }
    gst_buffer_unmap(buffer, &map);
    return err;
}

/* One picture through a pipeline that stands. */
static enum pel_err run(struct pel_video *video,
                        const struct pel_video_picture *p, unsigned kbps,
                        struct pel_bytes *out, bool *key,
                        struct pel_fault *fault)
{
    char why[160] = "it takes no picture";
    follow_rate(video, kbps, p->stamp_ns - video->first_ns - video->last_ns);
    GstSample *sample = push(video, p) ? pull(video, why, sizeof why) : NULL;
    if (!sample) {
        return cancelled(video)
                   ? pel_fault_set(fault, PEL_ERR_CONFLICT, "cancelled")
                   : pel_fault_set(fault, PEL_ERR_INTERNAL, "%s failed: %s",
                                   video->kind->name, why);
    }
    enum pel_err err = take_unit(video, sample, out, key);
    gst_sample_unref(sample);
    return err == PEL_OK ? err
                         : pel_fault_set(fault, err, "out of memory or unread");
}

/* --- choosing ------------------------------------------------------------ */

enum pel_err pel_video_check_encoder(const char *name, struct pel_fault *fault)
{
    char known[160] = "auto";
    bool found = strcmp(name, "auto") == 0;
    for (size_t i = 0; !is_vp8(&kinds[i]); i++) {
        found = found || strcmp(name, kinds[i].name) == 0;
        g_strlcat(known, is_vp8(&kinds[i + 1]) ? " or " : ", ", sizeof known);
        g_strlcat(known, kinds[i].name, sizeof known);
    }
    return found ? PEL_OK
                 : pel_fault_set(fault, PEL_ERR_INVALID,
                                 "'%.60s' is no H.264 encoder that is used; "
                                 "it must be %s",
                                 name, known);
}

static bool wanted(const struct pel_video *video, const struct kind *kind)
{
    const char *name = video->config.encoder;
    if (video->config.vp8 || is_vp8(kind)) {
        return video->config.vp8 && is_vp8(kind);
    }
    return !name || strcmp(name, "auto") == 0 || strcmp(name, kind->name) == 0;
}

static const struct kind *next_kind(const struct pel_video *video)
{
    for (size_t i = 0; i < G_N_ELEMENTS(kinds); i++) {
        if (!(video->refused & 1u << i) && wanted(video, &kinds[i])) {
            GstElementFactory *factory =
                gst_element_factory_find(kinds[i].name);
            if (factory) {
                gst_object_unref(factory);
                return &kinds[i];
            }
        }
    }
    return NULL;
}

static const char *codec_of(const struct pel_video *video)
{
    return video->config.vp8 ? "VP8" : "H.264";
}

/* Begins a sequence with the first encoder that gives a picture. */
static enum pel_err begin(struct pel_video *video,
                          const struct pel_video_picture *p, unsigned kbps,
                          struct pel_bytes *out, bool *key,
                          struct pel_fault *fault)
{
    static struct pel_log_limit limit;
    const struct kind *before = video->kind;
    enum pel_err err = pel_gst_start(fault);
    tear_down(video);
    while (err == PEL_OK) {
        video->kind = next_kind(video);
        if (!video->kind) {
            return pel_fault_set(
                fault, PEL_ERR_NOT_FOUND, "%s",
                video->config.vp8
                    ? "no VP8 encoder: GStreamer has no vp8enc "
                      "(gstreamer1.0-plugins-good) that works as wanted"
                    : "no H.264 encoder: GStreamer has none of x264enc "
                      "(gstreamer1.0-plugins-ugly), openh264enc or hardware's "
                      "(gstreamer1.0-plugins-bad) that works as wanted");
        }
        video->first_ns = p->stamp_ns;
        video->last_ns = -(int64_t)(1e9 / video->config.fps);
        video->period_ns = 1e9 / video->config.fps;
        video->slow = 1.0;
        err = set_up(video, kbps)
                  ? run(video, p, kbps, out, key, fault)
                  : pel_fault_set(fault, PEL_ERR_INTERNAL, "it does not start");
        if (err == PEL_OK || cancelled(video)) {
            break;
        }
        pel_log_limited(&limit, PEL_LOG_WARNING, "ENC-002",
                        "%s by %s does not work here: %s", codec_of(video),
                        video->kind->name, fault->message);
        video->refused |= 1u << (video->kind - kinds);
        tear_down(video);
        err = PEL_OK;
    }
    if (err == PEL_OK && video->kind != before) {
        pel_info("ENC-001", "%s of %ux%u at %u kbit/s by %s", codec_of(video),
                 video->width, video->height, kbps, video->kind->name);
    }
    return err;
}

enum pel_err pel_video_encode(struct pel_video *video,
                              const struct pel_video_picture *picture,
                              unsigned kbps, struct pel_bytes *out, bool *key,
                              struct pel_fault *fault)
{
    struct pel_fault own;
    bool scaled = picture->out_width != 0;
    uint32_t full_width = scaled ? picture->out_width : picture->width;
    uint32_t full_height = scaled ? picture->out_height : picture->height;
    uint32_t width = full_width & ~1u, height = full_height & ~1u;
    fault = fault ? fault : &own;
    *out = (struct pel_bytes){ 0 };
    *key = false;
    if ((!picture->rgba && !picture->planes) || picture->width == 0 ||
        picture->height == 0 || full_width < PEL_VIDEO_MIN_SIZE ||
        full_height < PEL_VIDEO_MIN_SIZE || full_width > PEL_VIDEO_MAX_SIZE ||
        full_height > PEL_VIDEO_MAX_SIZE || kbps < PEL_VIDEO_MIN_KBPS ||
        kbps > PEL_VIDEO_MAX_KBPS) {
        return pel_fault_set(fault, PEL_ERR_INVALID,
                             "a size or rate that %s is not made for",
                             codec_of(video));
    }
    if (!video->pipeline || width != video->width || height != video->height) {
        video->width = width;
        video->height = height;
        return begin(video, picture, kbps, out, key, fault);
    }
    enum pel_err err = run(video, picture, kbps, out, key, fault);
    if (err != PEL_OK) {
        tear_down(video);
    }
    return err;
}

const char *pel_video_encoder(const struct pel_video *video)
{
    return video->kind && video->pipeline ? video->kind->name : "";
}
