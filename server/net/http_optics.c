#include <stdio.h>
#include <string.h>

#include <glib.h>

#include "fields.h"
#include "json.h"
#include "message.h"
#include "net/command.h"
#include "net/http_view.h"
#include "path.h"
#include "scalar.h"

enum pel_err pel_http_number(ProtobufCMessage *message, const char *name,
                             const char *text, struct pel_fault *fault)
{
    const ProtobufCFieldDescriptor *field =
        pel_field_by_name(message->descriptor, name, strlen(name));
    if (!field || field->type == PROTOBUF_C_TYPE_MESSAGE) {
        return pel_fault_value(fault, PEL_ERR_NOT_FOUND, name, text,
                               "no such parameter");
    }
    const bool truth = strcmp(text, "true") == 0;
    if (field->type == PROTOBUF_C_TYPE_BOOL &&
        (truth || strcmp(text, "false") == 0)) {
        *(protobuf_c_boolean *)pel_message_member(message, field) = truth;
    } else if (scalar_parse_number(field, text,
                                   pel_message_member(message, field)) !=
               SCALAR_OK) {
        char expected[120], what[160];
        snprintf(what, sizeof what, "must be %s",
                 scalar_expects(field, expected));
        return pel_fault_value(fault, PEL_ERR_INVALID, name, text, what);
    }
    pel_message_mark(message, field);
    return PEL_OK;
}

/* `from`, `time`, fields of the question by their names, and paths of the state
 * (sky.sunElevation=20), which hold for this answer only. */
static enum pel_err read_parameters(const struct pel_http_call *call,
                                    Pelagos__OpticsQuery *query,
                                    ProtobufCMessage *question,
                                    struct pel_fault *fault)
{
    const Pelagos__State *now = pel_scene_state(call->context->scene);
    enum pel_err err = PEL_OK;
    for (size_t i = 0; i < call->target->query_count && err == PEL_OK; i++) {
        const struct pel_http_pair *pair = &call->target->query[i];
        if (strchr(pair->name, '.')) {
            query->patch = query->patch ? query->patch : pel_patch_new();
            err =
                pel_path_set(query->patch, now, pair->name, pair->value, fault);
        } else {
            bool above = strcmp(pair->name, "from") == 0 ||
                         strcmp(pair->name, "time") == 0;
            err = pel_http_number(above ? &query->base : question, pair->name,
                                  pair->value, fault);
        }
    }
    return err;
}

static void carry_out(const struct pel_http_call *call,
                      Pelagos__OpticsQuery *query)
{
    call->answer->kind = PEL_HTTP_OPTICS;
    call->answer->optics = query;
}

void pel_http_get_optics(const struct pel_http_call *call)
{
    enum { QUESTION = 2 };
    const char *name = call->target->segments[QUESTION];
    const ProtobufCFieldDescriptor *field = pel_field_by_name(
        &pelagos__optics_query__descriptor, name, strlen(name));
    struct pel_fault fault;
    if (!field || !(field->flags & PROTOBUF_C_FIELD_FLAG_ONEOF)) {
        pel_fault_set(&fault, PEL_ERR_NOT_FOUND, "optics has no %.60s", name);
        pel_http_refuse(call, 404, &fault);
        return;
    }
    Pelagos__OpticsQuery *query = (Pelagos__OpticsQuery *)pel_message_new(
        &pelagos__optics_query__descriptor);
    ProtobufCMessage *question = pel_message_child(&query->base, field);
    if (read_parameters(call, query, question, &fault) == PEL_OK) {
        carry_out(call, query);
        return;
    }
    pelagos__optics_query__free_unpacked(query, NULL);
    pel_http_refuse(call, 400, &fault);
}

void pel_http_post_optics(const struct pel_http_call *call)
{
    struct pel_fault fault;
    ProtobufCMessage *message = NULL;
    enum pel_err err = pel_http_body(call, &pelagos__optics_query__descriptor,
                                     &message, &fault);
    if (err == PEL_OK) {
        carry_out(call, (Pelagos__OpticsQuery *)message);
    } else {
        pel_http_refuse(call, err == PEL_ERR_NOT_FOUND ? 400 : 0, &fault);
    }
}

/* A message whose fields are the query's parameters; NULL: it was refused. */
static ProtobufCMessage *read_query(const struct pel_http_call *call,
                                    const ProtobufCMessageDescriptor *type)
{
    struct pel_fault fault;
    ProtobufCMessage *query = pel_message_new(type);
    enum pel_err err = PEL_OK;
    for (size_t i = 0; i < call->target->query_count && err == PEL_OK; i++) {
        const struct pel_http_pair *pair = &call->target->query[i];
        err = pel_http_number(query, pair->name, pair->value, &fault);
    }
    if (err == PEL_OK) {
        err = pel_command_check(query, &fault);
    }
    if (err != PEL_OK) {
        protobuf_c_message_free_unpacked(query, NULL);
        pel_http_refuse(call, err == PEL_ERR_NOT_FOUND ? 400 : 0, &fault);
        return NULL;
    }
    return query;
}

void pel_http_get_almanac(const struct pel_http_call *call)
{
    call->answer->almanac = (Pelagos__AlmanacQuery *)read_query(
        call, &pelagos__almanac_query__descriptor);
    if (call->answer->almanac) {
        call->answer->kind = PEL_HTTP_ALMANAC;
    }
}

void pel_http_get_soundings(const struct pel_http_call *call)
{
    call->answer->soundings = (Pelagos__SoundingsQuery *)read_query(
        call, &pelagos__soundings_query__descriptor);
    if (call->answer->soundings) {
        call->answer->kind = PEL_HTTP_SOUNDINGS;
    }
}
