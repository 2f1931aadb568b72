#include "wire.h"

#include <stdlib.h>

#include "base/reserve.h"

enum pel_wire pel_wire_next(const uint8_t *data, size_t size, size_t limit,
                            size_t *offset, size_t *length)
{
    uint64_t value = 0;
    size_t i = 0;
    *offset = 0;
    *length = 0;
    do {
        if (i == PEL_WIRE_MAX_PREFIX) {
            return PEL_WIRE_MALFORMED;
        }
        if (i == size) {
            return PEL_WIRE_MORE;
        }
        value |= (uint64_t)(data[i] & 0x7f) << (7 * i);
    } while (data[i++] & 0x80);
    *length = (size_t)value;
    if (value > limit) {
        return PEL_WIRE_TOO_LONG;
    }
    *offset = i;
    return size - i < value ? PEL_WIRE_MORE : PEL_WIRE_MESSAGE;
}

size_t pel_wire_prefix(size_t length, uint8_t out[PEL_WIRE_MAX_PREFIX])
{
    size_t i = 0;
    while (length >= 0x80 && i < PEL_WIRE_MAX_PREFIX - 1) {
        out[i++] = (uint8_t)(length | 0x80);
        length >>= 7;
    }
    out[i++] = (uint8_t)(length & 0x7f);
    return i;
}

uint8_t *pel_wire_pack(const ProtobufCMessage *message, size_t *size)
{
    size_t length = protobuf_c_message_get_packed_size(message);
    uint8_t *out = pel_sure_malloc(length + PEL_WIRE_MAX_PREFIX);
    size_t prefix = pel_wire_prefix(length, out);
    *size = prefix + protobuf_c_message_pack(message, out + prefix);
    return out;
}
