/* The elements of a keyed list of a message by their keys, so that an edit of
 * a thousand elements of a list of hundreds looks at each but once. Any thread;
 * lists and messages are borrowed. */
#pragma once

#include <protobuf-c/protobuf-c.h>
#include <stdint.h>

#define PEL_LOOKUP_ROOM 4096 /* a power of two */

struct pel_lookup {
    const ProtobufCMessage *holder;
    const ProtobufCFieldDescriptor *field, *key;
    size_t count;                    /* elements of the list that are in here */
    uint16_t place[PEL_LOOKUP_ROOM]; /* index + 1; 0: none */
};

/* `field`: a list of messages that have a key. */
void pel_lookup_begin(struct pel_lookup *lookup, const ProtobufCMessage *holder,
                      const ProtobufCFieldDescriptor *field);

/* The first element with the key of `like`, among those that the list had at
 * the beginning and those that were appended to it since; NULL: none, or `like`
 * has no key. */
ProtobufCMessage *pel_lookup_find(struct pel_lookup *lookup,
                                  const ProtobufCMessage *like);

/* The first element whose key an earlier one has; NULL: there is none. Of a
 * lookup that has just begun. */
const ProtobufCMessage *pel_lookup_twin(struct pel_lookup *lookup);
