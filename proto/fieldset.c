#include "fields.h"

#include <stdint.h>
#include <string.h>

/* The last finds of this thread, by the message's address: everything that
 * reads, tests or writes messages asks for each of their fields. */
#define FOUND 64
static _Thread_local const struct pel_field_table *found[FOUND];

static const struct pel_field_table *
table_of(const ProtobufCMessageDescriptor *message)
{
    uintptr_t address = (uintptr_t)message;
    const struct pel_field_table **place =
        &found[(address / sizeof *message) % FOUND];
    if (*place && (*place)->message == message) {
        return *place;
    }
    for (size_t i = 0; i < pel_field_table_count; i++) {
        if (pel_field_tables[i].message == message) {
            *place = &pel_field_tables[i];
            return *place;
        }
    }
    return NULL;
}

const struct pel_field *
pel_field_info(const ProtobufCMessageDescriptor *message,
               const ProtobufCFieldDescriptor *field)
{
    const struct pel_field_table *table = table_of(message);
    return table ? &table->fields[field - message->fields] : NULL;
}

static bool equals(const char *text, const char *name, size_t length)
{
    return strncmp(text, name, length) == 0 && text[length] == '\0';
}

const ProtobufCFieldDescriptor *
pel_field_by_name(const ProtobufCMessageDescriptor *message, const char *name,
                  size_t length)
{
    if (length == 0 || memchr(name, '\0', length)) {
        return NULL;
    }
    for (unsigned i = 0; i < message->n_fields; i++) {
        const ProtobufCFieldDescriptor *field = &message->fields[i];
        const struct pel_field *info = pel_field_info(message, field);
        if (equals(field->name, name, length) ||
            (info && equals(info->name, name, length))) {
            return field;
        }
    }
    return NULL;
}

const ProtobufCFieldDescriptor *
pel_field_key(const ProtobufCMessageDescriptor *message)
{
    for (unsigned i = 0; i < message->n_fields; i++) {
        const struct pel_field *info =
            pel_field_info(message, &message->fields[i]);
        if (info && info->key) {
            return &message->fields[i];
        }
    }
    return NULL;
}

const ProtobufCEnumValue *pel_enum_by_name(const ProtobufCEnumDescriptor *type,
                                           const char *name, size_t length)
{
    if (length == 0 || memchr(name, '\0', length)) {
        return NULL;
    }
    for (unsigned i = 0; i < type->n_values; i++) {
        if (equals(type->values[i].name, name, length)) {
            return &type->values[i];
        }
    }
    return NULL;
}
