#include "scalar.h"

#include <errno.h>
#include <glib.h>
#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

static enum scalar_result parse_double(const char *text, double *out)
{
    /* Only the decimal form: no hexadecimal, nan, inf, leading space. */
    size_t length = strlen(text);
    if (length == 0 || strspn(text, "0123456789.eE+-") != length) {
        char first = text[text[0] == '-' || text[0] == '+'];
        bool named = first && strchr("nNiI", first);
        return named && !isfinite(g_ascii_strtod(text, NULL)) ? SCALAR_RANGE
                                                              : SCALAR_WRONG;
    }
    char *end;
    *out = g_ascii_strtod(text, &end);
    if (*end) {
        return SCALAR_WRONG;
    }
    return isfinite(*out) ? SCALAR_OK : SCALAR_RANGE;
}

static enum scalar_result parse_unsigned(const char *text, uint64_t max,
                                         uint64_t *out)
{
    if (text[strspn(text, "0123456789")] == '\0' && text[0]) {
        errno = 0;
        *out = g_ascii_strtoull(text, NULL, 10);
        return errno || *out > max ? SCALAR_RANGE : SCALAR_OK;
    }
    double value;
    enum scalar_result result = parse_double(text, &value);
    if (result != SCALAR_OK) {
        return result;
    }
    if (value != floor(value)) {
        return SCALAR_WRONG;
    }
    /* 2^64 is the first double that does not fit. */
    if (value < 0 || value >= 18446744073709551616.0 || (uint64_t)value > max) {
        return SCALAR_RANGE;
    }
    *out = (uint64_t)value;
    return SCALAR_OK;
}

static enum scalar_result parse_signed(const char *text, int64_t max,
                                       int64_t *out)
{
    bool negative = text[0] == '-';
    uint64_t size;
    enum scalar_result result = parse_unsigned(negative ? text + 1 : text,
                                               (uint64_t)max + negative, &size);
    if (result == SCALAR_OK) {
        *out = negative ? (int64_t)(0 - size) : (int64_t)size;
    }
    return result;
}

static enum scalar_result parse_enum(const ProtobufCFieldDescriptor *field,
                                     const char *text, int *out)
{
    const ProtobufCEnumDescriptor *type = field->descriptor;
    int64_t number;
    for (unsigned i = 0; i < type->n_values; i++) {
        if (g_ascii_strcasecmp(type->values[i].name, text) == 0) {
            *out = type->values[i].value;
            return SCALAR_OK;
        }
    }
    if (parse_signed(text, INT32_MAX, &number) != SCALAR_OK ||
        !protobuf_c_enum_descriptor_get_value(type, (int)number)) {
        return SCALAR_WRONG;
    }
    *out = (int)number;
    return SCALAR_OK;
}

enum scalar_result scalar_parse_number(const ProtobufCFieldDescriptor *field,
                                       const char *text, void *member)
{
    enum scalar_result result;
    uint64_t natural = 0;
    int64_t whole = 0;
    double value = 0;
    switch (field->type) {
    case PROTOBUF_C_TYPE_INT32:
    case PROTOBUF_C_TYPE_SINT32:
    case PROTOBUF_C_TYPE_SFIXED32:
        result = parse_signed(text, INT32_MAX, &whole);
        *(int32_t *)member = (int32_t)whole;
        return result;
    case PROTOBUF_C_TYPE_INT64:
    case PROTOBUF_C_TYPE_SINT64:
    case PROTOBUF_C_TYPE_SFIXED64:
        return parse_signed(text, INT64_MAX, member);
    case PROTOBUF_C_TYPE_UINT32:
    case PROTOBUF_C_TYPE_FIXED32:
        result = parse_unsigned(text, UINT32_MAX, &natural);
        *(uint32_t *)member = (uint32_t)natural;
        return result;
    case PROTOBUF_C_TYPE_UINT64:
    case PROTOBUF_C_TYPE_FIXED64:
        return parse_unsigned(text, UINT64_MAX, member);
    case PROTOBUF_C_TYPE_FLOAT:
        result = parse_double(text, &value);
        *(float *)member = (float)value;
        return result == SCALAR_OK && !isfinite((float)value) ? SCALAR_RANGE
                                                              : result;
    case PROTOBUF_C_TYPE_DOUBLE:
        return parse_double(text, member);
    case PROTOBUF_C_TYPE_ENUM:
        return parse_enum(field, text, member);
    default:
        return SCALAR_WRONG;
    }
}

const char *scalar_expects(const ProtobufCFieldDescriptor *field, char out[120])
{
    switch (field->type) {
    case PROTOBUF_C_TYPE_ENUM: {
        const ProtobufCEnumDescriptor *type = field->descriptor;
        size_t used = (size_t)snprintf(out, 120, "one of");
        for (unsigned i = 0; i < type->n_values && used < 120; i++) {
            used += (size_t)snprintf(out + used, 120 - used, "%s %s",
                                     i > 0 ? "," : "", type->values[i].name);
        }
        return out;
    }
    case PROTOBUF_C_TYPE_FLOAT:
    case PROTOBUF_C_TYPE_DOUBLE:
        return "a finite number";
    case PROTOBUF_C_TYPE_BOOL:
        return "true or false";
    case PROTOBUF_C_TYPE_STRING:
        return "a string";
    case PROTOBUF_C_TYPE_BYTES:
        return "a string of base64";
    case PROTOBUF_C_TYPE_MESSAGE:
        return "an object";
    default:
        return "a whole number that fits its type";
    }
}
