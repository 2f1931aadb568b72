/* GET /v1/views/NAME/live, the handshake of a WebSocket as request and answer;
 * GET /v1/views/NAME/ts, the same video for players; and in pieces, as HLS;
 * POST /v1/views/NAME/whep, by WebRTC. */
#include <stdio.h>
#include <string.h>

#include <glib.h>

#include "encode/video.h"
#include "net/command.h"
#include "net/http_view.h"
#include "net/websocket.h"

#define DEFAULT_CREDIT 3

/* A whole number of the query within minimum .. maximum. */
static enum pel_err read_number(const struct pel_http_pair *pair,
                                unsigned minimum, unsigned maximum,
                                unsigned *out, struct pel_fault *fault)
{
    char *end = NULL;
    guint64 value = g_ascii_strtoull(pair->value, &end, 10);
    if (!g_ascii_isdigit(pair->value[0]) || *end || value < minimum ||
        value > maximum) {
        char message[80];
        snprintf(message, sizeof message,
                 "must be a whole number between %u and %u", minimum, maximum);
        pel_fault_value(fault, PEL_ERR_OUT_OF_RANGE, pair->name, pair->value,
                        message);
        fault->minimum = minimum;
        fault->maximum = maximum;
        return fault->code;
    }
    *out = (unsigned)value;
    return PEL_OK;
}

static enum pel_err read_codec(const struct pel_http_pair *pair,
                               enum pel_codec *out, struct pel_fault *fault)
{
    bool jpeg = strcmp(pair->value, "jpeg") == 0;
    if (!jpeg && strcmp(pair->value, "h264") != 0) {
        return pel_fault_value(fault, PEL_ERR_INVALID, "codec", pair->value,
                               "must be h264 or jpeg");
    }
    *out = jpeg ? PEL_CODEC_PICTURE : PEL_CODEC_H264;
    return PEL_OK;
}

static enum pel_err read_pair(const struct pel_http_pair *pair,
                              struct pel_http_answer *answer,
                              struct pel_fault *fault)
{
    struct pel_profile *p = &answer->profile;
    unsigned quality = 0;
    struct {
        const char *name;
        unsigned minimum, maximum, *out;
    } numbers[] = {
        { "width", PEL_VIDEO_MIN_SIZE, PEL_VIDEO_MAX_SIZE, &p->width },
        { "height", PEL_VIDEO_MIN_SIZE, PEL_VIDEO_MAX_SIZE, &p->height },
        { "quality", 1, 100, &quality },
        { "bitrate", PEL_VIDEO_MIN_KBPS, PEL_VIDEO_MAX_KBPS, &p->kbps },
        { "credit", 1, PEL_WEBSOCKET_MAX_PICTURES, &answer->credit },
    };
    if (strcmp(pair->name, "codec") == 0) {
        return read_codec(pair, &p->codec, fault);
    }
    for (size_t i = 0; i < G_N_ELEMENTS(numbers); i++) {
        if (strcmp(pair->name, numbers[i].name) == 0) {
            enum pel_err err =
                read_number(pair, numbers[i].minimum, numbers[i].maximum,
                            numbers[i].out, fault);
            p->quality = quality ? (int)quality : p->quality;
            return err;
        }
    }
    return pel_fault_value(fault, PEL_ERR_NOT_FOUND, pair->name, pair->value,
                           "no such parameter: codec, width, height, bitrate, "
                           "quality and credit are known");
}

static bool has_word(const char *list, const char *word)
{
    char **words = g_strsplit(list ? list : "", ",", 8);
    bool found = false;
    for (int i = 0; words[i] && !found; i++) {
        found = g_ascii_strcasecmp(g_strstrip(words[i]), word) == 0;
    }
    g_strfreev(words);
    return found;
}

/* RFC 6455, 4.2.1; and pages of strangers may not look. */
static int check_handshake(const struct pel_http_call *call,
                           struct pel_fault *fault)
{
    const struct pel_http_request *r = call->request;
    size_t keys = 0;
    const char *key = pel_http_find_header(r, "Sec-WebSocket-Key", &keys);
    const char *version =
        pel_http_find_header(r, "Sec-WebSocket-Version", NULL);
    const char *origin = pel_http_find_header(r, "Origin", NULL);
    const char *host = pel_http_host(r);
    if (!has_word(pel_http_find_header(r, "Upgrade", NULL), "websocket") ||
        !has_word(pel_http_find_header(r, "Connection", NULL), "upgrade") ||
        !version || strcmp(version, "13") != 0) {
        pel_fault_set(fault, PEL_ERR_INVALID,
                      "this is a WebSocket, version 13: connect with ws://");
        call->answer->upgrade = true;
        return 426;
    }
    if (origin && (!host || !pel_http_origin_is_ours(origin, host)) &&
        !pel_http_allowed_origin(r, call->context->origins)) {
        pel_fault_set(fault, PEL_ERR_INVALID,
                      "pages of %.80s may not watch this server; pelagosd "
                      "--allow-origin ORIGIN lets them",
                      origin);
        return 403;
    }
    if (keys != 1 || !pel_websocket_accept_key(key, call->answer->accept)) {
        pel_fault_set(fault, PEL_ERR_MALFORMED,
                      "Sec-WebSocket-Key must be 16 bytes in base64");
        return 400;
    }
    call->answer->subprotocol = has_word(
        pel_http_find_header(r, "Sec-WebSocket-Protocol", NULL), "pelagos");
    return 0;
}

void pel_http_get_live(const struct pel_http_call *call)
{
    struct pel_fault fault;
    if (!pel_http_need_view(call)) {
        return;
    }
    call->answer->profile =
        (struct pel_profile){ .codec = PEL_CODEC_H264, .quality = 80 };
    call->answer->credit = DEFAULT_CREDIT;
    for (size_t i = 0; i < call->target->query_count; i++) {
        if (read_pair(&call->target->query[i], call->answer, &fault) !=
            PEL_OK) {
            pel_http_refuse(call, 400, &fault);
            return;
        }
    }
    int status = check_handshake(call, &fault);
    if (status != 0) {
        bool upgrade = call->answer->upgrade;
        pel_http_refuse(call, status, &fault);
        call->answer->upgrade = upgrade;
        return;
    }
    call->answer->kind = PEL_HTTP_LIVE;
    snprintf(call->answer->view, sizeof call->answer->view, "%s",
             pel_http_view_name(call));
}

static bool is_of_video(const char *name)
{
    return strcmp(name, "width") == 0 || strcmp(name, "height") == 0 ||
           strcmp(name, "bitrate") == 0;
}

/* What players ask with when they reload a playlist (RFC 8216bis, 6.2.5). */
static enum pel_err read_reload(const struct pel_http_pair *pair,
                                struct pel_hls_wish *wish,
                                struct pel_fault *fault)
{
    unsigned value = 0;
    bool msn = strcmp(pair->name, "_HLS_msn") == 0;
    enum pel_err err = read_number(pair, 0, G_MAXINT32, &value, fault);
    *(msn ? &wish->msn : &wish->part) = value;
    return err;
}

static void get_video(const struct pel_http_call *call, enum pel_http_kind kind)
{
    struct pel_fault fault;
    bool list = kind == PEL_HTTP_HLS;
    struct pel_hls_wish *reload = &call->answer->hls;
    if (!pel_http_need_view(call)) {
        return;
    }
    call->answer->profile = (struct pel_profile){ .codec = PEL_CODEC_H264 };
    reload->msn = reload->part = -1;
    for (size_t i = 0; i < call->target->query_count; i++) {
        const struct pel_http_pair *pair = &call->target->query[i];
        enum pel_err err =
            is_of_video(pair->name) ? read_pair(pair, call->answer, &fault)
            : list && g_str_has_prefix(pair->name, "_HLS_")
                ? read_reload(pair, reload, &fault)
                : pel_fault_value(&fault, PEL_ERR_NOT_FOUND, pair->name,
                                  pair->value,
                                  "no such parameter: width, height and "
                                  "bitrate are known");
        if (err == PEL_OK && reload->part >= 0 && reload->msn < 0 &&
            i + 1 == call->target->query_count) {
            err = pel_fault_value(&fault, PEL_ERR_INVALID, "_HLS_part",
                                  pair->value, "needs _HLS_msn beside it");
        }
        if (err != PEL_OK) {
            pel_http_refuse(call, 400, &fault);
            return;
        }
    }
    call->answer->kind = kind;
    snprintf(call->answer->view, sizeof call->answer->view, "%s",
             pel_http_view_name(call));
}

void pel_http_get_ts(const struct pel_http_call *call)
{
    get_video(call, PEL_HTTP_TS);
}

void pel_http_get_hls(const struct pel_http_call *call)
{
    get_video(call, PEL_HTTP_HLS);
}

void pel_http_get_hls_file(const struct pel_http_call *call)
{
    call->answer->kind = PEL_HTTP_HLS_FILE;
    snprintf(call->answer->file, sizeof call->answer->file, "%s",
             call->target->segments[2]);
}

void pel_http_post_whep(const struct pel_http_call *call)
{
    get_video(call, PEL_HTTP_WHEP);
}

void pel_http_delete_whep(const struct pel_http_call *call)
{
    call->answer->kind = PEL_HTTP_WHEP_END;
    snprintf(call->answer->file, sizeof call->answer->file, "%s",
             call->target->segments[2]);
}
