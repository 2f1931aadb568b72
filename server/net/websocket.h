/* One WebSocket (RFC 6455) on a socket whose handshake is done: control
 * messages and pictures out, binary messages in. No extensions. Pictures go
 * out from the encoder's own bytes, shared by all who watch. Control thread. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "bounds.h"
#include "frames/frames.h"

#define PEL_WEBSOCKET_MAX_HEAD 80     /* bytes before a picture */
#define PEL_WEBSOCKET_MAX_PICTURES 16 /* that wait or are being sent */
#define PEL_WEBSOCKET_MAX_CONTROL 32  /* messages that wait */
#define PEL_WEBSOCKET_MAX_MESSAGE PEL_BOUND_LIVE_MESSAGE_BYTES
#define PEL_WEBSOCKET_MAX_FRAGMENTS PEL_BOUND_LIVE_FRAGMENTS

/* Sec-WebSocket-Accept for a Sec-WebSocket-Key; false: no such key (16 bytes
 * in base64). Any thread. */
bool pel_websocket_accept_key(const char *key, char out[32]);

struct pel_websocket;

struct pel_websocket_handlers {
    /* A whole binary message; may close, must not destroy. */
    void (*on_message)(void *user, const uint8_t *data, size_t size);
    /* What came is too long or no WebSocket: said once, and closing. */
    void (*on_broken)(void *user);
    /* The connection is over, said once; destroy it here. */
    void (*on_closed)(void *user);
};

/* `early`: bytes that came with the handshake. The socket stays the caller's
 * and is closed after pel_websocket_destroy. NULL: no memory. */
struct pel_websocket *
pel_websocket_create(int fd, const char *early, size_t early_size,
                     const struct pel_websocket_handlers *handlers, void *user);
/* Says 1001 (going away) if nothing was said yet. NULL allowed. */
void pel_websocket_destroy(struct pel_websocket *ws);

/* Queues a text message, before pictures that wait. It is never dropped: where
 * there is no room the connection ends. */
void pel_websocket_text(struct pel_websocket *ws, const char *text);

/* Queues a binary message of `head` and the frame's bytes (takes a reference);
 * false: no room. */
bool pel_websocket_picture(struct pel_websocket *ws, const uint8_t *head,
                           size_t head_size, struct pel_frame *frame);

/* Sends a close frame after what is being sent; on_closed follows. */
void pel_websocket_close(struct pel_websocket *ws, uint16_t code,
                         const char *reason);
