#include "net/wheppeer.h"

#include <stdatomic.h>
#include <stdio.h>
#include <string.h>

#define GST_USE_UNSTABLE_API /* its way to say that the library is young */
#include <gst/app/gstappsrc.h>
#include <gst/gst.h>
#include <gst/sdp/sdp.h>
#include <gst/video/video.h>
#include <gst/webrtc/webrtc.h>

#include "base/clock.h"
#include "encode/gst.h"
#include "net/gstframe.h"

/* Its own candidates are there at once, those of servers after an answer. */
#define GATHER_MS 1500
#define GATHER_SERVERS_MS 5000
/* The queue is bounded where it is filled: whep.c. */
#define LAUNCH                                                                 \
    "appsrc name=source is-live=true format=time do-timestamp=true "           \
    "block=false max-bytes=0 max-buffers=0 max-time=0 "                        \
    "caps=video/%s name=pay pt=%u ssrc=%u mtu=1200 timestamp-offset=0 ! "      \
    "application/x-rtp,media=video,encoding-name=%s,payload=%u,"               \
    "clock-rate=90000 ! web.sink_0 "                                           \
    "webrtcbin name=web bundle-policy=max-bundle"

#define PAY_H264                                                               \
    "x-h264,stream-format=byte-stream,alignment=au ! rtph264pay "              \
    "config-interval=-1 aggregate-mode=zero-latency"
#define PAY_VP8 "x-vp8 ! rtpvp8pay"

struct pel_whep_peer {
    GstElement *pipeline, *web;
    GstAppSrc *source;
    pel_whep_told told;
    void *user;
    _Atomic int64_t heard_ns;
};

/* --- what GStreamer's threads tell ---------------------------------------- */

static void on_state(GObject *web, GParamSpec *spec, gpointer user)
{
    (void)spec;
    struct pel_whep_peer *peer = user;
    GstWebRTCPeerConnectionState state;
    g_object_get(web, "connection-state", &state, NULL);
    if (state == GST_WEBRTC_PEER_CONNECTION_STATE_CONNECTED) {
        peer->told(peer->user, PEL_WHEP_CONNECTED);
    } else if (state == GST_WEBRTC_PEER_CONNECTION_STATE_FAILED ||
               state == GST_WEBRTC_PEER_CONNECTION_STATE_CLOSED) {
        peer->told(peer->user, PEL_WHEP_LOST);
    }
}

static GstPadProbeReturn on_wish(GstPad *pad, GstPadProbeInfo *info,
                                 gpointer user)
{
    (void)pad;
    struct pel_whep_peer *peer = user;
    if (gst_video_event_is_force_key_unit(gst_pad_probe_info_get_event(info))) {
        peer->told(peer->user, PEL_WHEP_KEY);
    }
    return GST_PAD_PROBE_OK;
}

static GstPadProbeReturn on_heard(GstPad *pad, GstPadProbeInfo *info,
                                  gpointer user)
{
    (void)pad;
    (void)info;
    struct pel_whep_peer *peer = user;
    atomic_store(&peer->heard_ns, pel_now_ns());
    return GST_PAD_PROBE_OK;
}

static GstPadProbeReturn drop_data(GstPad *pad, GstPadProbeInfo *info,
                                   gpointer user)
{
    (void)pad;
    (void)info;
    (void)user;
    return GST_PAD_PROBE_DROP;
}

/* What comes by DTLS that is no media: a peer begins SCTP whether or not its
 * line of data was taken. No element takes it, and the pipeline would fail. */
static void on_dtls_pad(GstElement *dtls, GstPad *pad, gpointer user)
{
    (void)dtls;
    (void)user;
    if (GST_PAD_IS_SRC(pad)) {
        gst_pad_add_probe(
            pad, GST_PAD_PROBE_TYPE_BUFFER | GST_PAD_PROBE_TYPE_BUFFER_LIST,
            drop_data, NULL, NULL);
    }
}

/* Nobody reads the bus: what is put there would stay. What is dropped is ours
 * to release. */
static GstBusSyncReply on_message(GstBus *bus, GstMessage *message,
                                  gpointer user)
{
    (void)bus;
    struct pel_whep_peer *peer = user;
    if (GST_MESSAGE_TYPE(message) == GST_MESSAGE_ERROR) {
        peer->told(peer->user, PEL_WHEP_LOST);
    }
    gst_message_unref(message);
    return GST_BUS_DROP;
}

/* Where what the peer sends comes in: DTLS and its reports of reception. */
static void on_element(GstBin *bin, GstBin *sub, GstElement *element,
                       gpointer user)
{
    (void)bin;
    (void)sub;
    GstElementFactory *factory = gst_element_get_factory(element);
    const char *kind = factory ? GST_OBJECT_NAME(factory) : "";
    GstPad *pad = gst_element_get_static_pad(element, "src");
    if (pad && strcmp(kind, "nicesrc") == 0) {
        gst_pad_add_probe(pad, GST_PAD_PROBE_TYPE_BUFFER, on_heard, user, NULL);
    } else if (strcmp(kind, "dtlsdec") == 0) {
        g_signal_connect(element, "pad-added", G_CALLBACK(on_dtls_pad), NULL);
        if (pad) {
            on_dtls_pad(element, pad, NULL);
        }
    }
    g_clear_object(&pad);
}

/* --- making --------------------------------------------------------------- */

/* Addresses, ports and servers, before anything is gathered. */
static void set_places(GstElement *web, const struct pel_whep_places *places)
{
    GObject *ice = NULL, *agent = NULL;
    g_object_get(web, "ice-agent", &ice, NULL);
    g_object_get(ice, "agent", &agent, NULL);
    /* No search for routers, no TCP: nothing but the ports of the options. */
    g_object_set(agent, "upnp", FALSE, "ice-tcp", FALSE, NULL);
    if (places->address) {
        gboolean known = FALSE;
        g_signal_emit_by_name(ice, "add-local-ip-address", places->address,
                              &known);
    }
    if (places->port_max) {
        g_object_set(ice, "min-rtp-port", (guint)places->port_min,
                     "max-rtp-port", (guint)places->port_max, NULL);
    }
    for (int i = 0; places->servers && places->servers[i]; i++) {
        const char *server = places->servers[i];
        gboolean taken = FALSE;
        if (g_str_has_prefix(server, "stun:")) {
            g_object_set(web, "stun-server", server, NULL);
        } else {
            g_signal_emit_by_name(web, "add-turn-server", server, &taken);
        }
    }
    g_object_unref(agent);
    g_object_unref(ice);
}

/* Lost packets are sent again where the offer has a type for it; `ssrc` is
 * told, as otherwise the answer would name 0 as what they belong to. */
static void set_transceiver(GstElement *web, const char *codec,
                            unsigned payload, unsigned ssrc)
{
    GstPad *pad = gst_element_get_static_pad(web, "sink_0");
    GstWebRTCRTPTransceiver *transceiver = NULL;
    GstCaps *caps = gst_caps_new_simple(
        "application/x-rtp", "media", G_TYPE_STRING, "video", "encoding-name",
        G_TYPE_STRING, codec, "payload", G_TYPE_INT, (int)payload, "clock-rate",
        G_TYPE_INT, 90000, "ssrc", G_TYPE_UINT, ssrc, NULL);
    g_object_get(pad, "transceiver", &transceiver, NULL);
    g_object_set(transceiver, "direction",
                 GST_WEBRTC_RTP_TRANSCEIVER_DIRECTION_SENDONLY,
                 "codec-preferences", caps, "do-nack", TRUE, NULL);
    gst_caps_unref(caps);
    gst_object_unref(transceiver);
    gst_object_unref(pad);
}

static enum pel_err make(struct pel_whep_peer *peer,
                         const struct pel_whep_places *places,
                         const struct pel_whep_offer *offer,
                         struct pel_fault *fault)
{
    char launch[1024];
    GError *error = NULL;
    enum pel_err err = pel_gst_start(fault);
    if (err != PEL_OK) {
        return err;
    }
    unsigned ssrc = g_random_int() | 1;
    const char *codec = offer->vp8 ? "VP8" : "H264";
    snprintf(launch, sizeof launch, LAUNCH, offer->vp8 ? PAY_VP8 : PAY_H264,
             offer->payload, ssrc, codec, offer->payload);
    peer->pipeline = gst_parse_launch_full(launch, NULL,
                                           GST_PARSE_FLAG_FATAL_ERRORS, &error);
    if (!peer->pipeline) {
        err = pel_fault_set(fault, PEL_ERR_NOT_FOUND,
                            "GStreamer cannot do WebRTC here (%.120s): install "
                            "gstreamer1.0-plugins-bad and gstreamer1.0-nice",
                            error ? error->message : "no reason given");
        g_clear_error(&error);
        return err;
    }
    gst_object_ref_sink(peer->pipeline);
    peer->web = gst_bin_get_by_name(GST_BIN(peer->pipeline), "web");
    peer->source =
        GST_APP_SRC(gst_bin_get_by_name(GST_BIN(peer->pipeline), "source"));
    GstBus *bus = gst_pipeline_get_bus(GST_PIPELINE(peer->pipeline));
    gst_bus_set_sync_handler(bus, on_message, peer, NULL);
    gst_object_unref(bus);
    GstPad *pad = gst_element_get_static_pad(GST_ELEMENT(peer->source), "src");
    gst_pad_add_probe(pad, GST_PAD_PROBE_TYPE_EVENT_UPSTREAM, on_wish, peer,
                      NULL);
    gst_object_unref(pad);
    g_signal_connect(peer->pipeline, "deep-element-added",
                     G_CALLBACK(on_element), peer);
    g_signal_connect(peer->web, "notify::connection-state",
                     G_CALLBACK(on_state), peer);
    set_places(peer->web, places);
    set_transceiver(peer->web, codec, offer->payload, ssrc);
    gst_element_set_state(peer->pipeline, GST_STATE_PLAYING);
    return PEL_OK;
}

/* --- terms ---------------------------------------------------------------- */

/* Waits for what was asked; what webrtcbin says against it, or PEL_OK. `reply`
 * gets the description of that name, if it is not NULL. */
static enum pel_err wait_for(GstPromise *promise, const char *name,
                             GstWebRTCSessionDescription **reply,
                             struct pel_fault *fault)
{
    enum pel_err err = PEL_OK;
    bool replied = gst_promise_wait(promise) == GST_PROMISE_RESULT_REPLIED;
    const GstStructure *got = replied ? gst_promise_get_reply(promise) : NULL;
    GError *error = NULL;
    if (got && gst_structure_has_field(got, "error")) {
        gst_structure_get(got, "error", G_TYPE_ERROR, &error, NULL);
    }
    bool there = !name || (got && gst_structure_has_field(got, name));
    if (error || !replied || !there) {
        err = pel_fault_set(fault, PEL_ERR_INVALID,
                            "webrtcbin does not take the offer: %.160s",
                            error ? error->message : "no reason given");
        g_clear_error(&error);
    } else if (name) {
        gst_structure_get(got, name, GST_TYPE_WEBRTC_SESSION_DESCRIPTION, reply,
                          NULL);
    }
    gst_promise_unref(promise);
    return err;
}

static enum pel_err set_remote(GstElement *web, const char *text,
                               struct pel_fault *fault)
{
    GstSDPMessage *sdp = NULL;
    if (gst_sdp_message_new_from_text(text, &sdp) != GST_SDP_OK) {
        return pel_fault_set(fault, PEL_ERR_INVALID,
                             "GStreamer does not read the offer");
    }
    GstWebRTCSessionDescription *offer =
        gst_webrtc_session_description_new(GST_WEBRTC_SDP_TYPE_OFFER, sdp);
    GstPromise *promise = gst_promise_new();
    g_signal_emit_by_name(web, "set-remote-description", offer, promise);
    gst_webrtc_session_description_free(offer);
    return wait_for(promise, NULL, NULL, fault);
}

static enum pel_err set_local(GstElement *web, struct pel_fault *fault)
{
    GstWebRTCSessionDescription *answer = NULL;
    GstPromise *promise = gst_promise_new();
    g_signal_emit_by_name(web, "create-answer", NULL, promise);
    enum pel_err err = wait_for(promise, "answer", &answer, fault);
    if (err != PEL_OK) {
        return err;
    }
    promise = gst_promise_new();
    g_signal_emit_by_name(web, "set-local-description", answer, promise);
    gst_webrtc_session_description_free(answer);
    return wait_for(promise, NULL, NULL, fault);
}

static enum pel_err no_port(struct pel_fault *fault)
{
    return pel_fault_set(fault, PEL_ERR_BUSY,
                         "no UDP port is free for media; see pelagosd "
                         "--whep-ports");
}

static enum pel_err gather(GstElement *web, int within_ms,
                           struct pel_fault *fault)
{
    GstWebRTCICEGatheringState state = GST_WEBRTC_ICE_GATHERING_STATE_NEW;
    for (int ms = 0; ms < within_ms; ms += 2) {
        g_object_get(web, "ice-gathering-state", &state, NULL);
        if (state == GST_WEBRTC_ICE_GATHERING_STATE_COMPLETE) {
            return PEL_OK;
        }
        g_usleep(2000);
    }
    return no_port(fault);
}

/* RTP's clock at the epoch of UTC's [1/90000 s, modulo 2^32], so that a
 * picture's stamp can be told from its time stamp; false: the pipeline does not
 * run yet. */
static bool clock_of(const struct pel_whep_peer *peer, uint32_t *out)
{
    GstClock *clock = gst_element_get_clock(peer->pipeline);
    if (!clock) {
        return false;
    }
    int64_t running_ns = GST_CLOCK_DIFF(
        gst_element_get_base_time(peer->pipeline), gst_clock_get_time(clock));
    int64_t ns = pel_unix_ns() - running_ns;
    *out = (uint32_t) - (ns / 100000 * 9 + ns % 100000 * 9 / 100000);
    gst_object_unref(clock);
    return true;
}

static enum pel_err answer_of(const struct pel_whep_peer *peer,
                              const struct pel_whep_offer *offer, char **answer,
                              struct pel_fault *fault)
{
    uint32_t epoch;
    bool clocked = clock_of(peer, &epoch);
    GstWebRTCSessionDescription *local = NULL;
    g_object_get(peer->web, "local-description", &local, NULL);
    char *text = local ? gst_sdp_message_as_text(local->sdp) : NULL;
    *answer = text ? pel_whep_answer_write(offer, text, clocked ? &epoch : NULL)
                   : NULL;
    g_free(text);
    if (local) {
        gst_webrtc_session_description_free(local);
    }
    if (*answer && !strstr(*answer, "a=candidate:")) {
        g_free(*answer);
        *answer = NULL;
        return no_port(fault);
    }
    return *answer ? PEL_OK
                   : pel_fault_set(fault, PEL_ERR_INVALID,
                                   "webrtcbin's answer has no video");
}

static enum pel_err agree(struct pel_whep_peer *peer,
                          const struct pel_whep_places *places,
                          const struct pel_whep_offer *offer, char **answer,
                          struct pel_fault *fault)
{
    bool servers = places->servers && places->servers[0];
    /* Its candidates are of use only to a relay, which lets in nobody else.
     * Without them we send to nobody who has not proved to be the peer. */
    char *text = pel_whep_offer_write(offer, servers);
    enum pel_err err = set_remote(peer->web, text, fault);
    g_free(text);
    if (err == PEL_OK) {
        err = set_local(peer->web, fault);
    }
    if (err == PEL_OK) {
        err = gather(peer->web, servers ? GATHER_SERVERS_MS : GATHER_MS, fault);
    }
    return err != PEL_OK ? err : answer_of(peer, offer, answer, fault);
}

/* --- life ----------------------------------------------------------------- */

enum pel_err pel_whep_peer_open(const struct pel_whep_places *places,
                                const struct pel_whep_offer *offer,
                                pel_whep_told told, void *user,
                                struct pel_whep_peer **out, char **answer,
                                struct pel_fault *fault)
{
    struct pel_whep_peer *peer = g_new0(struct pel_whep_peer, 1);
    peer->told = told;
    peer->user = user;
    atomic_init(&peer->heard_ns, pel_now_ns());
    enum pel_err err = make(peer, places, offer, fault);
    if (err == PEL_OK) {
        err = agree(peer, places, offer, answer, fault);
    }
    if (err != PEL_OK) {
        pel_whep_peer_close(peer);
        return err;
    }
    *out = peer;
    return PEL_OK;
}

void pel_whep_peer_close(struct pel_whep_peer *peer)
{
    if (!peer) {
        return;
    }
    if (peer->pipeline) {
        gst_element_set_state(peer->pipeline, GST_STATE_NULL);
        g_signal_handlers_disconnect_by_data(peer->web, peer);
        gst_object_unref(peer->source);
        gst_object_unref(peer->web);
        gst_object_unref(peer->pipeline);
    }
    g_free(peer);
}

void pel_whep_peer_push(struct pel_whep_peer *peer, struct pel_frame *frame)
{
    GstClockTime time = pel_gst_running_time(peer->source, frame);
    gst_app_src_push_buffer(peer->source, pel_gst_wrap(frame, time));
}

unsigned pel_whep_peer_queued(const struct pel_whep_peer *peer)
{
    return (unsigned)gst_app_src_get_current_level_buffers(peer->source);
}

int64_t pel_whep_peer_heard_ns(const struct pel_whep_peer *peer)
{
    return atomic_load(&peer->heard_ns);
}
