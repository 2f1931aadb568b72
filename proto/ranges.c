#include "ranges.h"

#include <glib.h>
#include <math.h>
#include <stdbool.h>
#include <string.h>

#include "fault.h"
#include "fields.h"
#include "json.h"
#include "message.h"

#define PATH_SIZE 192

static enum pel_err check_number(const struct pel_field *info, const char *path,
                                 double value, struct pel_fault *fault)
{
    bool finite = isfinite(value);
    if (finite &&
        (!info->ranged || (value >= info->minimum && value <= info->maximum))) {
        return PEL_OK;
    }
    char text[32] = "not a finite number", what[160], low[32], high[32];
    const char *unit =
        info->unit && strcmp(info->unit, "1") != 0 ? info->unit : "";
    if (finite) {
        pel_json_number(value, text);
    }
    if (info->ranged) {
        pel_json_number(info->minimum, low);
        pel_json_number(info->maximum, high);
        g_snprintf(what, sizeof what, "is %s%s%s; it must be %s to %s%s%s",
                   text, finite && *unit ? " " : "", finite ? unit : "", low,
                   high, *unit ? " " : "", unit);
    } else {
        g_snprintf(what, sizeof what, "is %s", text);
    }
    return pel_fault_refuse(PEL_ERR_OUT_OF_RANGE, path, text, what, fault);
}

static enum pel_err check_text(const struct pel_field *info, const char *path,
                               const char *text, struct pel_fault *fault)
{
    size_t length = strlen(text);
    char longer[64];
    const char *what = NULL;
    if (length > info->most_bytes) {
        g_snprintf(longer, sizeof longer, "is %zu bytes long; at most %u",
                   length, info->most_bytes);
        what = longer;
    } else if (!g_utf8_validate(text, (gssize)length, NULL)) {
        what = "is not UTF-8";
    }
    for (const char *p = text; !what && *p; p++) {
        if ((unsigned char)*p < 0x20 || *p == 0x7f) {
            what = "holds a control character";
        }
    }
    return what ? pel_fault_refuse(
                      PEL_ERR_INVALID, path,
                      g_utf8_validate(text, (gssize)length, NULL) ? text : NULL,
                      what, fault)
                : PEL_OK;
}

static void element_path(const ProtobufCMessage *element, const char *list,
                         size_t index, char out[PATH_SIZE])
{
    const ProtobufCFieldDescriptor *key = pel_field_key(element->descriptor);
    double number;
    if (!key || !pel_message_has(element, key)) {
        g_snprintf(out, PATH_SIZE, "%s.%zu", list, index);
    } else if (pel_message_number(element, key, &number)) {
        g_snprintf(out, PATH_SIZE, "%s.%.0f", list, number);
    } else {
        g_snprintf(out, PATH_SIZE, "%s.%.64s", list,
                   *(char *const *)pel_message_member(element, key));
    }
}

static enum pel_err check_field(const ProtobufCMessage *message,
                                const ProtobufCFieldDescriptor *field,
                                const char *path, struct pel_fault *fault)
{
    const struct pel_field *info = pel_field_info(message->descriptor, field);
    const void *member = pel_message_member(message, field);
    double number;
    if (field->label == PROTOBUF_C_LABEL_REPEATED) {
        size_t count;
        ProtobufCMessage **list = pel_message_list(message, field, &count);
        for (size_t i = 0; i < count; i++) {
            char below[PATH_SIZE];
            element_path(list[i], path, i, below);
            enum pel_err err = pel_message_check(list[i], below, fault);
            if (err) {
                return err;
            }
        }
        return PEL_OK;
    }
    if (field->type == PROTOBUF_C_TYPE_MESSAGE) {
        return pel_message_check(*(ProtobufCMessage *const *)member, path,
                                 fault);
    }
    if (field->type == PROTOBUF_C_TYPE_STRING) {
        return check_text(info, path, *(char *const *)member, fault);
    }
    if (!pel_message_number(message, field, &number)) {
        return PEL_OK;
    }
    if (field->type == PROTOBUF_C_TYPE_ENUM &&
        !protobuf_c_enum_descriptor_get_value(field->descriptor, (int)number)) {
        char text[32];
        pel_json_number(number, text);
        return pel_fault_refuse(PEL_ERR_INVALID, path, text,
                                "is not a value of its enum", fault);
    }
    return check_number(info, path, number, fault);
}

enum pel_err pel_message_check(const ProtobufCMessage *message,
                               const char *path, struct pel_fault *fault)
{
    const ProtobufCMessageDescriptor *type = message->descriptor;
    for (unsigned i = 0; i < type->n_fields; i++) {
        const ProtobufCFieldDescriptor *field = &type->fields[i];
        if (!pel_message_has(message, field)) {
            continue;
        }
        char below[PATH_SIZE];
        g_snprintf(below, sizeof below, "%s%s%s", path, path[0] ? "." : "",
                   pel_field_info(type, field)->name);
        enum pel_err err = check_field(message, field, below, fault);
        if (err) {
            return err;
        }
    }
    return PEL_OK;
}
