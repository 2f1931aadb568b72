#include "net/websocket.h"

#include <errno.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/uio.h>

#include <glib.h>
#include <wslay/wslay.h>

#include "base/clock.h"
#include "net/fdsource.h"

#define GUID "258EAFA5-E914-47DA-95CA-C5AB0DC85B11"
#define SOCKET_BUFFER (256 * 1024)
/* Read at one waking: the library's loop would let a flood of empty frames
 * hold up everybody's pictures. */
#define READ_BUDGET (16 * 1024)
#define PING_NS (10 * 1000000000LL)
#define PONG_LIMIT_NS (25 * 1000000000LL)
#define CLOSE_LIMIT_NS (2 * 1000000000LL)

struct picture {
    uint8_t head[10 + PEL_WEBSOCKET_MAX_HEAD]; /* RFC 6455's, then ours */
    size_t head_size;
    struct pel_frame *frame;
};

struct pel_websocket {
    int fd;
    struct pel_fdsource *source;
    struct pel_websocket_handlers handlers;
    void *user;
    wslay_event_context_ptr protocol;
    uint8_t *early;
    size_t early_size, early_used;
    size_t budget;
    struct picture ring[PEL_WEBSOCKET_MAX_PICTURES];
    unsigned first, count;
    size_t sent;              /* bytes of the first picture; 0: not begun */
    bool over, closing, said; /* a close frame: wanted, with the library */
    bool broken;
    unsigned fragments; /* of the message that comes */
    uint16_t code;
    char reason[121];
    int64_t ping_ns, pong_ns, close_ns; /* next, last, latest */
};

bool pel_websocket_accept_key(const char *key, char out[32])
{
    gsize size = 0;
    guchar *nonce = strlen(key) == 24 ? g_base64_decode(key, &size) : NULL;
    g_free(nonce);
    if (size != 16) {
        return false;
    }
    guint8 digest[20];
    gsize length = sizeof digest;
    GChecksum *sum = g_checksum_new(G_CHECKSUM_SHA1);
    g_checksum_update(sum, (const guchar *)key, -1);
    g_checksum_update(sum, (const guchar *)GUID, -1);
    g_checksum_get_digest(sum, digest, &length);
    g_checksum_free(sum);
    char *text = g_base64_encode(digest, length);
    g_strlcpy(out, text, 32);
    g_free(text);
    return true;
}

/* --- the library's ends -------------------------------------------------- */

static ssize_t on_recv(wslay_event_context_ptr protocol, uint8_t *buffer,
                       size_t size, int flags, void *user)
{
    struct pel_websocket *ws = user;
    (void)flags;
    size = MIN(size, ws->budget);
    ssize_t n = 0;
    if (size == 0) {
        wslay_event_set_error(protocol, WSLAY_ERR_WOULDBLOCK);
        return -1;
    }
    if (ws->early_used < ws->early_size) {
        n = (ssize_t)MIN(size, ws->early_size - ws->early_used);
        memcpy(buffer, ws->early + ws->early_used, (size_t)n);
        ws->early_used += (size_t)n;
    } else {
        do {
            n = recv(ws->fd, buffer, size, MSG_DONTWAIT);
        } while (n < 0 && errno == EINTR);
    }
    if (n <= 0) {
        bool later = n < 0 && (errno == EAGAIN || errno == EWOULDBLOCK);
        wslay_event_set_error(protocol, later ? WSLAY_ERR_WOULDBLOCK
                                              : WSLAY_ERR_CALLBACK_FAILURE);
        return -1;
    }
    ws->budget -= (size_t)n;
    return n;
}

static ssize_t on_send(wslay_event_context_ptr protocol, const uint8_t *data,
                       size_t size, int flags, void *user)
{
    struct pel_websocket *ws = user;
    (void)flags;
    ssize_t n;
    do {
        n = send(ws->fd, data, size, MSG_NOSIGNAL | MSG_DONTWAIT);
    } while (n < 0 && errno == EINTR);
    if (n < 0) {
        bool later = errno == EAGAIN || errno == EWOULDBLOCK;
        wslay_event_set_error(protocol, later ? WSLAY_ERR_WOULDBLOCK
                                              : WSLAY_ERR_CALLBACK_FAILURE);
    }
    return n;
}

/* Each costs the library a block of memory, however short it is. */
static void on_frame_begin(wslay_event_context_ptr protocol,
                           const struct wslay_event_on_frame_recv_start_arg *f,
                           void *user)
{
    struct pel_websocket *ws = user;
    bool data = f->opcode < WSLAY_CONNECTION_CLOSE;
    ws->fragments = f->opcode == WSLAY_CONTINUATION_FRAME ? ws->fragments + 1
                    : data                                ? 1
                                                          : ws->fragments;
    if (ws->fragments > PEL_WEBSOCKET_MAX_FRAGMENTS) {
        pel_websocket_close(ws, WSLAY_CODE_MESSAGE_TOO_BIG,
                            "the message has too many fragments");
        wslay_event_shutdown_read(protocol);
    }
}

static void on_message(wslay_event_context_ptr protocol,
                       const struct wslay_event_on_msg_recv_arg *message,
                       void *user)
{
    (void)protocol;
    struct pel_websocket *ws = user;
    if (message->opcode == WSLAY_PONG) {
        ws->pong_ns = pel_now_ns();
    } else if (message->opcode == WSLAY_BINARY_FRAME) {
        ws->handlers.on_message(ws->user, message->msg, message->msg_length);
    } else if (message->opcode == WSLAY_TEXT_FRAME) {
        pel_websocket_close(ws, WSLAY_CODE_UNSUPPORTED_DATA,
                            "only binary messages are understood");
    }
}

/* --- sending ------------------------------------------------------------- */

static void drop_picture(struct pel_websocket *ws)
{
    pel_frame_unref(ws->ring[ws->first].frame);
    ws->first = (ws->first + 1) % PEL_WEBSOCKET_MAX_PICTURES;
    ws->count--;
    ws->sent = 0;
}

/* False: the socket takes no more for now. */
static bool send_picture(struct pel_websocket *ws)
{
    const struct picture *p = &ws->ring[ws->first];
    size_t total = p->head_size + p->frame->size;
    while (ws->sent < total) {
        struct iovec parts[2];
        struct msghdr message = { .msg_iov = parts, .msg_iovlen = 1 };
        size_t into = ws->sent > p->head_size ? ws->sent - p->head_size : 0;
        parts[0] = parts[1] = (struct iovec){ (void *)(p->frame->data + into),
                                              p->frame->size - into };
        if (ws->sent < p->head_size) {
            parts[0] = (struct iovec){ (void *)(p->head + ws->sent),
                                       p->head_size - ws->sent };
            message.msg_iovlen = 2;
        }
        ssize_t n = sendmsg(ws->fd, &message, MSG_NOSIGNAL | MSG_DONTWAIT);
        if (n < 0 && errno == EINTR) {
            continue;
        }
        if (n < 0) {
            ws->over = errno != EAGAIN && errno != EWOULDBLOCK;
            return false;
        }
        ws->sent += (size_t)n;
    }
    drop_picture(ws);
    return true;
}

/* The library would send it before the messages that wait. */
static void say_close(struct pel_websocket *ws)
{
    ws->said = true;
    wslay_event_queue_close(ws->protocol, ws->code, (const uint8_t *)ws->reason,
                            strlen(ws->reason));
}

/* Control goes between pictures, never into one. */
static void flush(struct pel_websocket *ws)
{
    bool blocked = false;
    while (!blocked && !ws->over) {
        if (ws->sent > 0) {
            blocked = !send_picture(ws);
        } else if (wslay_event_want_write(ws->protocol)) {
            ws->over = wslay_event_send(ws->protocol) != 0 || ws->over;
            blocked = wslay_event_want_write(ws->protocol);
        } else if (ws->closing && !ws->said) {
            say_close(ws);
        } else if (ws->count > 0 && !ws->closing) {
            blocked = !send_picture(ws);
        } else {
            break;
        }
    }
    bool reads = wslay_event_want_read(ws->protocol);
    if (!reads && !blocked) {
        ws->over = true; /* both have said goodbye */
    }
    pel_fdsource_want(ws->source,
                      (reads ? G_IO_IN : 0) | (blocked ? G_IO_OUT : 0));
}

static int64_t next_alarm(const struct pel_websocket *ws)
{
    if (ws->over || (ws->early_used < ws->early_size &&
                     wslay_event_want_read(ws->protocol))) {
        return 0;
    }
    /* Who says goodbye is pinged no more. */
    return MIN(ws->closing ? ws->close_ns : ws->ping_ns,
               ws->pong_ns + PONG_LIMIT_NS);
}

static void keep_alive(struct pel_websocket *ws)
{
    int64_t now = pel_now_ns();
    if (now - ws->pong_ns >= PONG_LIMIT_NS ||
        (ws->closing && now >= ws->close_ns)) {
        ws->over = true;
    } else if (now >= ws->ping_ns && !ws->closing) {
        struct wslay_event_msg ping = { .opcode = WSLAY_PING };
        wslay_event_queue_msg(ws->protocol, &ping);
        ws->ping_ns = now + PING_NS;
    }
}

static void on_ready(void *user, GIOCondition ready)
{
    struct pel_websocket *ws = user;
    ws->budget = READ_BUDGET;
    if (ready & (G_IO_IN | G_IO_HUP | G_IO_ERR) ||
        ws->early_used < ws->early_size) {
        bool failed =
            wslay_event_recv(ws->protocol) != 0 || (ready & G_IO_ERR) ||
            (ready & G_IO_HUP && !wslay_event_want_read(ws->protocol));
        ws->over = ws->over || failed; /* on_message may have set it */
        /* The library has judged, and queued its own close frame. */
        if (!failed && !ws->broken &&
            !wslay_event_get_read_enabled(ws->protocol) &&
            !wslay_event_get_close_received(ws->protocol)) {
            ws->broken = true;
            ws->handlers.on_broken(ws->user);
        }
    }
    if (!ws->over) {
        keep_alive(ws);
        flush(ws);
    }
    /* Answers to pings and the like are the library's own control. */
    if (wslay_event_get_queued_msg_count(ws->protocol) >
        PEL_WEBSOCKET_MAX_CONTROL) {
        ws->over = true;
    }
    if (ws->over) {
        ws->handlers.on_closed(ws->user);
        return;
    }
    pel_fdsource_wake_at(ws->source, next_alarm(ws));
}

/* --- life ---------------------------------------------------------------- */

struct pel_websocket *
pel_websocket_create(int fd, const char *early, size_t early_size,
                     const struct pel_websocket_handlers *handlers, void *user)
{
    static const struct wslay_event_callbacks callbacks = {
        .recv_callback = on_recv,
        .send_callback = on_send,
        .on_frame_recv_start_callback = on_frame_begin,
        .on_msg_recv_callback = on_message,
    };
    struct pel_websocket *ws = g_new0(struct pel_websocket, 1);
    if (wslay_event_context_server_init(&ws->protocol, &callbacks, ws) != 0) {
        g_free(ws);
        return NULL;
    }
    wslay_event_config_set_max_recv_msg_length(ws->protocol,
                                               PEL_WEBSOCKET_MAX_MESSAGE);
    ws->fd = fd;
    ws->handlers = *handlers;
    ws->user = user;
    ws->early = g_memdup2(early, early_size);
    ws->early_size = early_size;
    ws->pong_ns = pel_now_ns();
    ws->ping_ns = ws->pong_ns + PING_NS;
    int size = SOCKET_BUFFER, on = 1;
    setsockopt(fd, SOL_SOCKET, SO_SNDBUF, &size, sizeof size);
    setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
    ws->source = pel_fdsource_create(fd, G_IO_IN, on_ready, ws);
    pel_fdsource_wake_at(ws->source, 0);
    return ws;
}

void pel_websocket_destroy(struct pel_websocket *ws)
{
    if (!ws) {
        return;
    }
    if (!ws->over && !ws->closing && ws->sent == 0) {
        pel_websocket_close(ws, WSLAY_CODE_GOING_AWAY, "the server stops");
        flush(ws);
    }
    pel_fdsource_destroy(ws->source);
    while (ws->count > 0) {
        drop_picture(ws);
    }
    wslay_event_context_free(ws->protocol);
    g_free(ws->early);
    g_free(ws);
}

/* Has the loop look at it: nothing is torn down under a caller. */
static void soon(struct pel_websocket *ws)
{
    pel_fdsource_wake_at(ws->source, 0);
}

void pel_websocket_text(struct pel_websocket *ws, const char *text)
{
    struct wslay_event_msg message = {
        .opcode = WSLAY_TEXT_FRAME,
        .msg = (const uint8_t *)text,
        .msg_length = strlen(text),
    };
    if (ws->over || ws->closing) {
        return;
    }
    ws->over = wslay_event_get_queued_msg_count(ws->protocol) >=
                   PEL_WEBSOCKET_MAX_CONTROL ||
               wslay_event_queue_msg(ws->protocol, &message) != 0;
    soon(ws);
}

bool pel_websocket_picture(struct pel_websocket *ws, const uint8_t *head,
                           size_t head_size, struct pel_frame *frame)
{
    if (ws->over || ws->closing || ws->count == PEL_WEBSOCKET_MAX_PICTURES ||
        head_size > PEL_WEBSOCKET_MAX_HEAD) {
        return false;
    }
    struct picture *p =
        &ws->ring[(ws->first + ws->count) % PEL_WEBSOCKET_MAX_PICTURES];
    uint64_t size = head_size + frame->size;
    size_t n = 0;
    p->head[n++] = 0x80 | WSLAY_BINARY_FRAME; /* whole, unmasked */
    int bytes = size < 126 ? 0 : size < 65536 ? 2 : 8;
    p->head[n++] = (uint8_t)(bytes == 0 ? size : bytes == 2 ? 126 : 127);
    for (int i = bytes - 1; i >= 0; i--) {
        p->head[n++] = (uint8_t)(size >> (8 * i));
    }
    memcpy(p->head + n, head, head_size);
    p->head_size = n + head_size;
    p->frame = pel_frame_ref(frame);
    ws->count++;
    if (ws->count == 1) {
        flush(ws);
        if (ws->over) {
            soon(ws);
        }
    }
    return true;
}

void pel_websocket_close(struct pel_websocket *ws, uint16_t code,
                         const char *reason)
{
    if (!ws->closing && !ws->over) {
        ws->closing = true;
        ws->close_ns = pel_now_ns() + CLOSE_LIMIT_NS;
        ws->code = code;
        g_strlcpy(ws->reason, reason, sizeof ws->reason);
        soon(ws);
    }
}
