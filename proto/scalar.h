/* Text to scalar fields, for JSON and for paths. */
#pragma once

#include <protobuf-c/protobuf-c.h>

/* Why a text is not a value of a field's type. */
enum scalar_result {
    SCALAR_OK,
    SCALAR_WRONG, /* not of this type or form */
    SCALAR_RANGE, /* does not fit the type, or NaN, or infinite */
};

/* Parses a number (C locale) into the numeric or enum field at `member`. */
enum scalar_result scalar_parse_number(const ProtobufCFieldDescriptor *field,
                                       const char *text, void *member);

/* "a number", "a whole number", "one of FREE, PACED", …: for messages;
 * `out` holds 120 bytes. */
const char *scalar_expects(const ProtobufCFieldDescriptor *field,
                           char out[120]);
