#include "net/frame_reply.h"

#include <string.h>

#include "pelagos.pb-c.h"
#include "wire.h"

enum {
    LENGTH_DELIMITED = 2,
    FRAME_DATA = 8,
    FRAMES_FRAME = 1,
    REPLY_FRAME = 4,
    REPLY_FRAMES = 8
};

#define TAG_SIZE (1 + PEL_WIRE_MAX_PREFIX)

/* A field's tag and length. */
struct tag {
    uint8_t bytes[TAG_SIZE];
    size_t size;
};

static struct tag make_tag(unsigned field, size_t length)
{
    struct tag tag = { .bytes = { (uint8_t)(field << 3 | LENGTH_DELIMITED) } };
    tag.size = 1 + pel_wire_prefix(length, tag.bytes + 1);
    return tag;
}

static uint8_t *put(uint8_t *at, const uint8_t *bytes, size_t size)
{
    memcpy(at, bytes, size);
    return at + size;
}

/* A Frame without its data. */
static Pelagos__Frame describe(const struct pel_frame *p)
{
    Pelagos__Frame message = PELAGOS__FRAME__INIT;
    message.view = (char *)p->view;
    message.has_number = message.has_time = message.has_revision = true;
    message.number = p->number;
    message.time = p->time_s;
    message.revision = p->revision;
    message.has_stale = true;
    message.stale = p->stale != 0;
    message.has_in_ground = message.in_ground = p->in_ground;
    message.has_host_frame = p->host_frame != 0;
    message.host_frame = p->host_frame;
    message.has_width = message.has_height = message.has_format = true;
    message.width = p->width;
    message.height = p->height;
    message.format = p->format;
    message.has_render_ms = message.has_encode_ms = true;
    message.render_ms = p->render_ms;
    message.encode_ms = p->encode_ms;
    message.has_device = true;
    message.device = p->device;
    return message;
}

/* A picture as a field of the message around it. Its data is the last field of
 * Frame, so that it need not be copied: the lengths around it are known. */
struct part {
    Pelagos__Frame message;
    struct tag outer, data;
    size_t head; /* bytes before the picture's own */
    size_t size; /* with them */
};

static struct part make_part(const struct pel_frame *picture, unsigned field)
{
    struct part part = { .message = describe(picture),
                         .data = make_tag(FRAME_DATA, picture->size) };
    size_t fields = pelagos__frame__get_packed_size(&part.message);
    size_t inner = fields + part.data.size + picture->size;
    part.outer = make_tag(field, inner);
    part.head = part.outer.size + fields + part.data.size;
    part.size = part.outer.size + inner;
    return part;
}

static uint8_t *put_part(uint8_t *at, const struct part *part)
{
    at = put(at, part->outer.bytes, part->outer.size);
    at += pelagos__frame__pack(&part->message, at);
    return put(at, part->data.bytes, part->data.size);
}

/* The length, the Reply's own fields and `extra` bytes of room for what comes
 * next of the `inside` bytes that follow; *at points to the room. */
static uint8_t *begin(bool has_id, uint64_t id, size_t inside, size_t extra,
                      size_t *size, uint8_t **at)
{
    Pelagos__Reply reply = PELAGOS__REPLY__INIT;
    reply.has_id = has_id;
    reply.id = id;
    uint8_t prefix[PEL_WIRE_MAX_PREFIX];
    size_t own = pelagos__reply__get_packed_size(&reply);
    size_t prefix_size = pel_wire_prefix(own + inside, prefix);
    *size = prefix_size + own + extra;
    uint8_t *out = g_malloc(*size);
    *at = put(out, prefix, prefix_size);
    *at += pelagos__reply__pack(&reply, *at);
    return out;
}

void pel_frame_reply_add(struct pel_outbox *out, bool has_id, uint64_t id,
                         struct pel_frame *picture)
{
    struct part part = make_part(picture, REPLY_FRAME);
    size_t size;
    uint8_t *at;
    uint8_t *head = begin(has_id, id, part.size, part.head, &size, &at);
    put_part(at, &part);
    pel_outbox_add(out, head, size);
    pel_outbox_add_frame(out, picture);
}

void pel_frames_reply_add(struct pel_outbox *out, bool has_id, uint64_t id,
                          struct pel_frame *const *pictures, size_t count)
{
    size_t inner = 0, size;
    uint8_t *at;
    for (size_t i = 0; i < count; i++) {
        inner += make_part(pictures[i], FRAMES_FRAME).size;
    }
    struct tag tag = make_tag(REPLY_FRAMES, inner);
    uint8_t *head = begin(has_id, id, tag.size + inner, tag.size, &size, &at);
    put(at, tag.bytes, tag.size);
    pel_outbox_add(out, head, size);
    for (size_t i = 0; i < count; i++) {
        struct part part = make_part(pictures[i], FRAMES_FRAME);
        uint8_t *bytes = g_malloc(part.head);
        put_part(bytes, &part);
        pel_outbox_add(out, bytes, part.head);
        pel_outbox_add_frame(out, pictures[i]);
    }
}
