/* One viewer of /v1/views/NAME/live: pictures with their header out,
 * acknowledgements and wishes in (proto/live.md). A viewer that does not keep
 * up delays no other: it gets no pictures until it has acknowledged, continues
 * at a key frame, and in H.264 at a lower rate. Control thread. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/metrics.h"
#include "frames/frames.h"

#define PEL_LIVE_HEADER 80  /* bytes before each picture */
#define PEL_LIVE_MESSAGE 16 /* bytes of each of the viewer's messages */
#define PEL_LIVE_VERSION 1

enum pel_live_message {
    PEL_LIVE_ACK = 1,
    PEL_LIVE_KEY = 2,
    PEL_LIVE_PROFILE = 3,
    PEL_LIVE_TIME = 4,
};

struct pel_live_stats {
    unsigned viewers;
    uint64_t sent, bytes, skipped, starved, malformed;
};

struct pel_live_wish {
    char view[PEL_NAME_SIZE];
    struct pel_profile profile;
    unsigned credit; /* 1..PEL_WEBSOCKET_MAX_PICTURES */
};

struct pel_live_viewer;

/* The viewer's message, taken apart. */
struct pel_live_order {
    enum pel_live_message type;
    uint64_t frame;             /* of ACK */
    struct pel_profile profile; /* of PROFILE: width, height, kbps, quality */
    uint64_t echo;              /* of TIME */
};

/* False: no message of the protocol. Any thread. */
bool pel_live_read(const uint8_t *data, size_t size,
                   struct pel_live_order *out);

/* The header of a picture; `missed`: how many the viewer was not sent so far,
 * `gap`: some of them just before this one. Any thread. */
void pel_live_header(const struct pel_frame *frame, int64_t now_ns,
                     int64_t unix_ns, uint32_t missed, bool gap,
                     uint8_t out[PEL_LIVE_HEADER]);

/* On a socket whose handshake is done; `closed` comes once, destroy it there.
 * NULL: no memory. A view that cannot be watched is told to the viewer. */
struct pel_live_viewer *pel_live_viewer_create(
    struct pel_frames *frames, const struct pel_live_wish *wish, int fd,
    const char *early, size_t early_size, struct pel_live_stats *stats,
    void (*closed)(void *user), void *user, struct pel_fault *fault);
void pel_live_viewer_destroy(struct pel_live_viewer *viewer); /* NULL allowed */

void pel_live_collect(const struct pel_live_stats *stats,
                      struct pel_metrics_page *page);
