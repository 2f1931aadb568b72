/* Memory for one unpacked message at a time: thousands of small messages in it
 * cost one allocation, and freeing them nothing. One thread. */
#pragma once

#include <protobuf-c/protobuf-c.h>
#include <stdint.h>

#define PEL_UNPACK_BLOCK (192 * 1024) /* a query of 3,000 points */

struct pel_unpack {
    ProtobufCAllocator allocator; /* for NAME__unpack */
    uint8_t *block;
    size_t used;
    struct pel_unpack_more *more; /* what did not fit */
};

void pel_unpack_init(struct pel_unpack *unpack);
/* Ends the life of the message: instead of NAME__free_unpacked. */
void pel_unpack_reset(struct pel_unpack *unpack);
void pel_unpack_finish(struct pel_unpack *unpack);
