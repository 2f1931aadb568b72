#include "path.h"

#include <glib.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fault.h"
#include "json.h"
#include "message.h"
#include "pathwalk.h"

bool path_next(const char **rest, const char **name, size_t *length)
{
    if (!*rest) {
        return false;
    }
    const char *dot = strchr(*rest, '.');
    *name = *rest;
    *length = dot ? (size_t)(dot - *rest) : strlen(*rest);
    *rest = dot ? dot + 1 : NULL;
    return true;
}

const ProtobufCFieldDescriptor *
path_field(const ProtobufCMessageDescriptor *type, const char *name,
           size_t length, bool top)
{
    if (top && length == 4 && memcmp(name, "view", 4) == 0) {
        return pel_field_by_name(type, "views", 5);
    }
    if (top && length == 6 && memcmp(name, "entity", 6) == 0) {
        return pel_field_by_name(type, "entities", 8);
    }
    return pel_field_by_name(type, name, length);
}

enum pel_err path_unknown(const char *path, const char *what,
                          struct pel_fault *fault)
{
    pel_fault_set(fault, PEL_ERR_NOT_FOUND, "%.90s: %s", path, what);
    if (fault) {
        snprintf(fault->path, sizeof fault->path, "%s", path);
    }
    return PEL_ERR_NOT_FOUND;
}

bool path_index(const char *name, size_t length, size_t *index)
{
    *index = 0;
    if (length == 0 || length > 6) {
        return false;
    }
    for (size_t i = 0; i < length; i++) {
        if (!g_ascii_isdigit(name[i])) {
            return false;
        }
        *index = *index * 10 + (size_t)(name[i] - '0');
    }
    return true;
}

static bool has_string(const ProtobufCMessage *message,
                       const ProtobufCFieldDescriptor *field, const char *name,
                       size_t length)
{
    if (!field || field->type != PROTOBUF_C_TYPE_STRING ||
        !pel_message_has(message, field)) {
        return false;
    }
    const char *text = *(char *const *)pel_message_member(message, field);
    return strncmp(text, name, length) == 0 && text[length] == '\0';
}

static bool has_key(const ProtobufCMessage *element,
                    const ProtobufCFieldDescriptor *key, const char *name,
                    size_t length)
{
    double number;
    size_t index;
    if (key->type == PROTOBUF_C_TYPE_STRING) {
        return has_string(element, key, name, length);
    }
    return path_index(name, length, &index) && pel_message_has(element, key) &&
           pel_message_number(element, key, &number) && number == (double)index;
}

enum pel_err path_element(const ProtobufCMessage *holder,
                          const ProtobufCFieldDescriptor *field,
                          const char *name, size_t length, const char *path,
                          size_t *index, struct pel_fault *fault)
{
    size_t count;
    ProtobufCMessage **list = pel_message_list(holder, field, &count);
    const ProtobufCFieldDescriptor *key = pel_field_key(field->descriptor);
    if (!key) {
        return path_index(name, length, index) && *index < count
                   ? PEL_OK
                   : path_unknown(path, "no such element", fault);
    }
    for (size_t i = 0; i < count; i++) {
        if (has_key(list[i], key, name, length)) {
            *index = i;
            return PEL_OK;
        }
    }
    const ProtobufCFieldDescriptor *alias =
        pel_field_by_name(field->descriptor, "name", 4);
    size_t found = 0;
    for (size_t i = 0; i < count; i++) {
        if (has_string(list[i], alias, name, length)) {
            *index = i;
            found++;
        }
    }
    if (found == 0) {
        return path_unknown(path, "no such element", fault);
    }
    if (found > 1) {
        pel_fault_set(fault, PEL_ERR_CONFLICT,
                      "%.90s: %zu elements have this name; use the %s", path,
                      found, key->name);
        pel_fault_at(fault, path, NULL);
        return PEL_ERR_CONFLICT;
    }
    return PEL_OK;
}

enum pel_err pel_path_find(const char *path, struct pel_path_info *out,
                           struct pel_fault *fault)
{
    const ProtobufCMessageDescriptor *type = &pelagos__state__descriptor;
    const char *rest = path, *name;
    size_t length;
    *out = (struct pel_path_info){ 0 };
    while (path_next(&rest, &name, &length)) {
        if (!type) {
            return path_unknown(path,
                                "no such field: the part before the "
                                "last dot is a plain value",
                                fault);
        }
        const ProtobufCFieldDescriptor *field =
            path_field(type, name, length, type == &pelagos__state__descriptor);
        if (!field) {
            pel_fault_set(
                fault, PEL_ERR_NOT_FOUND, "%.90s: %s has no field called %.*s",
                path, type->short_name, length > 40 ? 40 : (int)length, name);
            if (fault) {
                snprintf(fault->path, sizeof fault->path, "%s", path);
            }
            return PEL_ERR_NOT_FOUND;
        }
        *out =
            (struct pel_path_info){ type, field, pel_field_info(type, field) };
        type =
            field->type == PROTOBUF_C_TYPE_MESSAGE ? field->descriptor : NULL;
        size_t index;
        if (path_is_list(field) && path_next(&rest, &name, &length) &&
            (length == 0 || length > 64 ||
             (!pel_field_key(type) && !path_index(name, length, &index)))) {
            return path_unknown(path, "no such element", fault);
        }
    }
    return PEL_OK;
}

/* Where a path ends: a field of a message, or an element of a list. */
struct place {
    ProtobufCMessage *message;
    const ProtobufCFieldDescriptor *field;
    bool element;
    size_t index;
};

/* *out has no message where a message on the way is absent. */
static enum pel_err locate(const Pelagos__State *state, const char *path,
                           struct place *out, struct pel_fault *fault)
{
    struct pel_path_info info;
    *out = (struct place){ 0 };
    enum pel_err err = pel_path_find(path, &info, fault);
    if (err) {
        return err;
    }
    ProtobufCMessage *message = (ProtobufCMessage *)state;
    const char *rest = path, *name;
    size_t length;
    while (path_next(&rest, &name, &length)) {
        *out = (struct place){ .message = message };
        if (!message) {
            return PEL_OK;
        }
        out->field = path_field(message->descriptor, name, length,
                                message == &state->base);
        if (path_is_list(out->field)) {
            if (!path_next(&rest, &name, &length)) {
                return PEL_OK;
            }
            err = path_element(message, out->field, name, length, path,
                               &out->index, fault);
            if (err) {
                return err;
            }
            size_t count;
            out->element = true;
            message = pel_message_list(message, out->field, &count)[out->index];
        } else if (out->field->type == PROTOBUF_C_TYPE_MESSAGE) {
            message =
                *(ProtobufCMessage **)pel_message_member(message, out->field);
        }
    }
    return PEL_OK;
}

static char *place_text(const struct place *place)
{
    if (!place->message) {
        return g_strdup("");
    }
    if (place->element) {
        size_t count;
        return pel_json_from_message(pel_message_list(place->message,
                                                      place->field,
                                                      &count)[place->index],
                                     false);
    }
    if (!pel_message_has(place->message, place->field)) {
        return g_strdup(path_is_list(place->field) ? "[]" : "");
    }
    if (place->field->type == PROTOBUF_C_TYPE_STRING) {
        return g_strdup(
            *(char *const *)pel_message_member(place->message, place->field));
    }
    char *text = pel_json_from_field(place->message, place->field, false);
    size_t length = strlen(text);
    bool quoted = length >= 2 && text[0] == '"';
    if (quoted) {
        memmove(text, text + 1, length - 2);
        text[length - 2] = '\0';
    }
    return text;
}

enum pel_err pel_path_get(const Pelagos__State *state, const char *path,
                          char *out, size_t size, struct pel_fault *fault)
{
    struct place place;
    enum pel_err err = locate(state, path, &place, fault);
    if (err) {
        return err;
    }
    char *text = place_text(&place);
    if (g_strlcpy(out, text, size) >= size) {
        err = pel_fault_set(fault, PEL_ERR_OUT_OF_RANGE,
                            "%.90s does not fit %zu bytes", path, size);
    }
    g_free(text);
    return err;
}

enum pel_err pel_path_remove(Pelagos__State *state, const char *path,
                             struct pel_fault *fault)
{
    struct place place;
    enum pel_err err = locate(state, path, &place, fault);
    if (err || !place.message) {
        return err;
    }
    if (place.element) {
        pel_message_remove(place.message, place.field, place.index);
        return PEL_OK;
    }
    if (place.field == pel_field_key(place.message->descriptor)) {
        pel_fault_set(fault, PEL_ERR_INVALID,
                      "%.90s names its element and cannot be removed", path);
        pel_fault_at(fault, path, NULL);
        return PEL_ERR_INVALID;
    }
    pel_message_clear(place.message, place.field);
    if (!path_is_list(place.field)) {
        pel_message_default(place.message, place.field);
    }
    return PEL_OK;
}

struct each {
    void (*callback)(const char *path, const struct pel_path_info *info,
                     void *user);
    void *user;
};

static void each_field(const struct each *each,
                       const ProtobufCMessageDescriptor *type,
                       const char *before)
{
    for (unsigned i = 0; i < type->n_fields; i++) {
        const ProtobufCFieldDescriptor *field = &type->fields[i];
        struct pel_path_info info = { type, field,
                                      pel_field_info(type, field) };
        char path[PATH_MAX_BYTES];
        g_snprintf(path, sizeof path, "%s%s%s", before, before[0] ? "." : "",
                   info.info->name);
        each->callback(path, &info, each->user);
        if (field->type == PROTOBUF_C_TYPE_MESSAGE) {
            if (path_is_list(field)) {
                g_strlcat(path, ".*", sizeof path);
            }
            each_field(each, field->descriptor, path);
        }
    }
}

void pel_path_each(void (*callback)(const char *path,
                                    const struct pel_path_info *info,
                                    void *user),
                   void *user)
{
    struct each each = { callback, user };
    each_field(&each, &pelagos__state__descriptor, "");
}
