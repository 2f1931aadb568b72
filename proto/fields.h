/* What the schema's comments say about its fields: JSON name, unit, range,
 * key, sentence. The table is generated from pelagos.proto by fields.py; it
 * is constant, so any thread may read it. */
#pragma once

#include <protobuf-c/protobuf-c.h>
#include <stdbool.h>
#include <stddef.h>

struct pel_field {
    const char *name; /* JSON name, lowerCamelCase */
    const char *unit; /* "m/s"; "1": a pure number; NULL: none */
    bool ranged;      /* minimum and maximum hold, both inclusive */
    double minimum, maximum;
    bool key;            /* names an element of a list */
    unsigned most_bytes; /* of a text: PEL_BOUND_TEXT_BYTES or its own */
    const char *doc;     /* sentence of the schema, without the bracket */
};

struct pel_field_table {
    const ProtobufCMessageDescriptor *message;
    const struct pel_field *fields; /* message->n_fields, same order */
    const char *doc;
};

/* Every message of the schema, in its order; generated. */
extern const struct pel_field_table pel_field_tables[];
extern const size_t pel_field_table_count;

/* Information about a field of a message of the schema; NULL for a foreign
 * message. `field` must be an element of message->fields. */
const struct pel_field *
pel_field_info(const ProtobufCMessageDescriptor *message,
               const ProtobufCFieldDescriptor *field);

/* The field of `message` whose JSON name (or schema name, wind_speed) is the
 * `length` bytes at `name`; NULL: none. */
const ProtobufCFieldDescriptor *
pel_field_by_name(const ProtobufCMessageDescriptor *message, const char *name,
                  size_t length);

/* The field that names an element in lists of `message`; NULL: such lists have
 * no key (swell, points) and are replaced whole. */
const ProtobufCFieldDescriptor *
pel_field_key(const ProtobufCMessageDescriptor *message);

/* The value of an enum whose schema name is `name`; NULL: none. */
const ProtobufCEnumValue *pel_enum_by_name(const ProtobufCEnumDescriptor *type,
                                           const char *name, size_t length);
