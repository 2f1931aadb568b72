#include <glib.h>
#include <inttypes.h>
#include <math.h>
#include <string.h>

#include "fields.h"
#include "json.h"
#include "message.h"

void pel_json_number(double value, char out[32])
{
    for (int digits = 15; digits <= 17; digits++) {
        char format[8];
        g_snprintf(format, sizeof format, "%%.%dg", digits);
        g_ascii_formatd(out, 32, format, value);
        if (g_ascii_strtod(out, NULL) == value) {
            return;
        }
    }
}

struct writer {
    GString *out;
    bool pretty;
    int depth;
};

static void new_line(struct writer *w)
{
    if (w->pretty) {
        g_string_append_c(w->out, '\n');
        for (int i = 0; i < w->depth; i++) {
            g_string_append(w->out, "  ");
        }
    }
}

static void write_string(GString *out, const char *text)
{
    g_autofree char *valid = g_utf8_make_valid(text, -1);
    g_string_append_c(out, '"');
    for (const char *p = valid; *p; p++) {
        if (*p == '"' || *p == '\\') {
            g_string_append_c(out, '\\');
            g_string_append_c(out, *p);
        } else if ((unsigned char)*p < 0x20) {
            g_string_append_printf(out, "\\u%04x", (unsigned)*p);
        } else {
            g_string_append_c(out, *p);
        }
    }
    g_string_append_c(out, '"');
}

char *pel_json_string(const char *text)
{
    GString *out = g_string_new(NULL);
    write_string(out, text);
    return g_string_free(out, FALSE);
}

static void write_double(GString *out, double value)
{
    char text[32];
    if (!isfinite(value)) {
        g_string_append(out, "null");
        return;
    }
    pel_json_number(value, text);
    g_string_append(out, text);
}

static void write_enum(GString *out, const ProtobufCFieldDescriptor *field,
                       int value)
{
    const ProtobufCEnumValue *known =
        protobuf_c_enum_descriptor_get_value(field->descriptor, value);
    if (known) {
        write_string(out, known->name);
    } else {
        g_string_append_printf(out, "%d", value);
    }
}

static void write_message(struct writer *w, const ProtobufCMessage *message);

static void write_value(struct writer *w, const ProtobufCFieldDescriptor *field,
                        const void *member)
{
    switch (field->type) {
    case PROTOBUF_C_TYPE_INT32:
    case PROTOBUF_C_TYPE_SINT32:
    case PROTOBUF_C_TYPE_SFIXED32:
        g_string_append_printf(w->out, "%" PRId32, *(const int32_t *)member);
        break;
    case PROTOBUF_C_TYPE_UINT32:
    case PROTOBUF_C_TYPE_FIXED32:
        g_string_append_printf(w->out, "%" PRIu32, *(const uint32_t *)member);
        break;
    case PROTOBUF_C_TYPE_INT64:
    case PROTOBUF_C_TYPE_SINT64:
    case PROTOBUF_C_TYPE_SFIXED64:
        g_string_append_printf(w->out, "\"%" PRId64 "\"",
                               *(const int64_t *)member);
        break;
    case PROTOBUF_C_TYPE_UINT64:
    case PROTOBUF_C_TYPE_FIXED64:
        g_string_append_printf(w->out, "\"%" PRIu64 "\"",
                               *(const uint64_t *)member);
        break;
    case PROTOBUF_C_TYPE_FLOAT:
        write_double(w->out, *(const float *)member);
        break;
    case PROTOBUF_C_TYPE_DOUBLE:
        write_double(w->out, *(const double *)member);
        break;
    case PROTOBUF_C_TYPE_BOOL:
        g_string_append(w->out,
                        *(const protobuf_c_boolean *)member ? "true" : "false");
        break;
    case PROTOBUF_C_TYPE_ENUM:
        write_enum(w->out, field, *(const int *)member);
        break;
    case PROTOBUF_C_TYPE_STRING:
        write_string(w->out, *(char *const *)member);
        break;
    case PROTOBUF_C_TYPE_BYTES: {
        const ProtobufCBinaryData *bytes = member;
        g_autofree char *text = g_base64_encode(bytes->data, bytes->len);
        g_string_append_printf(w->out, "\"%s\"", text);
        break;
    }
    case PROTOBUF_C_TYPE_MESSAGE:
        write_message(w, *(ProtobufCMessage *const *)member);
        break;
    }
}

static void write_list(struct writer *w, const ProtobufCMessage *message,
                       const ProtobufCFieldDescriptor *field)
{
    size_t count;
    const char *values = (const char *)pel_message_list(message, field, &count);
    g_string_append_c(w->out, '[');
    w->depth++;
    for (size_t i = 0; i < count; i++) {
        if (i > 0) {
            g_string_append_c(w->out, ',');
        }
        new_line(w);
        write_value(w, field, values + i * pel_message_value_size(field));
    }
    w->depth--;
    new_line(w);
    g_string_append_c(w->out, ']');
}

static void write_field(struct writer *w, const ProtobufCMessage *message,
                        const ProtobufCFieldDescriptor *field)
{
    if (field->label == PROTOBUF_C_LABEL_REPEATED) {
        write_list(w, message, field);
    } else {
        write_value(w, field, pel_message_member(message, field));
    }
}

static void write_message(struct writer *w, const ProtobufCMessage *message)
{
    const ProtobufCMessageDescriptor *type = message->descriptor;
    bool first = true;
    g_string_append_c(w->out, '{');
    w->depth++;
    for (unsigned i = 0; i < type->n_fields; i++) {
        const ProtobufCFieldDescriptor *field = &type->fields[i];
        if (!pel_message_has(message, field)) {
            continue;
        }
        if (!first) {
            g_string_append_c(w->out, ',');
        }
        first = false;
        new_line(w);
        const struct pel_field *info = pel_field_info(type, field);
        write_string(w->out, info ? info->name : field->name);
        g_string_append(w->out, w->pretty ? ": " : ":");
        write_field(w, message, field);
    }
    w->depth--;
    if (!first) {
        new_line(w);
    }
    g_string_append_c(w->out, '}');
}

char *pel_json_from_message(const ProtobufCMessage *message, bool pretty)
{
    struct writer w = { .out = g_string_new(NULL), .pretty = pretty };
    write_message(&w, message);
    return g_string_free(w.out, FALSE);
}

char *pel_json_from_field(const ProtobufCMessage *message,
                          const ProtobufCFieldDescriptor *field, bool pretty)
{
    struct writer w = { .out = g_string_new(NULL), .pretty = pretty };
    write_field(&w, message, field);
    return g_string_free(w.out, FALSE);
}
