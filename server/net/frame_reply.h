/* Replies with pictures, whose bytes are not copied. Control thread. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "frames/frames.h"
#include "net/outbox.h"

/* Adds the delimited bytes of a Reply with this frame. */
void pel_frame_reply_add(struct pel_outbox *out, bool has_id, uint64_t id,
                         struct pel_frame *picture);

/* Adds those of a Reply with these Frames. */
void pel_frames_reply_add(struct pel_outbox *out, bool has_id, uint64_t id,
                          struct pel_frame *const *pictures, size_t count);
