/* Limits on the messages of an RTSP client. GStreamer bounds a
 * body but not the number of header lines, and reads everything that has come;
 * so its connections read through this stream, which fails at the limits. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <gio/gio.h>

#include "bounds.h"

#define PEL_RTSP_BODY_BYTES PEL_BOUND_RTSP_BODY_BYTES
#define PEL_RTSP_HEAD_BYTES PEL_BOUND_RTSP_HEAD_BYTES

/* Where in the stream of messages a connection is; { 0 } at its begin. */
struct pel_rtsp_framing {
    enum {
        PEL_RTSP_AT_MESSAGE,
        PEL_RTSP_IN_HEAD,
        PEL_RTSP_IN_BODY,
        PEL_RTSP_IN_CHUNK, /* '$', channel, length in two bytes, data */
    } state;
    bool broken;
    size_t head;        /* bytes of this head */
    char line[64];      /* the begin of this line */
    size_t line_length; /* of all of it */
    bool has_length;
    size_t left;     /* of the body or the chunk */
    unsigned prefix; /* bytes of the chunk's */
    /* Whether the client may name this session; NULL: any. */
    bool (*may_use)(const void *who, const char *session);
    const void *who;
};

/* Takes what came. False from then on when a head or a body is larger than
 * allowed, when it is no RTSP (its tunnel through HTTP is not spoken), when two
 * readers could disagree about its end, or when it names a session that
 * may_use does not allow. */
bool pel_rtsp_framing_take(struct pel_rtsp_framing *framing,
                           const uint8_t *data, size_t size);

/* A socket whose connection, as GIO makes it, breaks off so; NULL: it is none,
 * and the descriptor stays the caller's. */
GSocket *pel_rtsp_guarded_socket(int fd);

/* Connections that broke off so, of all. Any thread. */
uint64_t pel_rtsp_guard_broken(void);

/* What has come and was not read yet has in its heads: the value of the first
 * Authorization, g_free(), or NULL. *waits: something has come. Any thread. */
char *pel_rtsp_guard_peek(GSocket *socket, bool *waits);

/* As if the client of such a socket had left, whatever it has sent. Any thread;
 * the connection's own thread sees it with its next read. */
void pel_rtsp_guard_end(GSocket *socket);

/* A session is of the connection that set it up: any other that names it breaks
 * off before GStreamer, which would let it play, pause and end the session. Any
 * thread. */
void pel_rtsp_guard_own(GSocket *socket, const char *session);
void pel_rtsp_guard_disown(const char *session);
