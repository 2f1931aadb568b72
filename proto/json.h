/* JSON for every message of the schema: proto3's JSON mapping, generic over
 * protobuf-c's descriptors. Names are lowerCamelCase (the schema's own are
 * accepted too), enums by name (or number), bytes base64, 64-bit integers
 * strings (or numbers when read). Lists with a key may be given as objects of
 * their elements, {"3": {…}} (within a Patch, null there removes the element,
 * or resets the element's field, as in a merge patch). Elements of lists
 * without a key may be given as arrays of their fields in the schema's order:
 * points [[0, 5], [3, 4]].
 *
 * Reading is strict RFC 8259: UTF-8, no comments, no duplicate names, at most
 * PEL_JSON_MAX_DEPTH levels; NaN and infinity are refused. Faults: MALFORMED
 * (not JSON), NOT_FOUND (no such field), INVALID (wrong type or form),
 * OUT_OF_RANGE (does not fit the type); they name the full path
 * (`views.bridge.yaw`). Legal ranges are the scene's business. Numbers do not
 * depend on the locale. Any thread. */
#pragma once

#include <protobuf-c/protobuf-c.h>
#include <stdbool.h>
#include <stddef.h>

#include "base/err.h"
#include "bounds.h"
#include "pelagos.pb-c.h"

#define PEL_JSON_MAX_DEPTH PEL_BOUND_JSON_DEPTH
#define PEL_JSON_MAX_BYTES (1 << 20)

/* The fields that are present, as one JSON object; free(). */
char *pel_json_from_message(const ProtobufCMessage *message, bool pretty);

/* The value of one field, a list as an array; free(). */
char *pel_json_from_field(const ProtobufCMessage *message,
                          const ProtobufCFieldDescriptor *field, bool pretty);

/* A new message of the given type from `length` bytes of text; free with
 * protobuf_c_message_free_unpacked(m, NULL). null leaves a field absent.
 * `fault` may be NULL. */
PEL_CHECK enum pel_err
pel_json_to_message(const char *text, size_t length,
                    const ProtobufCMessageDescriptor *type,
                    ProtobufCMessage **out, struct pel_fault *fault);

/* An RFC 7396 merge patch on State: null becomes a `remove`, an array for a
 * keyed list replaces the list, an object for a keyed list merges by key
 * ({"views": {"bridge": {"yaw": 5}}}, null deletes that one; entities by id or
 * by unique name). Free with pelagos__patch__free_unpacked(p, NULL). */
PEL_CHECK enum pel_err pel_json_merge_patch(const char *text, size_t length,
                                            Pelagos__Patch **out,
                                            struct pel_fault *fault);

/* A text as a JSON string with its quotes, made valid UTF-8 first; free(). All
 * JSON that is put together from texts takes them from here. */
char *pel_json_string(const char *text);

/* The shortest text that reads back as the same double ("0.1", "1e+20");
 * `out` holds at least 32 bytes. Not for NaN or infinity. */
void pel_json_number(double value, char out[32]);
