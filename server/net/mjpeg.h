/* One viewer of a live view: multipart/x-mixed-replace over a content reader.
 * It holds the picture that is being sent and the newest one that waits;
 * pictures in between are dropped and counted. Control thread. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <sys/types.h>

#include "frames/frames.h"

#define PEL_MJPEG_TYPE "multipart/x-mixed-replace; boundary=pelagos"

struct pel_mjpeg_stats {
    unsigned viewers;
    uint64_t sent, dropped, bytes;
};

struct pel_viewer;

/* `wake` is called when pel_viewer_read has something again after it returned
 * 0. fps 0: every frame. Errors as pel_frames_subscribe. */
PEL_CHECK enum pel_err
pel_viewer_create(struct pel_frames *frames, const char *view, int quality,
                  double fps, const struct pel_who *who,
                  struct pel_mjpeg_stats *stats, void (*wake)(void *user),
                  void *user, struct pel_viewer **out, struct pel_fault *fault);
void pel_viewer_destroy(struct pel_viewer *viewer); /* NULL allowed */

/* Copies the next bytes of the stream: their number, 0: none now, -1: the view
 * is gone and everything is sent. */
ssize_t pel_viewer_read(struct pel_viewer *viewer, char *out, size_t size);
