/* One reader of /v1/views/NAME/ts: H.264 in an MPEG transport stream, over a
 * content reader. It holds a few pictures; when they are not taken it is given
 * nothing until they are, and goes on with a key frame. Control thread. */
#pragma once

#include <stddef.h>
#include <stdint.h>
#include <sys/types.h>

#include "frames/frames.h"

#define PEL_TS_TYPE "video/mp2t"

struct pel_ts_stats {
    unsigned viewers;
    uint64_t sent, bytes, starved;
};

struct pel_ts_viewer;

/* As pel_viewer_create. */
PEL_CHECK enum pel_err
pel_ts_viewer_create(struct pel_frames *frames, const char *view,
                     const struct pel_profile *profile,
                     struct pel_ts_stats *stats, void (*wake)(void *user),
                     void *user, struct pel_ts_viewer **out,
                     struct pel_fault *fault);
void pel_ts_viewer_destroy(struct pel_ts_viewer *viewer); /* NULL allowed */

/* As pel_viewer_read. */
ssize_t pel_ts_viewer_read(struct pel_ts_viewer *viewer, char *out,
                           size_t size);
