#include "net/roles.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <glib.h>

#include "fault.h"
#include "fields.h"
#include "message.h"

static const char *const names[] = { "none", "watch", "steer", "instruct" };

enum pel_role pel_role_of_rank(enum pel_rank rank)
{
    return (enum pel_role)(PEL_RANK_NOBODY - rank);
}

enum pel_rank pel_rank_of_role(enum pel_role role)
{
    return (enum pel_rank)(PEL_ROLE_INSTRUCT - role);
}

const char *pel_role_name(enum pel_role role)
{
    return names[role];
}

enum pel_role pel_role_by_name(const char *name)
{
    for (int i = PEL_ROLE_WATCH; i <= PEL_ROLE_INSTRUCT; i++) {
        if (strcmp(name, names[i]) == 0) {
            return (enum pel_role)i;
        }
    }
    return PEL_ROLE_NONE;
}

enum pel_role pel_role_of_route(const char *method, const char *pattern)
{
    static const struct {
        enum pel_role role;
        const char *method, *pattern;
    } rows[] = {
#define PEL_ROLE_ROUTE(role, method, path) { PEL_ROLE_##role, method, path },
#include "proto/roles.def"
    };
    for (size_t i = 0; i < G_N_ELEMENTS(rows); i++) {
        if (strcmp(rows[i].method, method) == 0 &&
            strcmp(rows[i].pattern, pattern) == 0) {
            return rows[i].role;
        }
    }
    return strcmp(method, "GET") == 0 ? PEL_ROLE_WATCH : PEL_ROLE_INSTRUCT;
}

enum pel_role pel_role_of_command(Pelagos__Request__CommandCase command)
{
    switch (command) {
#define PEL_ROLE_COMMAND(role, command)                                        \
    case PELAGOS__REQUEST__COMMAND_##command:                                  \
        return PEL_ROLE_##role;
#include "proto/roles.def"
    case PELAGOS__REQUEST__COMMAND__NOT_SET:
        return PEL_ROLE_WATCH; /* it is refused as such */
    default:
        return PEL_ROLE_INSTRUCT;
    }
}

enum pel_err pel_role_need(enum pel_role has, enum pel_role needs,
                           const char *what, struct pel_fault *fault)
{
    if (has >= needs) {
        return PEL_OK;
    }
    return pel_fault_set(fault, PEL_ERR_FORBIDDEN,
                         "%.120s needs the role %s; this token's is %s", what,
                         names[needs], names[has]);
}

/* --- patches -------------------------------------------------------------- */

static const struct {
    enum pel_role role;
    const char *path;
} field_rows[] = {
#define PEL_ROLE_FIELD(role, path) { PEL_ROLE_##role, path },
#include "proto/roles.def"
};

static enum pel_role of_field(const char *path)
{
    for (size_t i = 0; i < G_N_ELEMENTS(field_rows); i++) {
        if (strcmp(field_rows[i].path, path) == 0) {
            return field_rows[i].role;
        }
    }
    return PEL_ROLE_INSTRUCT;
}

const char *pel_role_field(enum pel_role has, size_t i)
{
    if (has == PEL_ROLE_INSTRUCT) {
        return i == 0 ? "*" : NULL;
    }
    for (size_t k = 0; k < G_N_ELEMENTS(field_rows); k++) {
        if (has >= field_rows[k].role && i-- == 0) {
            return field_rows[k].path;
        }
    }
    return NULL;
}

/* `path` as the client knows it, `rule` as the table has it. */
static enum pel_err need_field(enum pel_role has, const char *path,
                               const char *rule, struct pel_fault *fault)
{
    enum pel_err err = pel_role_need(has, of_field(rule), path, fault);
    if (err && fault) {
        g_strlcpy(fault->path, path, sizeof fault->path);
    }
    return err;
}

/* Own ship, by its number or by a name that is its alone. */
static bool is_own(const Pelagos__State *state, const Pelagos__Entity *with)
{
    size_t named = 0;
    bool own = false;
    for (size_t i = 0; i < state->n_entities; i++) {
        const Pelagos__Entity *e = state->entities[i];
        bool same = with->has_id ? e->id == with->id
                                 : with->name && e->name &&
                                       strcmp(e->name, with->name) == 0;
        named += same;
        own = own || (same && e->id == state->own_ship->entity);
    }
    return own && named == 1;
}

static bool is_view(const Pelagos__State *state, const Pelagos__View *with)
{
    for (size_t i = 0; i < state->n_views; i++) {
        if (with->name && strcmp(state->views[i]->name, with->name) == 0) {
            return true;
        }
    }
    return false;
}

/* The fields of one message: what names an element is no change of it. */
static enum pel_err need_fields(enum pel_role has,
                                const ProtobufCMessage *message,
                                const char *path, const char *rule,
                                bool element, struct pel_fault *fault)
{
    const ProtobufCMessageDescriptor *type = message->descriptor;
    const ProtobufCFieldDescriptor *key = pel_field_key(type);
    const Pelagos__Entity *entity = (const Pelagos__Entity *)message;
    bool by_name =
        element && type == &pelagos__entity__descriptor && !entity->has_id;
    for (unsigned i = 0; i < type->n_fields; i++) {
        const ProtobufCFieldDescriptor *field = &type->fields[i];
        char at[160], as[160];
        bool names_it =
            element &&
            (field == key || (by_name && strcmp(field->name, "name") == 0));
        if (!pel_message_has(message, field) || names_it) {
            continue;
        }
        const char *name = pel_field_info(type, field)->name;
        g_snprintf(at, sizeof at, "%s.%s", path, name);
        g_snprintf(as, sizeof as, "%s.%s", rule, name);
        enum pel_err err = need_field(has, at, as, fault);
        if (err) {
            return err;
        }
    }
    return PEL_OK;
}

static enum pel_err need_elements(enum pel_role has, const Pelagos__State *to,
                                  const Pelagos__State *state,
                                  struct pel_fault *fault)
{
    char path[128];
    enum pel_err err = PEL_OK;
    for (size_t i = 0; i < to->n_entities && !err; i++) {
        const Pelagos__Entity *e = to->entities[i];
        if (e->has_id) {
            g_snprintf(path, sizeof path, "entities.%u", e->id);
        } else {
            g_snprintf(path, sizeof path, "entities.%.80s",
                       e->name ? e->name : "");
        }
        err = is_own(state, e) ? need_fields(has, &e->base, path,
                                             "entities.own", true, fault)
                               : need_field(has, path, "entities", fault);
    }
    for (size_t i = 0; i < to->n_views && !err; i++) {
        const Pelagos__View *v = to->views[i];
        g_snprintf(path, sizeof path, "views.%.80s", v->name ? v->name : "");
        err = is_view(state, v)
                  ? need_fields(has, &v->base, path, "views.*", true, fault)
                  : need_field(has, path, "views", fault);
    }
    return err;
}

static enum pel_err need_parts(enum pel_role has, const Pelagos__State *to,
                               struct pel_fault *fault)
{
    const ProtobufCMessageDescriptor *type = &pelagos__state__descriptor;
    enum pel_err err = PEL_OK;
    for (unsigned i = 0; i < type->n_fields && !err; i++) {
        const ProtobufCFieldDescriptor *field = &type->fields[i];
        const char *name = pel_field_info(type, field)->name;
        if (!pel_message_has(&to->base, field) ||
            strcmp(field->name, "revision") == 0 ||
            strcmp(field->name, "entities") == 0 ||
            strcmp(field->name, "views") == 0) {
            continue;
        }
        if (field->label != PROTOBUF_C_LABEL_REPEATED &&
            field->type == PROTOBUF_C_TYPE_MESSAGE) {
            err = need_fields(has,
                              *(ProtobufCMessage *const *)pel_message_member(
                                  &to->base, field),
                              name, name, false, fault);
        } else {
            err = need_field(has, name, name, fault);
        }
    }
    return err;
}

/* --- reading -------------------------------------------------------------- */

static const struct {
    enum pel_role role;
    const char *field;
} read_rows[] = {
#define PEL_ROLE_READ(role, field) { PEL_ROLE_##role, field },
#include "proto/roles.def"
};

/* NULL: everybody reads it. */
static const char *hidden_field(enum pel_role has, const char *name)
{
    size_t length = strcspn(name, ".");
    for (size_t i = 0; i < G_N_ELEMENTS(read_rows); i++) {
        const char *field = read_rows[i].field;
        if (has < read_rows[i].role && strlen(field) == length &&
            strncmp(field, name, length) == 0) {
            return field;
        }
    }
    return NULL;
}

void pel_role_seen(enum pel_role has, const Pelagos__State *state,
                   Pelagos__State *out)
{
    const ProtobufCMessageDescriptor *type = &pelagos__state__descriptor;
    *out = *state;
    for (unsigned i = 0; i < type->n_fields; i++) {
        const ProtobufCFieldDescriptor *field = &type->fields[i];
        bool many = field->label == PROTOBUF_C_LABEL_REPEATED;
        if (!hidden_field(has, pel_field_info(type, field)->name)) {
            continue;
        }
        if (many) {
            *(size_t *)((char *)out + field->quantifier_offset) = 0;
        } else { /* a message: roles_test.c */
            *(void **)((char *)out + field->offset) = NULL;
        }
    }
}

enum pel_err pel_role_read(enum pel_role has, const char *path,
                           struct pel_fault *fault)
{
    const char *field = hidden_field(has, path);
    for (size_t i = 0; field && i < G_N_ELEMENTS(read_rows); i++) {
        if (strcmp(read_rows[i].field, field) == 0) {
            enum pel_err err =
                pel_role_need(has, read_rows[i].role, path, fault);
            pel_fault_at(fault, path, NULL);
            return err;
        }
    }
    return PEL_OK;
}

enum pel_err pel_role_patch(enum pel_role has, const Pelagos__Patch *patch,
                            const Pelagos__State *state,
                            struct pel_fault *fault)
{
    enum pel_err err = PEL_OK;
    if (has == PEL_ROLE_INSTRUCT) {
        return PEL_OK;
    }
    /* Of a role that may set some fields none may be taken away: a path may
     * name a whole part. */
    for (size_t i = 0; i < patch->n_remove && !err; i++) {
        err = need_field(has, patch->remove[i], "", fault);
    }
    if (!err && patch->state) {
        err = need_parts(has, patch->state, fault);
    }
    if (!err && patch->state) {
        err = need_elements(has, patch->state, state, fault);
    }
    return err;
}
