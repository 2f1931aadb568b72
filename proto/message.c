#include "message.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "base/reserve.h"

#define MOST_POINTERS 96 /* fields of a message that are no numbers */

static void *at(const ProtobufCMessage *message, unsigned offset)
{
    return (char *)message + offset;
}

void *pel_message_member(const ProtobufCMessage *message,
                         const ProtobufCFieldDescriptor *field)
{
    return at(message, field->offset);
}

static size_t *count_of(const ProtobufCMessage *message,
                        const ProtobufCFieldDescriptor *field)
{
    return at(message, field->quantifier_offset);
}

static bool is_oneof(const ProtobufCFieldDescriptor *field)
{
    return (field->flags & PROTOBUF_C_FIELD_FLAG_ONEOF) != 0;
}

static bool is_pointer(const ProtobufCFieldDescriptor *field)
{
    return field->type == PROTOBUF_C_TYPE_STRING ||
           field->type == PROTOBUF_C_TYPE_MESSAGE;
}

/* Whether its value is no pointer. */
static bool is_flat(const ProtobufCFieldDescriptor *field)
{
    return !is_pointer(field) && field->type != PROTOBUF_C_TYPE_BYTES;
}

size_t pel_message_value_size(const ProtobufCFieldDescriptor *field)
{
    switch (field->type) {
    case PROTOBUF_C_TYPE_INT64:
    case PROTOBUF_C_TYPE_SINT64:
    case PROTOBUF_C_TYPE_SFIXED64:
    case PROTOBUF_C_TYPE_UINT64:
    case PROTOBUF_C_TYPE_FIXED64:
    case PROTOBUF_C_TYPE_DOUBLE:
        return 8;
    case PROTOBUF_C_TYPE_BOOL:
        return sizeof(protobuf_c_boolean);
    case PROTOBUF_C_TYPE_STRING:
    case PROTOBUF_C_TYPE_MESSAGE:
        return sizeof(void *);
    case PROTOBUF_C_TYPE_BYTES:
        return sizeof(ProtobufCBinaryData);
    default:
        return 4;
    }
}

ProtobufCMessage *pel_message_new(const ProtobufCMessageDescriptor *type)
{
    ProtobufCMessage *message = pel_sure_malloc(type->sizeof_message);
    protobuf_c_message_init(type, message);
    return message;
}

bool pel_message_has(const ProtobufCMessage *message,
                     const ProtobufCFieldDescriptor *field)
{
    if (field->label == PROTOBUF_C_LABEL_REPEATED) {
        return *count_of(message, field) > 0;
    }
    if (is_oneof(field)) {
        return *(uint32_t *)at(message, field->quantifier_offset) ==
               (uint32_t)field->id;
    }
    if (is_pointer(field)) {
        const void *value = *(void **)pel_message_member(message, field);
        return value && value != field->default_value;
    }
    return *(protobuf_c_boolean *)at(message, field->quantifier_offset);
}

static void free_value(const ProtobufCFieldDescriptor *field, void *member)
{
    if (field->type == PROTOBUF_C_TYPE_MESSAGE) {
        protobuf_c_message_free_unpacked(*(ProtobufCMessage **)member, NULL);
    } else if (field->type == PROTOBUF_C_TYPE_STRING) {
        free(*(char **)member);
    } else if (field->type == PROTOBUF_C_TYPE_BYTES) {
        free(((ProtobufCBinaryData *)member)->data);
    }
}

/* `to`: a value of that field, made over, or zeroes. */
static void copy_value(const ProtobufCFieldDescriptor *field, void *to,
                       const void *from)
{
    if (field->type == PROTOBUF_C_TYPE_MESSAGE) {
        *(ProtobufCMessage **)to = pel_message_copy_onto(
            *(ProtobufCMessage **)to, *(ProtobufCMessage *const *)from);
    } else if (field->type == PROTOBUF_C_TYPE_STRING) {
        const char *text = *(char *const *)from;
        size_t size = strlen(text) + 1;
        *(char **)to = pel_sure_realloc(*(char **)to, size);
        memcpy(*(char **)to, text, size);
    } else if (field->type == PROTOBUF_C_TYPE_BYTES) {
        const ProtobufCBinaryData *bytes = from;
        ProtobufCBinaryData *copy = to;
        copy->len = bytes->len;
        copy->data = pel_sure_realloc(copy->data, bytes->len + 1);
        memcpy(copy->data, bytes->data, bytes->len);
    } else {
        memcpy(to, from, pel_message_value_size(field));
    }
}

/* The list of `to`, made over into one of `from`. */
static void *copy_list(const ProtobufCFieldDescriptor *field,
                       const ProtobufCMessage *to, const ProtobufCMessage *from)
{
    size_t size = pel_message_value_size(field);
    size_t had = to ? *count_of(to, field) : 0, has = *count_of(from, field);
    char *values = had > 0 ? *(char **)pel_message_member(to, field) : NULL;
    const char *source = *(char **)pel_message_member(from, field);
    for (size_t k = has; k < had; k++) {
        free_value(field, values + k * size);
    }
    if (has == 0) {
        free(values);
        return NULL;
    }
    if (has > had) {
        values = pel_sure_realloc(values, has * size);
        memset(values + had * size, 0, (has - had) * size);
    }
    for (size_t k = 0; k < has; k++) {
        copy_value(field, values + k * size, source + k * size);
    }
    return values;
}

/* The value of `to`, NULL or with or without it, made over. */
static void copy_member(const ProtobufCFieldDescriptor *field,
                        const ProtobufCMessage *to,
                        const ProtobufCMessage *from, void *out)
{
    size_t size = pel_message_value_size(field);
    bool had = to && pel_message_has(to, field);
    if (had) {
        memcpy(out, pel_message_member(to, field), size);
    }
    if (pel_message_has(from, field)) {
        copy_value(field, out, pel_message_member(from, field));
    } else {
        if (had) {
            free_value(field, out);
        }
        memcpy(out, pel_message_member(from, field), size);
    }
}

/* The struct at once, then what its fields point to: a state has ten thousand
 * numbers and a thousand of the others. Unknown fields are left out: what
 * protobuf-c packs of them it may not be able to read again. */
ProtobufCMessage *pel_message_copy_onto(ProtobufCMessage *old,
                                        const ProtobufCMessage *message)
{
    const ProtobufCMessageDescriptor *type = message->descriptor;
    struct {
        const ProtobufCFieldDescriptor *field;
        union {
            void *list;
            ProtobufCBinaryData any; /* the largest */
        } value;
    } kept[MOST_POINTERS];
    size_t count = 0;
    if (old && old->n_unknown_fields > 0) {
        protobuf_c_message_free_unpacked(old, NULL);
        old = NULL;
    }
    for (unsigned i = 0; i < type->n_fields; i++) {
        const ProtobufCFieldDescriptor *field = &type->fields[i];
        bool list = field->label == PROTOBUF_C_LABEL_REPEATED;
        if (!list && is_flat(field)) {
            continue;
        }
        if (count == MOST_POINTERS) {
            abort(); /* the schema has none that is so large */
        }
        kept[count].field = field;
        kept[count].value.any = (ProtobufCBinaryData){ 0 };
        if (list) {
            kept[count].value.list = copy_list(field, old, message);
        } else {
            copy_member(field, old, message, &kept[count].value);
        }
        count++;
    }
    ProtobufCMessage *copy = old ? old : pel_sure_malloc(type->sizeof_message);
    memcpy(copy, message, type->sizeof_message);
    copy->n_unknown_fields = 0;
    copy->unknown_fields = NULL;
    for (size_t i = 0; i < count; i++) {
        bool list = kept[i].field->label == PROTOBUF_C_LABEL_REPEATED;
        if (list || pel_message_has(message, kept[i].field)) {
            memcpy(pel_message_member(copy, kept[i].field), &kept[i].value,
                   list ? sizeof(void *)
                        : pel_message_value_size(kept[i].field));
        }
    }
    return copy;
}

ProtobufCMessage *pel_message_copy(const ProtobufCMessage *message)
{
    return pel_message_copy_onto(NULL, message);
}

bool pel_message_same(const ProtobufCMessage *a, const ProtobufCMessage *b)
{
    size_t size = protobuf_c_message_get_packed_size(a);
    if (size != protobuf_c_message_get_packed_size(b)) {
        return false;
    }
    uint8_t *bytes = pel_sure_malloc(2 * size + 1);
    protobuf_c_message_pack(a, bytes);
    protobuf_c_message_pack(b, bytes + size);
    bool same = memcmp(bytes, bytes + size, size) == 0;
    free(bytes);
    return same;
}

void pel_message_forget_unknown(ProtobufCMessage *message)
{
    const ProtobufCMessageDescriptor *type = message->descriptor;
    message->n_unknown_fields = 0;
    message->unknown_fields = NULL;
    for (unsigned i = 0; i < type->n_fields; i++) {
        const ProtobufCFieldDescriptor *field = &type->fields[i];
        if (field->type != PROTOBUF_C_TYPE_MESSAGE ||
            !pel_message_has(message, field)) {
            continue;
        }
        size_t count = 1;
        ProtobufCMessage **list = pel_message_member(message, field);
        if (field->label == PROTOBUF_C_LABEL_REPEATED) {
            list = pel_message_list(message, field, &count);
        }
        for (size_t k = 0; k < count; k++) {
            pel_message_forget_unknown(list[k]);
        }
    }
}

void pel_message_clear(ProtobufCMessage *message,
                       const ProtobufCFieldDescriptor *field)
{
    if (!pel_message_has(message, field)) {
        return;
    }
    void *member = pel_message_member(message, field);
    if (field->label == PROTOBUF_C_LABEL_REPEATED) {
        char *values = *(char **)member;
        for (size_t i = 0; i < *count_of(message, field); i++) {
            free_value(field, values + i * pel_message_value_size(field));
        }
        free(values);
        *(void **)member = NULL;
        *count_of(message, field) = 0;
        return;
    }
    free_value(field, member);
    memset(member, 0, pel_message_value_size(field));
    if (is_oneof(field)) {
        *(uint32_t *)at(message, field->quantifier_offset) = 0;
    } else if (is_pointer(field)) {
        *(const void **)member = field->default_value;
    } else {
        *(protobuf_c_boolean *)at(message, field->quantifier_offset) = false;
    }
}

bool pel_message_default(ProtobufCMessage *message,
                         const ProtobufCFieldDescriptor *field)
{
    void *member = pel_message_member(message, field);
    if (!field->default_value || field->type == PROTOBUF_C_TYPE_BYTES) {
        return false;
    }
    if (pel_message_has(message, field)) {
        return true;
    }
    if (field->type == PROTOBUF_C_TYPE_STRING) {
        *(char **)member = pel_sure_strdup(field->default_value);
    } else {
        memcpy(member, field->default_value, pel_message_value_size(field));
        pel_message_mark(message, field);
    }
    return true;
}

void pel_message_mark(ProtobufCMessage *message,
                      const ProtobufCFieldDescriptor *field)
{
    if (is_oneof(field)) {
        *(uint32_t *)at(message, field->quantifier_offset) = field->id;
    } else if (!is_pointer(field)) {
        *(protobuf_c_boolean *)at(message, field->quantifier_offset) = true;
    }
}

ProtobufCMessage *pel_message_child(ProtobufCMessage *message,
                                    const ProtobufCFieldDescriptor *field)
{
    ProtobufCMessage **member = pel_message_member(message, field);
    if (!pel_message_has(message, field)) {
        *member = pel_message_new(field->descriptor);
        pel_message_mark(message, field);
    }
    return *member;
}

ProtobufCMessage **pel_message_list(const ProtobufCMessage *message,
                                    const ProtobufCFieldDescriptor *field,
                                    size_t *count)
{
    *count = *count_of(message, field);
    return *(ProtobufCMessage ***)pel_message_member(message, field);
}

/* Room is always a power of two, also for lists that protobuf-c unpacked with
 * exactly their count of places; realloc to the size it has costs nothing. */
static void *append(void **list, size_t *count, size_t size)
{
    size_t room = 1;
    while (room < *count + 1) {
        room *= 2;
    }
    *list = pel_sure_realloc(*list, room * size);
    return (char *)*list + size * (*count)++;
}

ProtobufCMessage *pel_message_append(ProtobufCMessage *message,
                                     const ProtobufCFieldDescriptor *field)
{
    ProtobufCMessage *element = pel_message_new(field->descriptor);
    void **list = pel_message_member(message, field);
    ProtobufCMessage **place =
        append(list, count_of(message, field), sizeof *place);
    *place = element;
    return element;
}

void pel_message_remove(ProtobufCMessage *message,
                        const ProtobufCFieldDescriptor *field, size_t index)
{
    size_t count;
    ProtobufCMessage **list = pel_message_list(message, field, &count);
    protobuf_c_message_free_unpacked(list[index], NULL);
    memmove(&list[index], &list[index + 1], (count - index - 1) * sizeof *list);
    *count_of(message, field) = count - 1;
    if (count == 1) {
        free(list);
        *(void **)pel_message_member(message, field) = NULL;
    }
}

bool pel_message_number(const ProtobufCMessage *message,
                        const ProtobufCFieldDescriptor *field, double *value)
{
    const void *member = pel_message_member(message, field);
    switch (field->type) {
    case PROTOBUF_C_TYPE_INT32:
    case PROTOBUF_C_TYPE_SINT32:
    case PROTOBUF_C_TYPE_SFIXED32:
    case PROTOBUF_C_TYPE_ENUM:
        *value = *(const int32_t *)member;
        return true;
    case PROTOBUF_C_TYPE_UINT32:
    case PROTOBUF_C_TYPE_FIXED32:
        *value = *(const uint32_t *)member;
        return true;
    case PROTOBUF_C_TYPE_INT64:
    case PROTOBUF_C_TYPE_SINT64:
    case PROTOBUF_C_TYPE_SFIXED64:
        *value = (double)*(const int64_t *)member;
        return true;
    case PROTOBUF_C_TYPE_UINT64:
    case PROTOBUF_C_TYPE_FIXED64:
        *value = (double)*(const uint64_t *)member;
        return true;
    case PROTOBUF_C_TYPE_FLOAT:
        *value = *(const float *)member;
        return true;
    case PROTOBUF_C_TYPE_DOUBLE:
        *value = *(const double *)member;
        return true;
    case PROTOBUF_C_TYPE_BOOL:
        *value = *(const protobuf_c_boolean *)member ? 1 : 0;
        return true;
    default:
        return false;
    }
}

void pel_message_append_string(char ***list, size_t *count, const char *text)
{
    char **place = append((void **)list, count, sizeof *place);
    *place = pel_sure_strdup(text);
}

void pel_message_set_string(ProtobufCMessage *message,
                            const ProtobufCFieldDescriptor *field,
                            const char *text)
{
    const char *const *is = pel_message_member(message, field);
    if (pel_message_has(message, field) && strcmp(*is, text) == 0) {
        return;
    }
    pel_message_clear(message, field);
    *(char **)pel_message_member(message, field) = pel_sure_strdup(text);
    pel_message_mark(message, field);
}
