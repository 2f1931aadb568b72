/* Framing on byte streams: each message is preceded by its length as a base-128
 * varint (the delimited form of every protobuf library). No state: the caller
 * keeps the bytes. Any thread. */
#pragma once

#include <protobuf-c/protobuf-c.h>
#include <stddef.h>
#include <stdint.h>

#include "bounds.h"

/* Bytes of one inbound message. */
#define PEL_WIRE_MAX_REQUEST PEL_BOUND_SESSION_MESSAGE_BYTES
#define PEL_WIRE_MAX_PREFIX 5 /* lengths below 2^32 */

enum pel_wire {
    PEL_WIRE_MORE,      /* not all there yet: read on */
    PEL_WIRE_MESSAGE,   /* data[*offset .. *offset + *length) is a message */
    PEL_WIRE_MALFORMED, /* no varint, or longer than 5 bytes: close */
    PEL_WIRE_TOO_LONG,  /* *length is above the limit: refuse and close */
};

/* Looks for one message at the start of `size` bytes. *offset + *length bytes
 * are used up by a message. For MORE with the prefix complete, *length is that
 * of the message to come, else 0. */
enum pel_wire pel_wire_next(const uint8_t *data, size_t size, size_t limit,
                            size_t *offset, size_t *length);

/* Writes the prefix of a message of `length` (< 2^32) bytes; its size. */
size_t pel_wire_prefix(size_t length, uint8_t out[PEL_WIRE_MAX_PREFIX]);

/* Prefix and message in one buffer of *size bytes; free(). */
uint8_t *pel_wire_pack(const ProtobufCMessage *message, size_t *size);
