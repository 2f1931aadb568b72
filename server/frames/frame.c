#include <stddef.h>
#include <stdlib.h>

#include "base/heap.h"
#include "frames/job.h"

/* Freeing more takes the control thread too long: 0.1 ms a MiB. */
#define FREED_AT_ONCE (1u << 20)

/* The public part first: a reference to it is one to the whole. */
struct frame {
    struct pel_frame public;
    struct pel_discard discard;
    struct pel_bytes bytes;
    atomic_int references;
};

struct pel_frame *pel_frame_create(void)
{
    struct frame *frame = calloc(1, sizeof *frame);
    if (!frame) {
        return NULL;
    }
    atomic_init(&frame->references, 1);
    return &frame->public;
}

void pel_frame_set_bytes(struct pel_frame *frame, struct pel_bytes *bytes)
{
    struct frame *f = (struct frame *)frame;
    f->bytes = *bytes;
    f->public.data = bytes->data;
    f->public.size = bytes->size;
    *bytes = (struct pel_bytes){ 0 };
}

struct pel_frame *pel_frame_ref(struct pel_frame *frame)
{
    struct frame *f = (struct frame *)frame;
    atomic_fetch_add(&f->references, 1);
    return frame;
}

static void destroy(struct frame *frame)
{
    pel_bytes_finish(&frame->bytes);
    free(frame);
}

static void drop(struct pel_discard *discard)
{
    char *at = (char *)discard - offsetof(struct frame, discard);
    destroy((struct frame *)at);
}

void pel_frame_unref(struct pel_frame *frame)
{
    struct frame *f = (struct frame *)frame;
    if (!f || atomic_fetch_sub(&f->references, 1) != 1) {
        return;
    }
    if (f->bytes.size > FREED_AT_ONCE) {
        f->discard.drop = drop;
        pel_heap_discard(&f->discard);
    } else {
        destroy(f);
    }
}

struct pel_track *pel_track_create(const struct pel_video_config *config)
{
    struct pel_track *track = calloc(1, sizeof *track);
    if (!track) {
        return NULL;
    }
    atomic_init(&track->references, 1);
    track->codec = config->vp8 ? PEL_CODEC_VP8 : PEL_CODEC_H264;
    track->video = pel_video_create(config);
    if (!track->video) {
        free(track);
        return NULL;
    }
    return track;
}

struct pel_track *pel_track_ref(struct pel_track *track)
{
    atomic_fetch_add(&track->references, 1);
    return track;
}

void pel_track_unref(struct pel_track *track)
{
    if (track && atomic_fetch_sub(&track->references, 1) == 1) {
        pel_video_destroy(track->video);
        free(track);
    }
}

int64_t pel_frame_present_us(const struct pel_frame *frame, int64_t now_ns,
                             int64_t unix_ns)
{
    return frame->present_unix_ns > 0
               ? (int64_t)(frame->present_unix_ns / 1000)
               : (unix_ns - now_ns + frame->present_ns) / 1000;
}
