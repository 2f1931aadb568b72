#include "json.h"

#include <glib.h>
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

#include "base/reserve.h"
#include "fields.h"
#include "jsonread.h"
#include "message.h"
#include "scalar.h"

/* Elements of one keyed list, entries of `remove`: far above what a scene
 * holds, far below what would cost time. */
#define MAX_KEYED 1024

struct converter {
    struct json_reader r;
    Pelagos__Patch *patch; /* a merge patch, or the Patch within; or NULL */
    bool merging;          /* a merge patch */
    size_t base; /* of the reader's path before that of the patch's state */
    int literal; /* > 0: inside an array, where null only means absent */
    int mapped;  /* > 0: inside an object of a keyed list's elements */
};

/* Whether null removes or resets here, as in a merge patch. */
static bool removes(const struct converter *c)
{
    return c->patch && c->literal == 0 && (c->merging || c->mapped > 0);
}

static enum pel_err read_message(struct converter *c, ProtobufCMessage *out);

static enum pel_err remove_here(struct converter *c)
{
    if (c->patch->n_remove >= MAX_KEYED || c->base >= c->r.path_length) {
        return json_fault(&c->r, PEL_ERR_OUT_OF_RANGE, NULL,
                          "is one null too many: at most %d", MAX_KEYED);
    }
    pel_message_append_string(&c->patch->remove, &c->patch->n_remove,
                              c->r.path + c->base);
    return PEL_OK;
}

static enum pel_err wrong(struct converter *c,
                          const ProtobufCFieldDescriptor *field,
                          const char *value, enum scalar_result result)
{
    char expected[120];
    return json_fault(
        &c->r, result == SCALAR_RANGE ? PEL_ERR_OUT_OF_RANGE : PEL_ERR_INVALID,
        value, "must be %s", scalar_expects(field, expected));
}

static enum pel_err read_base64(struct converter *c,
                                const ProtobufCFieldDescriptor *field,
                                char *text, size_t length,
                                ProtobufCBinaryData *out)
{
    static const char alphabet[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZ"
                                   "abcdefghijklmnopqrstuvwxyz0123456789+/";
    g_strdelimit(text, "-", '+');
    g_strdelimit(text, "_", '/');
    size_t used = strspn(text, alphabet);
    size_t padding = length - used;
    bool good = padding <= 2 && strspn(text + used, "=") == padding &&
                used % 4 != 1 && (padding == 0 || length % 4 == 0);
    if (!good) {
        return wrong(c, field, text, SCALAR_WRONG);
    }
    gint state = 0;
    guint save = 0;
    out->data = pel_sure_malloc(length / 4 * 3 + 6);
    out->len = g_base64_decode_step(text, used, out->data, &state, &save);
    /* Without padding the decoder holds the last two or three digits back. */
    size_t missing = (4 - used % 4) % 4;
    out->len += g_base64_decode_step("==", missing, out->data + out->len,
                                     &state, &save);
    return PEL_OK;
}

static enum pel_err read_string(struct converter *c,
                                const ProtobufCFieldDescriptor *field,
                                void *member)
{
    char *text;
    size_t length;
    enum pel_err err = json_string(&c->r, &text, &length);
    if (err) {
        return err;
    }
    if (field->type == PROTOBUF_C_TYPE_STRING) {
        *(char **)member = text;
        return PEL_OK;
    }
    if (field->type == PROTOBUF_C_TYPE_BYTES) {
        err = read_base64(c, field, text, length, member);
    } else if (field->type == PROTOBUF_C_TYPE_MESSAGE ||
               field->type == PROTOBUF_C_TYPE_BOOL) {
        err = wrong(c, field, text, SCALAR_WRONG);
    } else {
        enum scalar_result result = scalar_parse_number(field, text, member);
        err = result == SCALAR_OK ? PEL_OK : wrong(c, field, text, result);
    }
    free(text);
    return err;
}

static enum pel_err read_number(struct converter *c,
                                const ProtobufCFieldDescriptor *field,
                                void *member)
{
    char text[JSON_NUMBER_SIZE];
    enum pel_err err = json_number_text(&c->r, text);
    if (err) {
        return err;
    }
    enum scalar_result result = scalar_parse_number(field, text, member);
    return result == SCALAR_OK ? PEL_OK : wrong(c, field, text, result);
}

/* Anything but a message; on failure nothing at `member` needs freeing. */
static enum pel_err read_scalar(struct converter *c,
                                const ProtobufCFieldDescriptor *field,
                                void *member)
{
    enum json_kind kind = json_peek(&c->r);
    switch (kind) {
    case JSON_STRING:
        return read_string(c, field, member);
    case JSON_NUMBER:
        return read_number(c, field, member);
    case JSON_TRUE:
    case JSON_FALSE: {
        enum pel_err err = json_literal(&c->r, kind);
        if (err) {
            return err;
        }
        if (field->type != PROTOBUF_C_TYPE_BOOL) {
            return wrong(c, field, kind == JSON_TRUE ? "true" : "false",
                         SCALAR_WRONG);
        }
        *(protobuf_c_boolean *)member = kind == JSON_TRUE;
        return PEL_OK;
    }
    case JSON_NULL:
        return wrong(c, field, "null", SCALAR_WRONG);
    case JSON_BAD:
        return json_bad(&c->r);
    default:
        return wrong(c, field, NULL, SCALAR_WRONG);
    }
}

/* A message without key given as an array of its scalars, in order. */
static enum pel_err read_positional(struct converter *c, ProtobufCMessage *out)
{
    const ProtobufCMessageDescriptor *type = out->descriptor;
    enum pel_err err = json_enter(&c->r);
    bool first = true, more = false;
    unsigned i = 0;
    while (!err && !(err = json_more(&c->r, ']', &first, &more)) && more) {
        const ProtobufCFieldDescriptor *field = &type->fields[i];
        if (i == type->n_fields || field->type == PROTOBUF_C_TYPE_MESSAGE ||
            field->label == PROTOBUF_C_LABEL_REPEATED) {
            return json_fault(&c->r, PEL_ERR_INVALID, NULL,
                              "has more values than %s has fields",
                              type->short_name);
        }
        const struct pel_field *info = pel_field_info(type, field);
        size_t mark = json_push(&c->r, info->name, strlen(info->name));
        err = read_scalar(c, field, pel_message_member(out, field));
        if (!err) {
            pel_message_mark(out, field);
            json_pop(&c->r, mark);
        }
        i++;
    }
    return err;
}

static void append_double(ProtobufCMessage *message,
                          const ProtobufCFieldDescriptor *field, double value)
{
    double **list = pel_message_member(message, field);
    size_t *count = (size_t *)((char *)message + field->quantifier_offset);
    if ((*count & (*count - 1)) == 0) { /* a power of two, or none */
        *list = pel_sure_realloc(*list, 2 * (*count + 1) * sizeof **list);
    }
    (*list)[(*count)++] = value;
}

static enum pel_err read_element(struct converter *c,
                                 const ProtobufCFieldDescriptor *field,
                                 ProtobufCMessage *list_holder)
{
    if (field->type == PROTOBUF_C_TYPE_MESSAGE) {
        ProtobufCMessage *element = pel_message_append(list_holder, field);
        enum json_kind kind = json_peek(&c->r);
        bool keyed = pel_field_key(field->descriptor) != NULL;
        if (kind == JSON_ARRAY && !keyed) {
            return read_positional(c, element);
        }
        if (kind != JSON_BAD && kind != JSON_OBJECT && !keyed) {
            const ProtobufCMessageDescriptor *type = element->descriptor;
            return json_fault(&c->r, PEL_ERR_INVALID, NULL,
                              "must be an array of its values, [%s, …], or an "
                              "object",
                              pel_field_info(type, &type->fields[0])->name);
        }
        return read_message(c, element);
    }
    if (field->type == PROTOBUF_C_TYPE_STRING) {
        char *text = NULL;
        enum pel_err err = read_scalar(c, field, &text);
        if (text) {
            char ***list = pel_message_member(list_holder, field);
            size_t *count =
                (size_t *)((char *)list_holder + field->quantifier_offset);
            pel_message_append_string(list, count, text);
            free(text);
        }
        return err;
    }
    if (field->type == PROTOBUF_C_TYPE_DOUBLE) {
        double value = 0;
        enum pel_err err = read_scalar(c, field, &value);
        if (!err) {
            append_double(list_holder, field, value);
        }
        return err;
    }
    return json_fault(&c->r, PEL_ERR_INTERNAL, NULL,
                      "is a list of a type that the schema did not have");
}

static enum pel_err read_array(struct converter *c, ProtobufCMessage *message,
                               const ProtobufCFieldDescriptor *field)
{
    enum pel_err err = json_enter(&c->r);
    bool first = true, more = false;
    size_t index = 0;
    c->literal++;
    while (!err && !(err = json_more(&c->r, ']', &first, &more)) && more) {
        char text[24];
        g_snprintf(text, sizeof text, "%zu", index++);
        size_t mark = json_push(&c->r, text, strlen(text));
        err = read_element(c, field, message);
        if (!err) {
            json_pop(&c->r, mark);
        }
    }
    c->literal--;
    return err;
}

/* Gives a keyed element the key that named it in an object. */
static enum pel_err set_key(struct converter *c, ProtobufCMessage *element,
                            const char *name)
{
    const ProtobufCFieldDescriptor *key = pel_field_key(element->descriptor);
    if (key->type == PROTOBUF_C_TYPE_STRING) {
        pel_message_set_string(element, key, name);
        return PEL_OK;
    }
    enum scalar_result result =
        scalar_parse_number(key, name, pel_message_member(element, key));
    if (result == SCALAR_OK) {
        pel_message_mark(element, key);
        return PEL_OK;
    }
    const ProtobufCFieldDescriptor *alias =
        pel_field_by_name(element->descriptor, "name", 4);
    if (result != SCALAR_WRONG || !alias || !name[0]) {
        return wrong(c, key, name, result);
    }
    pel_message_set_string(element, alias, name);
    return PEL_OK;
}

static enum pel_err keyed_member(struct converter *c,
                                 const ProtobufCFieldDescriptor *field,
                                 ProtobufCMessage *message, const char *name)
{
    /* A dot would make another path of it. */
    if (!name[0] || strchr(name, '.') || strlen(name) > 64) {
        return json_fault(&c->r, PEL_ERR_INVALID, name,
                          "must be named by 1 to 64 bytes without a dot");
    }
    if (json_peek(&c->r) == JSON_NULL) {
        enum pel_err err = json_literal(&c->r, JSON_NULL);
        return err          ? err
               : removes(c) ? remove_here(c)
                            : json_fault(&c->r, PEL_ERR_INVALID, "null",
                                         "must be an object: there is nothing "
                                         "to remove here");
    }
    size_t count;
    pel_message_list(message, field, &count);
    if (count >= MAX_KEYED) {
        return json_fault(&c->r, PEL_ERR_OUT_OF_RANGE, NULL,
                          "is one element too many");
    }
    ProtobufCMessage *element = pel_message_append(message, field);
    enum pel_err err = set_key(c, element, name);
    if (err) {
        return err;
    }
    /* The object may name the element once more, but not otherwise. */
    ProtobufCMessage *before = pel_message_copy(element);
    err = read_message(c, element);
    const ProtobufCFieldDescriptor *key = pel_field_key(field->descriptor);
    bool same = true;
    if (!err && pel_message_has(before, key)) {
        const void *a = pel_message_member(before, key);
        const void *b = pel_message_member(element, key);
        same = key->type == PROTOBUF_C_TYPE_STRING
                   ? strcmp(*(char *const *)a, *(char *const *)b) == 0
                   : memcmp(a, b, pel_message_value_size(key)) == 0;
    }
    protobuf_c_message_free_unpacked(before, NULL);
    return same ? err
                : json_fault(&c->r, PEL_ERR_INVALID, NULL,
                             "has another %s inside", key->name);
}

/* {"bridge": {…}, "stern": null} for a keyed list. */
static enum pel_err read_keyed_object(struct converter *c,
                                      ProtobufCMessage *message,
                                      const ProtobufCFieldDescriptor *field)
{
    enum pel_err err = json_enter(&c->r);
    bool first = true, more = false;
    c->mapped++;
    while (!err && !(err = json_more(&c->r, '}', &first, &more)) && more) {
        char *name;
        size_t length;
        err = json_name(&c->r, &name, &length);
        if (err) {
            break;
        }
        size_t mark = json_push(&c->r, name, length);
        err = keyed_member(c, field, message, name);
        if (!err) {
            json_pop(&c->r, mark);
        }
        free(name);
    }
    c->mapped--;
    return err;
}

static enum pel_err read_list(struct converter *c, ProtobufCMessage *message,
                              const ProtobufCFieldDescriptor *field)
{
    enum json_kind kind = json_peek(&c->r);
    bool plain = c->literal == 0;
    bool keyed = field->type == PROTOBUF_C_TYPE_MESSAGE &&
                 pel_field_key(field->descriptor);
    if (kind == JSON_ARRAY) {
        /* Replaces the list, so what was there goes first. */
        enum pel_err err = c->merging && plain ? remove_here(c) : PEL_OK;
        return err ? err : read_array(c, message, field);
    }
    if (kind == JSON_OBJECT && plain && keyed) {
        return read_keyed_object(c, message, field);
    }
    return kind == JSON_BAD
               ? json_bad(&c->r)
               : json_fault(&c->r, PEL_ERR_INVALID, NULL, "must be %s",
                            plain && keyed ? "an array or an object"
                                           : "an array");
}

static enum pel_err read_member(struct converter *c, ProtobufCMessage *message,
                                const ProtobufCFieldDescriptor *field)
{
    if (json_peek(&c->r) == JSON_NULL) {
        enum pel_err err = json_literal(&c->r, JSON_NULL);
        return err || !removes(c) ? err : remove_here(c);
    }
    if (field->label == PROTOBUF_C_LABEL_REPEATED) {
        return read_list(c, message, field);
    }
    if (field->type == PROTOBUF_C_TYPE_MESSAGE) {
        return read_message(c, pel_message_child(message, field));
    }
    /* By way of a temporary, so that a failure leaves nothing half set. */
    union {
        uint64_t number;
        char *text;
        ProtobufCBinaryData bytes;
    } value = { 0 };
    enum pel_err err = read_scalar(c, field, &value);
    if (!err) {
        pel_message_clear(message, field);
        memcpy(pel_message_member(message, field), &value,
               pel_message_value_size(field));
        pel_message_mark(message, field);
    }
    return err;
}

/* Finds the field and refuses a name, or a oneof, that came before. */
static enum pel_err find_member(struct converter *c,
                                const ProtobufCMessage *message,
                                const char *name, size_t length, uint64_t *seen,
                                const ProtobufCFieldDescriptor **out)
{
    const ProtobufCMessageDescriptor *type = message->descriptor;
    const ProtobufCFieldDescriptor *field =
        pel_field_by_name(type, name, length);
    if (!field) {
        return json_fault(&c->r, PEL_ERR_NOT_FOUND, NULL,
                          "is not a field of %s", type->short_name);
    }
    uint64_t bit = (uint64_t)1 << ((field - type->fields) % 64);
    if (*seen & bit) {
        return json_fault(&c->r, PEL_ERR_MALFORMED, NULL, "is given twice");
    }
    *seen |= bit;
    if ((field->flags & PROTOBUF_C_FIELD_FLAG_ONEOF) &&
        *(uint32_t *)((char *)message + field->quantifier_offset) != 0) {
        return json_fault(&c->r, PEL_ERR_INVALID, NULL,
                          "cannot stand beside another of its choices");
    }
    *out = field;
    return PEL_OK;
}

static enum pel_err read_members(struct converter *c, ProtobufCMessage *out);

/* A Patch within another message, as that of an exercise's event: what an
 * object of elements removes goes into its `remove`. */
static enum pel_err read_patch(struct converter *c, ProtobufCMessage *out)
{
    struct converter outer = *c;
    c->patch = (Pelagos__Patch *)out;
    c->literal = c->mapped = 0;
    c->base =
        c->r.path_length + (c->r.path_length > 0 ? 1 : 0) + strlen("state.");
    enum pel_err err = read_members(c, out);
    c->patch = outer.patch;
    c->literal = outer.literal;
    c->mapped = outer.mapped;
    c->base = outer.base;
    return err;
}

static enum pel_err read_message(struct converter *c, ProtobufCMessage *out)
{
    return out->descriptor == &pelagos__patch__descriptor
               ? read_patch(c, out)
               : read_members(c, out);
}

static enum pel_err read_members(struct converter *c, ProtobufCMessage *out)
{
    enum json_kind kind = json_peek(&c->r);
    if (kind == JSON_BAD) {
        return json_bad(&c->r);
    }
    if (kind != JSON_OBJECT) {
        return json_fault(&c->r, PEL_ERR_INVALID, NULL, "must be an object");
    }
    enum pel_err err = json_enter(&c->r);
    bool first = true, more = false;
    uint64_t seen = 0;
    while (!err && !(err = json_more(&c->r, '}', &first, &more)) && more) {
        char *name;
        size_t length;
        const ProtobufCFieldDescriptor *field = NULL;
        err = json_name(&c->r, &name, &length);
        if (err) {
            break;
        }
        size_t mark = json_push(&c->r, name, length);
        err = find_member(c, out, name, length, &seen, &field);
        if (field) {
            /* The path in the schema's spelling, whatever was written. */
            const struct pel_field *info =
                pel_field_info(out->descriptor, field);
            json_pop(&c->r, mark);
            json_push(&c->r, info->name, strlen(info->name));
            err = read_member(c, out, field);
        }
        if (!err) {
            json_pop(&c->r, mark);
        }
        free(name);
    }
    return err;
}

static enum pel_err convert(struct converter *c, const char *text,
                            size_t length, ProtobufCMessage *out,
                            struct pel_fault *fault)
{
    if (length > PEL_JSON_MAX_BYTES) {
        return pel_fault_set(fault, PEL_ERR_MALFORMED,
                             "the text is longer than %d bytes",
                             PEL_JSON_MAX_BYTES);
    }
    json_begin(&c->r, text, length, fault);
    enum pel_err err = read_message(c, out);
    return err ? err : json_end(&c->r);
}

enum pel_err pel_json_to_message(const char *text, size_t length,
                                 const ProtobufCMessageDescriptor *type,
                                 ProtobufCMessage **out,
                                 struct pel_fault *fault)
{
    struct converter c = { 0 };
    ProtobufCMessage *message = pel_message_new(type);
    enum pel_err err = convert(&c, text, length, message, fault);
    if (err) {
        protobuf_c_message_free_unpacked(message, NULL);
        message = NULL;
    }
    *out = message;
    return err;
}

enum pel_err pel_json_merge_patch(const char *text, size_t length,
                                  Pelagos__Patch **out, struct pel_fault *fault)
{
    Pelagos__Patch *patch =
        (Pelagos__Patch *)pel_message_new(&pelagos__patch__descriptor);
    struct converter c = { .patch = patch, .merging = true };
    patch->state =
        (Pelagos__State *)pel_message_new(&pelagos__state__descriptor);
    enum pel_err err = convert(&c, text, length, &patch->state->base, fault);
    if (err) {
        pelagos__patch__free_unpacked(patch, NULL);
        patch = NULL;
    }
    *out = patch;
    return err;
}
