#include "pelagosctl/ctl.h"

#include <string.h>

#include <glib.h>

#include "proto/fields.h"
#include "proto/json.h"
#include "proto/message.h"

static void walk(const ProtobufCMessage *message, const char *prefix,
                 GArray *out);

/* A scalar as text; g_free(). */
static char *scalar_text(const ProtobufCMessage *message,
                         const ProtobufCFieldDescriptor *field)
{
    double number = 0.0;
    if (field->type == PROTOBUF_C_TYPE_BOOL) {
        const protobuf_c_boolean *value = pel_message_member(message, field);
        return g_strdup(*value ? "true" : "false");
    }
    if (field->type == PROTOBUF_C_TYPE_UINT64) {
        const uint64_t *value = pel_message_member(message, field);
        return g_strdup_printf("%" G_GUINT64_FORMAT, *value);
    }
    if (!pel_message_number(message, field, &number)) {
        char *const *value = pel_message_member(message, field);
        return g_strdup(*value ? *value : "");
    }
    if (field->type == PROTOBUF_C_TYPE_ENUM) {
        const ProtobufCEnumValue *value = protobuf_c_enum_descriptor_get_value(
            field->descriptor, (int)number);
        return g_strdup(value ? value->name : "?");
    }
    char text[32];
    pel_json_number(number, text);
    return g_strdup(text);
}

static void add_leaf(const ProtobufCMessage *message,
                     const ProtobufCFieldDescriptor *field, const char *path,
                     GArray *out)
{
    const struct pel_field *info = pel_field_info(message->descriptor, field);
    const char *unit =
        info && info->unit && strcmp(info->unit, "1") != 0 ? info->unit : "";
    struct ctl_leaf leaf = {
        .path = g_strdup(path),
        .value = scalar_text(message, field),
        .unit = unit,
        .quoted = field->type == PROTOBUF_C_TYPE_STRING ||
                  field->type == PROTOBUF_C_TYPE_ENUM,
    };
    g_array_append_val(out, leaf);
}

static void walk_list(const ProtobufCMessage *message,
                      const ProtobufCFieldDescriptor *field, const char *path,
                      GArray *out)
{
    const ProtobufCFieldDescriptor *key = pel_field_key(field->descriptor);
    size_t count = 0;
    ProtobufCMessage **items = pel_message_list(message, field, &count);
    for (size_t i = 0; i < count; i++) {
        g_autofree char *name =
            key ? scalar_text(items[i], key) : g_strdup_printf("%zu", i);
        g_autofree char *below = g_strdup_printf("%s.%s", path, name);
        walk(items[i], below, out);
    }
}

static void walk(const ProtobufCMessage *message, const char *prefix,
                 GArray *out)
{
    const ProtobufCMessageDescriptor *type = message->descriptor;
    for (unsigned i = 0; i < type->n_fields; i++) {
        const ProtobufCFieldDescriptor *field = &type->fields[i];
        const struct pel_field *info = pel_field_info(type, field);
        if (!info || !pel_message_has(message, field)) {
            continue;
        }
        g_autofree char *path =
            *prefix ? g_strdup_printf("%s.%s", prefix, info->name)
                    : g_strdup(info->name);
        bool list = field->label == PROTOBUF_C_LABEL_REPEATED;
        if (field->type != PROTOBUF_C_TYPE_MESSAGE) {
            if (!list) {
                add_leaf(message, field, path, out);
            }
        } else if (list) {
            walk_list(message, field, path, out);
        } else {
            ProtobufCMessage *const *child = pel_message_member(message, field);
            walk(*child, path, out);
        }
    }
}

struct ctl_leaves ctl_flatten(const Pelagos__State *state)
{
    GArray *array = g_array_new(FALSE, FALSE, sizeof(struct ctl_leaf));
    walk(&state->base, "", array);
    struct ctl_leaves leaves = { .count = array->len };
    leaves.items = (struct ctl_leaf *)(void *)g_array_free(array, FALSE);
    return leaves;
}

void ctl_leaves_free(struct ctl_leaves *leaves)
{
    for (size_t i = 0; i < leaves->count; i++) {
        g_free(leaves->items[i].path);
        g_free(leaves->items[i].value);
    }
    g_free(leaves->items);
    *leaves = (struct ctl_leaves){ 0 };
}

/* The id of the entity called `name`, as text; NULL: none. */
static char *entity_id(const Pelagos__State *state, const char *name)
{
    for (size_t i = 0; i < state->n_entities; i++) {
        const Pelagos__Entity *entity = state->entities[i];
        if (entity->name && strcmp(entity->name, name) == 0) {
            return g_strdup_printf("%u", entity->id);
        }
    }
    return NULL;
}

/* The schema's JSON name of one step of a path, if `message` has it. */
static char *field_name(const ProtobufCMessageDescriptor **message,
                        const char *step)
{
    const ProtobufCFieldDescriptor *field =
        *message ? pel_field_by_name(*message, step, strlen(step)) : NULL;
    if (!field) {
        return g_strdup(step);
    }
    const struct pel_field *info = pel_field_info(*message, field);
    *message =
        field->type == PROTOBUF_C_TYPE_MESSAGE ? field->descriptor : NULL;
    return g_strdup(info ? info->name : step);
}

char *ctl_canonical_path(const Pelagos__State *state, const char *path)
{
    g_auto(GStrv) steps = g_strsplit(path, ".", -1);
    const ProtobufCMessageDescriptor *message = &pelagos__state__descriptor;
    for (size_t i = 0; steps[i]; i++) {
        bool element = i == 1 && (strcmp(steps[0], "views") == 0 ||
                                  strcmp(steps[0], "entities") == 0);
        char *better = NULL;
        if (i == 0 && strcmp(steps[0], "view") == 0) {
            better = g_strdup("views");
            message = &pelagos__view__descriptor;
        } else if (i == 0 && strcmp(steps[0], "entity") == 0) {
            better = g_strdup("entities");
            message = &pelagos__entity__descriptor;
        } else if (element) {
            better = steps[0][0] == 'e' ? entity_id(state, steps[1]) : NULL;
        } else {
            better = field_name(&message, steps[i]);
        }
        if (better) {
            g_free(steps[i]);
            steps[i] = better;
        }
    }
    return g_strjoinv(".", steps);
}

bool ctl_path_below(const char *path, const char *prefix)
{
    size_t length = strlen(prefix);
    return strncmp(path, prefix, length) == 0 &&
           (path[length] == '\0' || path[length] == '.');
}

void ctl_print_string(FILE *out, const char *text)
{
    char *quoted = pel_json_string(text);
    fputs(quoted, out);
    free(quoted);
}

void ctl_print_leaf(FILE *out, const struct ctl_leaf *leaf, bool json)
{
    if (!json) {
        ctl_print(out, "%s = %s%s%s\n", leaf->path, leaf->value,
                  *leaf->unit ? " " : "", leaf->unit);
        return;
    }
    fputs("{\"path\":", out);
    ctl_print_string(out, leaf->path);
    fputs(",\"value\":", out);
    if (leaf->quoted) {
        ctl_print_string(out, leaf->value);
    } else {
        fputs(leaf->value, out);
    }
    fputs("}\n", out);
}
