/* Encoders of H.264 and VP8: pictures of one stream in, access units out. They
 * are GStreamer's, chosen at run time: of H.264 hardware's first, then x264,
 * then openh264; of VP8 libvpx. No GL, no sockets. An encoder is used by one
 * thread at a time. */
#pragma once

#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>

#include "base/err.h"
#include "encode/encode.h"

struct pel_video;

/* Smallest and largest width and height [px] and rate [kbit/s]. */
#define PEL_VIDEO_MIN_SIZE 16
#define PEL_VIDEO_MAX_SIZE 4096
#define PEL_VIDEO_MIN_KBPS 100
#define PEL_VIDEO_MAX_KBPS 100000

/* One picture. An odd width or height loses its last column or row: 4:2:0 has
 * none. */
struct pel_video_picture {
    const uint8_t *rgba;                   /* top row first, tightly packed */
    const struct pel_planes_given *planes; /* instead: studio range, pairs */
    uint32_t width, height;
    uint32_t out_width, out_height; /* scaled to it; 0: as it is */
    int64_t stamp_ns;               /* any clock that does not run backwards */
    bool key;                       /* make it a key frame */
};

struct pel_video_config {
    bool vp8;            /* instead of H.264 */
    const char *encoder; /* of H.264, GStreamer's name; NULL or "auto": the best
                          * there is; lives as long as the encoder */
    double fps;          /* nominal, for the rate control */
    const atomic_bool *cancel; /* NULL, or true: give up with CONFLICT */
};

/* Whether `name` can be such an encoder; INVALID names those that can. Whether
 * it is installed is known at the first picture. */
PEL_CHECK enum pel_err pel_video_check_encoder(const char *name,
                                               struct pel_fault *fault);

/* Cheap: GStreamer is started by the first picture. NULL: no memory. */
struct pel_video *pel_video_create(const struct pel_video_config *config);
void pel_video_destroy(struct pel_video *video); /* NULL allowed */

/* Encodes one picture at `kbps`; a new size begins a new sequence. *out gets an
 * Annex B access unit, with SPS and PPS where *key says key frame, or a frame
 * of VP8. Blocks until it is there. NOT_FOUND: no encoder works here (*fault
 * says which packages have one); INVALID: size or rate outside their range;
 * CONFLICT: cancelled; INTERNAL: it failed and restarts with the next
 * picture; NO_MEMORY. */
PEL_CHECK enum pel_err pel_video_encode(struct pel_video *video,
                                        const struct pel_video_picture *picture,
                                        unsigned kbps, struct pel_bytes *out,
                                        bool *key, struct pel_fault *fault);

/* GStreamer's name of the encoder in use, "" before the first picture. */
const char *pel_video_encoder(const struct pel_video *video);

/* A rate that suits this size at 30 Hz [kbit/s]: 5000 for 1280x720. */
unsigned pel_video_kbps(uint32_t width, uint32_t height);
