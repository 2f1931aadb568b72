#include "scene/lookup.h"

#include <stdbool.h>
#include <string.h>

#include "fields.h"
#include "message.h"

/* Half of the places stay empty; elements beyond are searched one by one. */
#define MOST (PEL_LOOKUP_ROOM / 2)

static const uint8_t *key_of(const ProtobufCFieldDescriptor *key,
                             const ProtobufCMessage *message, size_t *size)
{
    const void *value = pel_message_member(message, key);
    bool text = key->type == PROTOBUF_C_TYPE_STRING;
    const uint8_t *bytes = text ? *(uint8_t *const *)value : value;
    *size = text ? strlen((const char *)bytes) : pel_message_value_size(key);
    return bytes;
}

static bool same(const ProtobufCFieldDescriptor *key, const ProtobufCMessage *a,
                 const ProtobufCMessage *b)
{
    size_t size_a, size_b;
    if (!pel_message_has(a, key)) {
        return false;
    }
    const uint8_t *of_a = key_of(key, a, &size_a);
    const uint8_t *of_b = key_of(key, b, &size_b);
    return size_a == size_b && memcmp(of_a, of_b, size_a) == 0;
}

/* FNV-1a. */
static size_t hash_of(const ProtobufCFieldDescriptor *key,
                      const ProtobufCMessage *message)
{
    size_t size;
    const uint8_t *bytes = key_of(key, message, &size);
    uint32_t hash = 2166136261U;
    for (size_t i = 0; i < size; i++) {
        hash = (hash ^ bytes[i]) * 16777619U;
    }
    return hash ^ hash >> 15;
}

/* The place of that key, or the empty one where it would be. */
static uint16_t *place_of(struct pel_lookup *l, ProtobufCMessage *const *list,
                          const ProtobufCMessage *like)
{
    size_t at = hash_of(l->key, like) % PEL_LOOKUP_ROOM;
    while (l->place[at] > 0 && !same(l->key, list[l->place[at] - 1], like)) {
        at = (at + 1) % PEL_LOOKUP_ROOM;
    }
    return &l->place[at];
}

/* Takes the next element in; false: its key is there already. */
static bool take(struct pel_lookup *l, ProtobufCMessage *const *list)
{
    size_t index = l->count++;
    if (index >= MOST || !pel_message_has(list[index], l->key)) {
        return true;
    }
    uint16_t *place = place_of(l, list, list[index]);
    if (*place > 0) {
        return false;
    }
    *place = (uint16_t)(index + 1);
    return true;
}

void pel_lookup_begin(struct pel_lookup *l, const ProtobufCMessage *holder,
                      const ProtobufCFieldDescriptor *field)
{
    *l = (struct pel_lookup){ .holder = holder,
                              .field = field,
                              .key = pel_field_key(field->descriptor) };
}

ProtobufCMessage *pel_lookup_find(struct pel_lookup *l,
                                  const ProtobufCMessage *like)
{
    size_t count;
    ProtobufCMessage **list = pel_message_list(l->holder, l->field, &count);
    while (l->count < count) {
        (void)take(l, list);
    }
    if (!pel_message_has(like, l->key)) {
        return NULL;
    }
    uint16_t place = *place_of(l, list, like);
    if (place > 0) {
        return list[place - 1];
    }
    for (size_t i = MOST; i < count; i++) {
        if (same(l->key, list[i], like)) {
            return list[i];
        }
    }
    return NULL;
}

const ProtobufCMessage *pel_lookup_twin(struct pel_lookup *l)
{
    size_t count;
    ProtobufCMessage **list = pel_message_list(l->holder, l->field, &count);
    while (l->count < count) {
        const ProtobufCMessage *next = list[l->count];
        if (!take(l, list)) {
            return next;
        }
    }
    return NULL;
}
