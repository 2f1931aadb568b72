/* Files of moving pictures. One thread. */
#pragma once

#include <stddef.h>
#include <stdint.h>

struct clip;

/* Made from JPEGs. Opens `path` by its ending: .mjpeg (bare JPEGs), .mkv
 * (Motion-JPEG), .mp4 (H.264 by GStreamer's x264enc or openh264enc). NULL: *why
 * (g_free) says why, with the package that is missing if one is. stop: not 0
 * ends every wait. */
struct clip *clip_open(const char *path, uint32_t width, uint32_t height,
                       double fps, const volatile int *stop, char **why);

/* Adds one JPEG shown from time_s on. 0, or -1 and *why. */
int clip_add(struct clip *clip, const uint8_t *jpeg, size_t size, double time_s,
             char **why);

/* Ends the file and frees; 0, or -1 and *why. */
int clip_close(struct clip *clip, char **why);

/* A live stream into a file, as it comes: nothing is encoded again. */
struct clip_stream {
    const char *url;   /* of an MPEG transport stream with H.264, http://… */
    const char *path;  /* .mkv or .mp4 */
    double seconds;    /* by the stream's own clock */
    const char *token; /* of an Authorization header, or NULL */
    const volatile int *stop; /* not 0: ends sooner */
    void (*progress)(void *user, double seconds, size_t frames); /* or NULL */
    void *user;
};

/* Blocks until the file is finished. *frames: pictures in it. 0, or -1 and
 * *why; what was written until then stays. */
int clip_stream(const struct clip_stream *wish, size_t *frames, char **why);
