#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "error.h"
#include "pelagos.h"
#include "stream.h"
#include "token.h"

#define MAX_HEAD 8192
#define MAX_PICTURE ((size_t)64 << 20)
#define MAX_PROBLEM 16384
#define MAX_VIEW 64
/* Newer pictures taken in one call at most: a caller must get one some day. */
#define MAX_PASSED 64

struct pel_live {
    struct stream stream;
    size_t used; /* bytes at the start that were handed out */
    uint64_t dropped;
    char place[320]; /* for messages */
};

/* A part of the stream, in bytes from the buffer's start. */
struct part {
    size_t picture, size;
    uint64_t number, revision;
    double time_s;
    uint32_t host_frame;
    bool stale;
};

enum parsed {
    PART_WHOLE,
    PART_MORE,
    PART_BAD,
};

static enum pel_client_code stream_fail(const struct pel_live *live,
                                        enum stream_result result,
                                        struct pel_client_error *error)
{
    switch (result) {
    case STREAM_TIMEOUT:
        return client_fail(error, PEL_CLIENT_TIMEOUT,
                           "no picture of %s in time", live->place);
    case STREAM_MALFORMED:
        return client_fail(error, PEL_CLIENT_PROTOCOL, "%s is no Motion-JPEG",
                           live->place);
    case STREAM_CLOSED:
    case STREAM_OK:
        break;
    }
    return client_fail(error, PEL_CLIENT_CLOSED, "the stream of %s has ended",
                       live->place);
}

/* --- opening -------------------------------------------------------------- */

/* http://HOST[:PORT][/] to tcp:HOST:PORT, https to tls, and, for the Host
 * header, the part between. */
static bool read_url(const char *url, char *address, size_t size, char *host,
                     size_t host_size)
{
    bool secure = strncmp(url, "https://", 8) == 0;
    if (!secure && strncmp(url, "http://", 7) != 0) {
        return false;
    }
    const char *start = url + (secure ? 8 : 7);
    size_t length = strcspn(start, "/?# \t\r\n");
    if (length == 0 || length >= host_size ||
        (start[length] && strcmp(start + length, "/") != 0)) {
        return false;
    }
    memcpy(host, start, length);
    host[length] = '\0';
    const char *bracket = strrchr(host, ']');
    bool port = strchr(bracket ? bracket : host, ':') != NULL;
    int n = snprintf(address, size, "%s:%s%s", secure ? "tls" : "tcp", host,
                     port     ? ""
                     : secure ? ":443"
                              : ":80");
    return n > 0 && (size_t)n < size;
}

static bool good_name(const char *view)
{
    static const char letters[] = "abcdefghijklmnopqrstuvwxyz"
                                  "ABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-";
    size_t length = strspn(view, letters);
    return length > 0 && length <= MAX_VIEW && view[length] == '\0';
}

static enum stream_result ask(struct pel_live *live, const char *host,
                              const char *view, double fps, int quality,
                              const char *token, int64_t deadline_ns)
{
    char query[64] = "", request[768];
    int n = 0;
    if (fps > 0) {
        n = snprintf(query, sizeof query, "?fps=%.6g", fps);
    }
    if (quality > 0) {
        snprintf(query + n, sizeof query - (size_t)n, "%cquality=%d",
                 n ? '&' : '?', quality);
    }
    /* HTTP/1.0: the answer comes unwrapped, through proxies too. */
    n = snprintf(request, sizeof request,
                 "GET /v1/views/%s/mjpeg%s HTTP/1.0\r\nHost: %s\r\n"
                 "Connection: close\r\n%s%s%s\r\n",
                 view, query, host, *token ? "Authorization: Bearer " : "",
                 token, *token ? "\r\n" : "");
    enum stream_result result =
        stream_send(&live->stream, request, (size_t)n, deadline_ns);
    explicit_bzero(request, sizeof request);
    return result;
}

/* Bytes up to and with the empty line; 0: it is not there yet. */
static size_t head_size(const struct stream *stream)
{
    size_t there = stream->end - stream->start;
    const uint8_t *at = stream->buffer + stream->start;
    const uint8_t *end = there ? memmem(at, there, "\r\n\r\n", 4) : NULL;
    return end ? (size_t)(end - at) + 4 : 0;
}

static enum stream_result read_head(struct stream *stream, int64_t deadline_ns,
                                    size_t *size)
{
    while ((*size = head_size(stream)) == 0) {
        if (stream->end - stream->start > MAX_HEAD) {
            return STREAM_MALFORMED;
        }
        enum stream_result result = stream_receive(stream, 1, deadline_ns);
        if (result != STREAM_OK) {
            return result;
        }
    }
    return STREAM_OK;
}

/* The text of a JSON member, without an escape but \" and \\; "" if there is
 * none. The daemon's own problem documents need no more. */
static void member(const char *json, const char *name, char *out, size_t size)
{
    char key[40];
    snprintf(key, sizeof key, "\"%s\":", name);
    const char *at = strstr(json, key);
    at = at ? at + strlen(key) : "";
    at += strspn(at, " ");
    bool text = *at == '"';
    at += text;
    size_t n = 0;
    for (; *at && (text ? *at != '"' : !strchr(",} \n", *at)); at++) {
        at += *at == '\\' && at[1];
        if (n + 1 < size) {
            out[n++] = *at;
        }
    }
    out[n] = '\0';
}

static enum pel_client_code code_of(const char *name, int status)
{
    for (int code = PEL_CLIENT_MALFORMED; code <= PEL_CLIENT_FORBIDDEN;
         code++) {
        if (strcmp(name, pel_client_code_name((enum pel_client_code)code)) ==
            0) {
            return (enum pel_client_code)code;
        }
    }
    return status == 401                    ? PEL_CLIENT_UNAUTHORIZED
           : status == 403                  ? PEL_CLIENT_FORBIDDEN
           : status == 404                  ? PEL_CLIENT_NOT_FOUND
           : status == 429 || status == 503 ? PEL_CLIENT_BUSY
           : status >= 500                  ? PEL_CLIENT_INTERNAL
                                            : PEL_CLIENT_INVALID;
}

/* The daemon's refusal: the problem document that follows the head. */
static enum pel_client_code refuse(struct pel_live *live, int status,
                                   int64_t deadline_ns,
                                   struct pel_client_error *error)
{
    struct stream *stream = &live->stream;
    while (stream->end - stream->start < MAX_PROBLEM &&
           stream_receive(stream, 1, deadline_ns) == STREAM_OK) {
    }
    char json[MAX_PROBLEM + 1], text[256], number[40];
    size_t there = stream->end - stream->start;
    there = there < MAX_PROBLEM ? there : MAX_PROBLEM;
    memcpy(json, stream->buffer + stream->start, there);
    json[there] = '\0';
    member(json, "code", text, sizeof text);
    enum pel_client_code code = code_of(text, status);
    member(json, "detail", text, sizeof text);
    client_fail(error, code, "%s", *text ? text : "the stream was refused");
    if (error) {
        member(json, "path", error->path, sizeof error->path);
        member(json, "value", error->value, sizeof error->value);
        member(json, "unit", error->unit, sizeof error->unit);
        member(json, "maximum", number, sizeof number);
        if (*number) {
            error->maximum = strtod(number, NULL);
            member(json, "minimum", number, sizeof number);
            error->minimum = strtod(number, NULL);
        }
    }
    return code;
}

static enum pel_client_code begin(struct pel_live *live, int64_t deadline_ns,
                                  struct pel_client_error *error)
{
    size_t size = 0;
    int status = 0;
    enum stream_result result = read_head(&live->stream, deadline_ns, &size);
    if (result == STREAM_OK) {
        const char *head =
            (const char *)live->stream.buffer + live->stream.start;
        char line[32] = "";
        memcpy(line, head, size < sizeof line ? size : sizeof line - 1);
        if (sscanf(line, "HTTP/1.%*1[01] %3d", &status) != 1) {
            result = STREAM_MALFORMED;
        }
    }
    if (result != STREAM_OK) {
        return stream_fail(live, result, error);
    }
    live->stream.start += size;
    return status == 200 ? PEL_CLIENT_OK
                         : refuse(live, status, deadline_ns, error);
}

enum pel_client_code pel_live_open(const char *url, const char *view,
                                   double fps, int quality, int timeout_ms,
                                   struct pel_live **out,
                                   struct pel_client_error *error)
{
    char address[300], host[280], why[256], token[CLIENT_TOKEN_MAX + 1];
    if (!url) {
        url = getenv(PEL_LIVE_URL_VARIABLE);
    }
    if (!url || !*url) {
        url = PEL_LIVE_DEFAULT_URL;
    }
    if (!read_url(url, address, sizeof address, host, sizeof host)) {
        return client_fail(error, PEL_CLIENT_BAD_ADDRESS,
                           "\"%.200s\" is not http://HOST:PORT", url);
    }
    if (!view || !good_name(view)) {
        return client_fail(error, PEL_CLIENT_INVALID,
                           "\"%.80s\" is no view's name", view ? view : "");
    }
    if (client_token(token, why, sizeof why) != 0) {
        return client_fail(error, PEL_CLIENT_UNAUTHORIZED, "%s", why);
    }
    int64_t deadline_ns = stream_deadline(timeout_ms);
    struct pel_live *live = calloc(1, sizeof *live);
    if (!live) {
        return client_fail(error, PEL_CLIENT_INTERNAL, "out of memory");
    }
    snprintf(live->place, sizeof live->place, "%s at %.200s", view, url);
    enum stream_open opened =
        stream_open(&live->stream, address, timeout_ms, why, sizeof why);
    if (opened != STREAM_OPENED) {
        free(live);
        return opened == STREAM_BAD_ADDRESS
                   ? client_fail(error, PEL_CLIENT_BAD_ADDRESS,
                                 "\"%.200s\" is not http://HOST:PORT", url)
                   : client_fail(error, PEL_CLIENT_UNREACHABLE,
                                 "pelagosd does not answer at %.150s: %s", url,
                                 why);
    }
    enum stream_result sent =
        ask(live, host, view, fps, quality, token, deadline_ns);
    explicit_bzero(token, sizeof token);
    enum pel_client_code code = sent == STREAM_OK
                                    ? begin(live, deadline_ns, error)
                                    : stream_fail(live, sent, error);
    if (code != PEL_CLIENT_OK) {
        pel_live_close(live);
        return code;
    }
    *out = live;
    return PEL_CLIENT_OK;
}

void pel_live_close(struct pel_live *live)
{
    if (live) {
        stream_close(&live->stream);
        free(live);
    }
}

/* --- pictures ------------------------------------------------------------- */

/* Value of a header line in `head`, which ends with a NUL; "" if absent. */
static const char *header(const char *head, const char *name)
{
    const char *at = strcasestr(head, name);
    if (!at || (at > head && at[-1] != '\n')) {
        return "";
    }
    at += strlen(name);
    return at + strspn(at, " \t");
}

/* X-Pelagos-Stale names the inputs, or says "none". */
static bool is_stale(const char *value)
{
    return *value && strncmp(value, "none", 4) != 0;
}

/* The part that begins `skip` bytes after the buffer's start. */
static enum parsed parse(const struct stream *stream, size_t skip,
                         struct part *part, size_t *missing)
{
    struct stream rest = *stream;
    rest.start += skip;
    size_t there = rest.end - rest.start, size = head_size(&rest);
    *missing = 1;
    if (size == 0 || size > MAX_HEAD) {
        return there > MAX_HEAD ? PART_BAD : PART_MORE;
    }
    char head[MAX_HEAD + 1];
    memcpy(head, rest.buffer + rest.start, size);
    head[size] = '\0';
    char *end = NULL;
    const char *length = header(head, "Content-Length:");
    unsigned long long bytes = strtoull(length, &end, 10);
    if (end == length || bytes < 1 || bytes > MAX_PICTURE) {
        return PART_BAD;
    }
    *part = (struct part){
        .picture = skip + size,
        .size = (size_t)bytes,
        .number = strtoull(header(head, "X-Pelagos-Frame:"), NULL, 10),
        .revision = strtoull(header(head, "X-Pelagos-Revision:"), NULL, 10),
        .time_s = strtod(header(head, "X-Pelagos-Time:"), NULL),
        .host_frame =
            (uint32_t)strtoul(header(head, "X-Pelagos-Host-Frame:"), NULL, 10),
        .stale = is_stale(header(head, "X-Pelagos-Stale:")),
    };
    if (there - size < part->size) {
        *missing = part->size - (there - size);
        return PART_MORE;
    }
    return PART_WHOLE;
}

/* As `parse`, with what comes until the deadline. */
static enum stream_result next_part(struct pel_live *live, size_t skip,
                                    int64_t deadline_ns, struct part *part)
{
    for (;;) {
        size_t missing = 1;
        switch (parse(&live->stream, skip, part, &missing)) {
        case PART_WHOLE:
            return STREAM_OK;
        case PART_BAD:
            return STREAM_MALFORMED;
        case PART_MORE:
            break;
        }
        enum stream_result result =
            stream_receive(&live->stream, missing, deadline_ns);
        if (result != STREAM_OK) {
            return result;
        }
    }
}

enum pel_client_code pel_live_next(struct pel_live *live, int timeout_ms,
                                   struct pel_live_frame *frame,
                                   struct pel_client_error *error)
{
    live->stream.start += live->used;
    live->used = 0;
    struct part part;
    enum stream_result result =
        next_part(live, 0, stream_deadline(timeout_ms), &part);
    if (result != STREAM_OK) {
        return stream_fail(live, result, error);
    }
    /* Whatever else has come already is newer. */
    struct part newer;
    for (int i = 0; i < MAX_PASSED; i++) {
        size_t end = part.picture + part.size;
        if (next_part(live, end, stream_deadline(0), &newer) != STREAM_OK) {
            break;
        }
        newer.picture -= end;
        live->stream.start += end;
        live->dropped++;
        part = newer;
    }
    live->used = part.picture + part.size;
    *frame = (struct pel_live_frame){
        .number = part.number,
        .host_frame = part.host_frame,
        .stale = part.stale,
        .time_s = part.time_s,
        .revision = part.revision,
        .dropped = live->dropped,
        .data = live->stream.buffer + live->stream.start + part.picture,
        .size = part.size,
    };
    return PEL_CLIENT_OK;
}
