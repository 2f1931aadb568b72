#include "net/outbox.h"

#include <errno.h>
#include <stdlib.h>
#include <sys/socket.h>
#include <sys/uio.h>

#define GATHER 16

struct chunk {
    uint8_t *owned;
    struct pel_frame *frame;
    const uint8_t *data;
    size_t size;
};

static void chunk_free(void *data)
{
    struct chunk *chunk = data;
    free(chunk->owned);
    pel_frame_unref(chunk->frame);
    g_free(chunk);
}

void pel_outbox_init(struct pel_outbox *box)
{
    *box = (struct pel_outbox){ .bytes = 0 };
    g_queue_init(&box->chunks);
}

void pel_outbox_finish(struct pel_outbox *box)
{
    g_queue_clear_full(&box->chunks, chunk_free);
    box->bytes = 0;
    box->offset = 0;
}

static void push(struct pel_outbox *box, struct chunk chunk)
{
    struct chunk *kept = g_new(struct chunk, 1);
    *kept = chunk;
    g_queue_push_tail(&box->chunks, kept);
    box->bytes += chunk.size;
}

void pel_outbox_add(struct pel_outbox *box, uint8_t *data, size_t size)
{
    push(box, (struct chunk){ .owned = data, .data = data, .size = size });
}

void pel_outbox_add_frame(struct pel_outbox *box, struct pel_frame *frame)
{
    push(box, (struct chunk){ .frame = pel_frame_ref(frame),
                              .data = frame->data,
                              .size = frame->size });
}

static void forget_sent(struct pel_outbox *box, size_t sent)
{
    box->bytes -= sent;
    box->offset += sent;
    for (struct chunk *first = g_queue_peek_head(&box->chunks);
         first && box->offset >= first->size;
         first = g_queue_peek_head(&box->chunks)) {
        box->offset -= first->size;
        chunk_free(g_queue_pop_head(&box->chunks));
    }
}

enum pel_outbox_result pel_outbox_flush(struct pel_outbox *box, int fd,
                                        size_t *sent)
{
    *sent = 0;
    while (box->bytes > 0) {
        struct iovec parts[GATHER];
        struct msghdr message = { .msg_iov = parts };
        size_t skip = box->offset;
        for (GList *l = box->chunks.head; l && message.msg_iovlen < GATHER;
             l = l->next) {
            const struct chunk *chunk = l->data;
            parts[message.msg_iovlen++] = (struct iovec){
                .iov_base = (void *)(chunk->data + skip),
                .iov_len = chunk->size - skip,
            };
            skip = 0;
        }
        ssize_t n = sendmsg(fd, &message, MSG_NOSIGNAL | MSG_DONTWAIT);
        if (n < 0 && errno == EINTR) {
            continue;
        }
        if (n < 0) {
            return errno == EAGAIN || errno == EWOULDBLOCK ? PEL_OUTBOX_WAITING
                                                           : PEL_OUTBOX_GONE;
        }
        *sent += (size_t)n;
        forget_sent(box, (size_t)n);
    }
    return PEL_OUTBOX_EMPTY;
}
