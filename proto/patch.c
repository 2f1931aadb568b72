#include <glib.h>
#include <limits.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fault.h"
#include "message.h"
#include "path.h"
#include "pathwalk.h"
#include "scalar.h"

Pelagos__Patch *pel_patch_new(void)
{
    return (Pelagos__Patch *)pel_message_new(&pelagos__patch__descriptor);
}

static enum pel_err refuse(enum pel_err code, const char *path,
                           const char *value, const char *what,
                           struct pel_fault *fault)
{
    pel_fault_set(fault, code, "%.90s must be %.140s", path, what);
    pel_fault_at(fault, path, value);
    return code;
}

union scalar {
    uint64_t number;
    protobuf_c_boolean truth;
    char *text; /* not owned */
};

static enum pel_err parse(const struct pel_path_info *target, const char *path,
                          const char *value, union scalar *out,
                          struct pel_fault *fault)
{
    const ProtobufCFieldDescriptor *field = target->field;
    char expected[120];
    enum scalar_result result = SCALAR_WRONG;
    if (field->label == PROTOBUF_C_LABEL_REPEATED ||
        field->type == PROTOBUF_C_TYPE_MESSAGE) {
        return refuse(PEL_ERR_INVALID, path, value,
                      "set field by field: it is not a plain value", fault);
    }
    if (field->type == PROTOBUF_C_TYPE_STRING) {
        out->text = (char *)value;
        result = g_utf8_validate(value, -1, NULL) ? SCALAR_OK : SCALAR_WRONG;
    } else if (field->type == PROTOBUF_C_TYPE_BOOL) {
        out->truth = strcmp(value, "true") == 0;
        result = out->truth || strcmp(value, "false") == 0 ? SCALAR_OK
                                                           : SCALAR_WRONG;
    } else {
        result = scalar_parse_number(field, value, out);
    }
    return result == SCALAR_OK
               ? PEL_OK
               : refuse(result == SCALAR_RANGE ? PEL_ERR_OUT_OF_RANGE
                                               : PEL_ERR_INVALID,
                        path, value, scalar_expects(field, expected), fault);
}

static enum pel_err add_remove(Pelagos__Patch *patch, const char *path,
                               struct pel_fault *fault)
{
    const char *rest = path, *name;
    size_t length;
    if (strlen(path) >= PATH_MAX_BYTES) {
        return path_unknown(path, "the path is too long", fault);
    }
    /* In the schema's spelling: views, not view. */
    path_next(&rest, &name, &length);
    const ProtobufCFieldDescriptor *field =
        path_field(&pelagos__state__descriptor, name, length, true);
    char whole[PATH_MAX_BYTES + 16];
    g_snprintf(whole, sizeof whole, "%s%s%s", field->name, rest ? "." : "",
               rest ? rest : "");
    pel_message_append_string(&patch->remove, &patch->n_remove, whole);
    return PEL_OK;
}

/* The element a component names in the patch's own keyed list, made if it is
 * not there. NULL: the component cannot be a key. */
static ProtobufCMessage *keyed_element(ProtobufCMessage *holder,
                                       const ProtobufCFieldDescriptor *field,
                                       const char *name, size_t length)
{
    size_t index, count, id;
    if (path_element(holder, field, name, length, "", &index, NULL) == PEL_OK) {
        return pel_message_list(holder, field, &count)[index];
    }
    const ProtobufCFieldDescriptor *key = pel_field_key(field->descriptor);
    ProtobufCMessage *element = pel_message_append(holder, field);
    char text[65];
    g_strlcpy(text, name, length + 1 < sizeof text ? length + 1 : sizeof text);
    if (key->type == PROTOBUF_C_TYPE_STRING) {
        pel_message_set_string(element, key, text);
    } else if (path_index(name, length, &id)) {
        *(uint32_t *)pel_message_member(element, key) = (uint32_t)id;
        pel_message_mark(element, key);
    } else {
        pel_message_set_string(
            element, pel_field_by_name(field->descriptor, "name", 4), text);
    }
    return element;
}

/* Where the same list is in the present state; for lists without key, which
 * are not inside keyed ones in this schema. */
static const ProtobufCMessage *present(const Pelagos__State *now,
                                       const ProtobufCFieldDescriptor *via)
{
    return now && via && via->type == PROTOBUF_C_TYPE_MESSAGE &&
                   pel_message_has(&now->base, via)
               ? *(ProtobufCMessage *const *)pel_message_member(&now->base, via)
               : NULL;
}

static ProtobufCMessage *indexed_element(ProtobufCMessage *holder,
                                         const ProtobufCMessage *now,
                                         const ProtobufCFieldDescriptor *field,
                                         size_t index)
{
    size_t count, have;
    ProtobufCMessage **list = pel_message_list(holder, field, &count);
    if (count == 0 && now) {
        ProtobufCMessage **from = pel_message_list(now, field, &have);
        for (size_t i = 0; i < have; i++) {
            pel_message_append(holder, field);
            list = pel_message_list(holder, field, &count);
            protobuf_c_message_free_unpacked(list[i], NULL);
            list[i] = pel_message_copy(from[i]);
        }
    }
    if (index < count) {
        return list[index];
    }
    return index == count ? pel_message_append(holder, field) : NULL;
}

static size_t listed(const Pelagos__State *state,
                     const ProtobufCFieldDescriptor *field)
{
    size_t count = 0;
    if (state && state->sea) {
        pel_message_list(&state->sea->base, field, &count);
    }
    return count;
}

/* Whether indexed_element will succeed: lists without key are the sea's. */
static bool index_fits(const Pelagos__Patch *patch, const Pelagos__State *now,
                       const ProtobufCFieldDescriptor *field, size_t index)
{
    size_t count = listed(patch->state, field);
    return index <= (count > 0 ? count : listed(now, field));
}

static bool indices_fit(const Pelagos__Patch *patch, const Pelagos__State *now,
                        const char *path)
{
    const ProtobufCMessageDescriptor *type = &pelagos__state__descriptor;
    const char *rest = path, *name;
    size_t length, index;
    while (path_next(&rest, &name, &length)) {
        const ProtobufCFieldDescriptor *field =
            path_field(type, name, length, type == &pelagos__state__descriptor);
        type =
            field->type == PROTOBUF_C_TYPE_MESSAGE ? field->descriptor : NULL;
        if (path_is_list(field) && path_next(&rest, &name, &length) &&
            !pel_field_key(type) &&
            (!path_index(name, length, &index) ||
             !index_fits(patch, now, field, index))) {
            return false;
        }
    }
    return true;
}

/* The message in the patch that holds the last field of the path. */
static ProtobufCMessage *reach(Pelagos__Patch *patch, const Pelagos__State *now,
                               const char *path)
{
    if (!patch->state) {
        patch->state =
            (Pelagos__State *)pel_message_new(&pelagos__state__descriptor);
    }
    ProtobufCMessage *message = &patch->state->base;
    const ProtobufCFieldDescriptor *via = NULL;
    const char *rest = path, *name;
    size_t length, index;
    while (path_next(&rest, &name, &length) && rest) {
        const ProtobufCFieldDescriptor *field = path_field(
            message->descriptor, name, length, message == &patch->state->base);
        if (!path_is_list(field)) {
            message = pel_message_child(message, field);
        } else {
            path_next(&rest, &name, &length);
            message =
                !pel_field_key(field->descriptor) &&
                        path_index(name, length, &index)
                    ? indexed_element(message, present(now, via), field, index)
                    : keyed_element(message, field, name, length);
        }
        via = field;
    }
    return message;
}

enum pel_err pel_path_set(Pelagos__Patch *patch, const Pelagos__State *now,
                          const char *path, const char *value,
                          struct pel_fault *fault)
{
    struct pel_path_info target;
    union scalar parsed = { 0 };
    enum pel_err err = pel_path_find(path, &target, fault);
    if (err) {
        return err;
    }
    if (!value || strcmp(value, "null") == 0) {
        return add_remove(patch, path, fault);
    }
    err = parse(&target, path, value, &parsed, fault);
    if (err) {
        return err;
    }
    if (!indices_fit(patch, now, path)) {
        return path_unknown(path, "the elements before it are missing", fault);
    }
    ProtobufCMessage *message = reach(patch, now, path);
    if (target.field->type == PROTOBUF_C_TYPE_STRING) {
        pel_message_set_string(message, target.field, parsed.text);
    } else {
        memcpy(pel_message_member(message, target.field), &parsed,
               pel_message_value_size(target.field));
        pel_message_mark(message, target.field);
    }
    return PEL_OK;
}

enum pel_err pel_path_set_number(Pelagos__Patch *patch,
                                 const Pelagos__State *now, const char *path,
                                 double value, struct pel_fault *fault)
{
    struct pel_path_info info;
    const ProtobufCEnumValue *named = NULL;
    char text[40];
    enum pel_err err = pel_path_find(path, &info, fault);
    if (err) {
        return err;
    }
    switch (info.field->type) {
    case PROTOBUF_C_TYPE_ENUM:
        if (value >= INT_MIN && value <= INT_MAX) {
            named = protobuf_c_enum_descriptor_get_value(info.field->descriptor,
                                                         (int)value);
        }
        if (!named) {
            return pel_fault_set(fault, PEL_ERR_INVALID, "%s: no such value",
                                 path);
        }
        return pel_path_set(patch, now, path, named->name, fault);
    case PROTOBUF_C_TYPE_BOOL:
        return pel_path_set(patch, now, path, value != 0 ? "true" : "false",
                            fault);
    case PROTOBUF_C_TYPE_UINT32:
    case PROTOBUF_C_TYPE_UINT64:
        snprintf(text, sizeof text, "%.0f", value);
        return pel_path_set(patch, now, path, text, fault);
    case PROTOBUF_C_TYPE_DOUBLE:
        snprintf(text, sizeof text, "%.17g", value);
        return pel_path_set(patch, now, path, text, fault);
    default:
        return pel_fault_set(fault, PEL_ERR_INVALID, "%s is no number", path);
    }
}
