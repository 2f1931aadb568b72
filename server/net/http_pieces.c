/* Bodies that lie in memory, a block at a time: given a body of megabytes, one
 * turn of the library hands the system as much as the other end takes, and
 * that costs the control thread a millisecond a megabyte. */
#include <string.h>

#include "base/heap.h"
#include "net/http_client.h"

#define BLOCK 65536

struct body {
    struct pel_discard discard;
    MHD_ContentReaderFreeCallback drop;
    void *what;
    size_t size, count;
    struct MHD_IoVec pieces[];
};

static ssize_t read_block(void *user, uint64_t at, char *to, size_t room)
{
    const struct body *body = user;
    size_t given = 0;
    for (size_t i = 0; i < body->count && given < room; i++) {
        const struct MHD_IoVec *piece = &body->pieces[i];
        if (at >= piece->iov_len) {
            at -= piece->iov_len;
            continue;
        }
        size_t rest = piece->iov_len - at;
        size_t size = rest < room - given ? rest : room - given;
        memcpy(to + given, (const char *)piece->iov_base + at, size);
        given += size;
        at = 0;
    }
    return (ssize_t)given;
}

static void destroy(struct pel_discard *self)
{
    struct body *body = (struct body *)self;
    if (body->drop) {
        body->drop(body->what);
    }
    g_free(body);
}

static void end(void *user)
{
    struct body *body = user;
    if (body->size > BLOCK) {
        pel_heap_discard(&body->discard);
    } else {
        destroy(&body->discard);
    }
}

struct MHD_Response *pel_http_pieces(const struct MHD_IoVec *pieces,
                                     size_t count,
                                     MHD_ContentReaderFreeCallback drop,
                                     void *what)
{
    struct body *body = g_malloc0(sizeof *body + count * sizeof *pieces);
    body->discard.drop = destroy;
    body->drop = drop;
    body->what = what;
    body->count = count;
    for (size_t i = 0; i < count; i++) {
        body->pieces[i] = pieces[i];
        body->size += pieces[i].iov_len;
    }
    struct MHD_Response *response =
        count == 1 && body->size <= BLOCK
            ? MHD_create_response_from_buffer_with_free_callback_cls(
                  body->size, (void *)pieces->iov_base, end, body)
            : MHD_create_response_from_callback(body->size, BLOCK, read_block,
                                                body, end);
    if (!response) {
        end(body);
    }
    return response;
}
