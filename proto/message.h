/* Generic operations on messages of the schema over protobuf-c's descriptors.
 * Messages are on the heap as protobuf_c_message_free_unpacked(m, NULL) (or
 * pelagos__x__free_unpacked) expects; that function frees them. Any thread,
 * one message at a time. */
#pragma once

#include <protobuf-c/protobuf-c.h>
#include <stdbool.h>
#include <stddef.h>

/* An empty message: nothing present. */
ProtobufCMessage *pel_message_new(const ProtobufCMessageDescriptor *type);

/* A deep copy of what the schema knows. */
ProtobufCMessage *pel_message_copy(const ProtobufCMessage *message);

/* The same, made of `old`, a message of that type (NULL: of nothing), which
 * is given up: where the two are much alike that allocates next to nothing. */
ProtobufCMessage *pel_message_copy_onto(ProtobufCMessage *old,
                                        const ProtobufCMessage *message);

/* Whether both, of one type, have the same bytes on the wire. */
bool pel_message_same(const ProtobufCMessage *a, const ProtobufCMessage *b);

/* Drops what the schema does not know, all the way down, of a message that an
 * allocator of its own keeps (unpack.h): nothing is freed. What protobuf-c
 * packs of such fields it may not be able to read again. */
void pel_message_forget_unknown(ProtobufCMessage *message);

/* Whether a field is there: set, or a list with elements. */
bool pel_message_has(const ProtobufCMessage *message,
                     const ProtobufCFieldDescriptor *field);

/* Frees the value of a field; it is then absent, a list empty. */
void pel_message_clear(ProtobufCMessage *message,
                       const ProtobufCFieldDescriptor *field);

/* Gives an absent field its default of the schema; false: it has none. */
bool pel_message_default(ProtobufCMessage *message,
                         const ProtobufCFieldDescriptor *field);

/* The message in a singular field, made if absent. */
ProtobufCMessage *pel_message_child(ProtobufCMessage *message,
                                    const ProtobufCFieldDescriptor *field);

/* Elements of a list of messages; *count of them. */
ProtobufCMessage **pel_message_list(const ProtobufCMessage *message,
                                    const ProtobufCFieldDescriptor *field,
                                    size_t *count);

/* Appends an empty element to a list of messages. */
ProtobufCMessage *pel_message_append(ProtobufCMessage *message,
                                     const ProtobufCFieldDescriptor *field);

/* Takes element `index` out of a list of messages and frees it. */
void pel_message_remove(ProtobufCMessage *message,
                        const ProtobufCFieldDescriptor *field, size_t index);

/* Address of the value (the first element's array pointer for a list). */
void *pel_message_member(const ProtobufCMessage *message,
                         const ProtobufCFieldDescriptor *field);

/* Bytes of one value: sizeof(double), sizeof(char *), … */
size_t pel_message_value_size(const ProtobufCFieldDescriptor *field);

/* Marks a scalar as present (after writing its member), or a oneof's case. */
void pel_message_mark(ProtobufCMessage *message,
                      const ProtobufCFieldDescriptor *field);

/* A number field's value as a double: int, uint, float, double, enum, bool.
 * False: the field is a string, bytes or message. */
bool pel_message_number(const ProtobufCMessage *message,
                        const ProtobufCFieldDescriptor *field, double *value);

/* Sets a string (copied). */
void pel_message_set_string(ProtobufCMessage *message,
                            const ProtobufCFieldDescriptor *field,
                            const char *text);

/* Appends a string to a list of strings (copied). */
void pel_message_append_string(char ***list, size_t *count, const char *text);
