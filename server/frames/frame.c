#include <stdlib.h>

#include "frames/job.h"

/* The public part first: a reference to it is one to the whole. */
struct frame {
    struct pel_frame public;
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

void pel_frame_unref(struct pel_frame *frame)
{
    struct frame *f = (struct frame *)frame;
    if (f && atomic_fetch_sub(&f->references, 1) == 1) {
        pel_bytes_finish(&f->bytes);
        free(f);
    }
}
