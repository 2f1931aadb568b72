/* Views as HTTP Live Streaming (RFC 8216, and the low-latency parts of its
 * second edition): H.264 in transport streams of a second or two, of which
 * proxies keep copies for thousands of viewers. A stream is made by the first
 * who asks for its playlist, encoded once for all, and ends when nobody has
 * asked for PEL_HLS_IDLE_S. Control thread. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/metrics.h"
#include "frames/frames.h"

#define PEL_HLS_PLAYLIST_TYPE "application/vnd.apple.mpegurl"
#define PEL_HLS_TARGET_S 2 /* no segment is longer, rounded */
#define PEL_HLS_PART_S 0.6 /* no part is longer */
#define PEL_HLS_LISTED 8   /* segments in a playlist */
#define PEL_HLS_KEPT 12    /* segments that can still be had */
/* Of all streams; fewer segments are kept then. */
#define PEL_HLS_MOST_BYTES (256 << 20)
#define PEL_HLS_WAIT_S 6 /* for what is not there yet, then BUSY */
#define PEL_HLS_IDLE_S 15

struct pel_hls;

struct pel_hls *pel_hls_create(struct pel_frames *frames);
/* Who waits is told that the daemon stops. NULL allowed. */
void pel_hls_destroy(struct pel_hls *hls);

/* What is asked for: a playlist of a view, as it is or (msn ≥ 0) once it has
 * segment `msn`, or (part ≥ 0) that part of it. */
struct pel_hls_wish {
    char view[PEL_NAME_SIZE];
    struct pel_profile profile;
    int64_t msn, part; /* −1: none */
};

struct pel_hls_answer {
    const char *type;
    const char *cache; /* Cache-Control */
    const void *data;  /* borrowed for the call */
    size_t size;
};

/* Called once, during the call or later; answer NULL with an error. */
typedef void (*pel_hls_done)(void *user, enum pel_err err,
                             const struct pel_fault *fault,
                             const struct pel_hls_answer *answer);

/* As pel_frames_open; BUSY also where it did not come; OUT_OF_RANGE: a segment
 * further ahead than the next one. */
void pel_hls_playlist(struct pel_hls *hls, const struct pel_hls_wish *wish,
                      pel_hls_done done, void *user);

/* A segment or a part by its name in a playlist, the next part too, which is
 * waited for. NOT_FOUND. */
void pel_hls_file(struct pel_hls *hls, const char *name, pel_hls_done done,
                  void *user);

/* Nobody waits any more for what was asked with this user: `done` is not
 * called. False: nobody did. */
bool pel_hls_forget(struct pel_hls *hls, const void *user);

void pel_hls_collect(const struct pel_hls *hls, struct pel_metrics_page *page);
