/* Bytes on their way to a slow reader: owned buffers and shared pictures in
 * order, without copies. The owner of the outbox bounds what it adds. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <glib.h>

#include "frames/frames.h"

struct pel_outbox {
    GQueue chunks;
    size_t bytes;  /* waiting in all */
    size_t offset; /* sent of the first chunk */
};

void pel_outbox_init(struct pel_outbox *box);
void pel_outbox_finish(struct pel_outbox *box);

/* Takes over malloc()ed data. */
void pel_outbox_add(struct pel_outbox *box, uint8_t *data, size_t size);

/* The encoded picture's bytes; takes a reference. */
void pel_outbox_add_frame(struct pel_outbox *box, struct pel_frame *frame);

enum pel_outbox_result {
    PEL_OUTBOX_EMPTY,
    PEL_OUTBOX_WAITING, /* the reader takes no more for now */
    PEL_OUTBOX_GONE,    /* the reader has closed or failed */
};

/* Sends what the socket takes now; *sent counts it. */
enum pel_outbox_result pel_outbox_flush(struct pel_outbox *box, int fd,
                                        size_t *sent);
