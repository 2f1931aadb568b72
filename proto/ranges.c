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

/* Where the test is: written as a path only where something is wrong, since
 * the paths of a state's fields would take most of the time of testing it. */
struct where {
    const struct where *above;       /* NULL: the message's own path */
    const char *name;                /* of a field, or that path */
    const ProtobufCMessage *element; /* of a list, or NULL */
    size_t index;                    /* of it */
};

static void write_path(const struct where *where, char out[PATH_SIZE])
{
    char before[PATH_SIZE];
    double number;
    if (!where->above) {
        g_strlcpy(out, where->name, PATH_SIZE);
        return;
    }
    write_path(where->above, before);
    if (!where->element) {
        g_snprintf(out, PATH_SIZE, "%s%s%s", before, before[0] ? "." : "",
                   where->name);
        return;
    }
    const ProtobufCFieldDescriptor *key =
        pel_field_key(where->element->descriptor);
    if (!key || !pel_message_has(where->element, key)) {
        g_snprintf(out, PATH_SIZE, "%s.%zu", before, where->index);
    } else if (pel_message_number(where->element, key, &number)) {
        g_snprintf(out, PATH_SIZE, "%s.%.0f", before, number);
    } else {
        g_snprintf(out, PATH_SIZE, "%s.%.64s", before,
                   *(char *const *)pel_message_member(where->element, key));
    }
}

static enum pel_err refuse(enum pel_err err, const struct where *where,
                           const char *value, const char *what,
                           struct pel_fault *fault)
{
    char path[PATH_SIZE];
    write_path(where, path);
    return pel_fault_refuse(err, path, value, what, fault);
}

static enum pel_err check_number(const struct pel_field *info,
                                 const struct where *where, double value,
                                 struct pel_fault *fault)
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
    return refuse(PEL_ERR_OUT_OF_RANGE, where, text, what, fault);
}

static enum pel_err check_text(const struct pel_field *info,
                               const struct where *where, const char *text,
                               struct pel_fault *fault)
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
    return what ? refuse(PEL_ERR_INVALID, where,
                         g_utf8_validate(text, (gssize)length, NULL) ? text
                                                                     : NULL,
                         what, fault)
                : PEL_OK;
}

static enum pel_err check_message(const ProtobufCMessage *message,
                                  const struct where *where,
                                  struct pel_fault *fault);

static enum pel_err check_field(const ProtobufCMessage *message,
                                const ProtobufCFieldDescriptor *field,
                                const struct pel_field *info,
                                const struct where *where,
                                struct pel_fault *fault)
{
    const void *member = pel_message_member(message, field);
    double number;
    if (field->label == PROTOBUF_C_LABEL_REPEATED) {
        size_t count;
        ProtobufCMessage **list = pel_message_list(message, field, &count);
        for (size_t i = 0; i < count; i++) {
            const struct where below = { where, NULL, list[i], i };
            enum pel_err err = check_message(list[i], &below, fault);
            if (err) {
                return err;
            }
        }
        return PEL_OK;
    }
    if (field->type == PROTOBUF_C_TYPE_MESSAGE) {
        return check_message(*(ProtobufCMessage *const *)member, where, fault);
    }
    if (field->type == PROTOBUF_C_TYPE_STRING) {
        return check_text(info, where, *(char *const *)member, fault);
    }
    if (!pel_message_number(message, field, &number)) {
        return PEL_OK;
    }
    if (field->type == PROTOBUF_C_TYPE_ENUM &&
        !protobuf_c_enum_descriptor_get_value(field->descriptor, (int)number)) {
        char text[32];
        pel_json_number(number, text);
        return refuse(PEL_ERR_INVALID, where, text,
                      "is not a value of its enum", fault);
    }
    return check_number(info, where, number, fault);
}

static enum pel_err check_message(const ProtobufCMessage *message,
                                  const struct where *where,
                                  struct pel_fault *fault)
{
    const ProtobufCMessageDescriptor *type = message->descriptor;
    const struct pel_field *infos = pel_field_info(type, type->fields);
    for (unsigned i = 0; i < type->n_fields; i++) {
        const ProtobufCFieldDescriptor *field = &type->fields[i];
        if (!pel_message_has(message, field)) {
            continue;
        }
        const struct where below = { where, infos[i].name, NULL, 0 };
        enum pel_err err =
            check_field(message, field, &infos[i], &below, fault);
        if (err) {
            return err;
        }
    }
    return PEL_OK;
}

enum pel_err pel_message_check(const ProtobufCMessage *message,
                               const char *path, struct pel_fault *fault)
{
    const struct where top = { NULL, path, NULL, 0 };
    return check_message(message, &top, fault);
}
