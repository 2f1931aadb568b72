/* /v1/exercise and /v1/exercises, /v1/cluster. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <glib.h>

#include "cluster/cluster.h"
#include "fault.h"
#include "json.h"
#include "message.h"
#include "net/command.h"
#include "net/http_view.h"
#include "scene/exercise.h"

#define MOST_FACTS (64u << 20)

/* NULL: refused already. */
static Pelagos__ExerciseStatus *ask(const struct pel_http_call *call,
                                    const Pelagos__ExerciseCommand *command,
                                    int not_found)
{
    Pelagos__ExerciseStatus *status = NULL;
    struct pel_fault fault = { 0 };
    enum pel_err err = call->context->exercises
                           ? pel_exercises_command(call->context->exercises,
                                                   command, &status, &fault)
                           : pel_fault_set(&fault, PEL_ERR_NOT_FOUND,
                                           "there are no exercises here");
    if (err) {
        pel_http_refuse(call, err == PEL_ERR_NOT_FOUND ? not_found : 0, &fault);
    }
    return err ? NULL : status;
}

/* The command, which is taken over, is to be carried out. */
static void carry_out(const struct pel_http_call *call,
                      Pelagos__ExerciseCommand *command, int not_found,
                      int shows)
{
    struct pel_fault fault;
    if (call->context->exercises) {
        call->answer->kind = PEL_HTTP_EXERCISE;
        call->answer->exercise = command;
        call->answer->not_found = not_found;
        call->answer->shows = shows;
        return;
    }
    pelagos__exercise_command__free_unpacked(command, NULL);
    pel_fault_set(&fault, PEL_ERR_NOT_FOUND, "there are no exercises here");
    pel_http_refuse(call, not_found, &fault);
}

/* A command about what the URL names. */
static Pelagos__ExerciseCommand about(const struct pel_http_call *call,
                                      Pelagos__ExerciseAction action)
{
    Pelagos__ExerciseCommand command = PELAGOS__EXERCISE_COMMAND__INIT;
    command.has_action = true;
    command.action = action;
    command.name = call->target->segment_count > 2
                       ? (char *)call->target->segments[2]
                       : NULL;
    return command;
}

static void carry_out_about(const struct pel_http_call *call,
                            Pelagos__ExerciseAction action, int shows)
{
    const Pelagos__ExerciseCommand command = about(call, action);
    carry_out(call, (Pelagos__ExerciseCommand *)pel_message_copy(&command.base),
              404, shows);
}

void pel_http_get_exercise(const struct pel_http_call *call)
{
    carry_out_about(call, PELAGOS__EXERCISE_ACTION__STATUS, PEL_HTTP_STATUS_OF);
}

void pel_http_post_exercise(const struct pel_http_call *call)
{
    struct pel_fault fault;
    ProtobufCMessage *message = NULL;
    enum pel_err err = pel_http_body_if_any(
        call, &pelagos__exercise_command__descriptor, &message, &fault);
    if (err) {
        pel_http_refuse(call, err == PEL_ERR_NOT_FOUND ? 400 : 0, &fault);
        return;
    }
    carry_out(call, (Pelagos__ExerciseCommand *)message, 400,
              PEL_HTTP_STATUS_OF);
}

void pel_http_get_cluster(const struct pel_http_call *call)
{
    Pelagos__Cluster *cluster = pel_cluster_status(call->context->cluster);
    pel_http_message(call->answer, 200, &cluster->base, false);
}

/* The body says where, if there is one. */
static void place(const struct pel_http_call *call, ProtobufCMessage *message)
{
    Pelagos__ClusterPlaceCommand *command =
        (Pelagos__ClusterPlaceCommand *)message;
    struct pel_fault fault;
    const char *view = call->target->segments[3];
    if (command->view && strcmp(command->view, view) != 0) {
        pel_fault_value(&fault, PEL_ERR_INVALID, "view", command->view,
                        "the URL names another view");
        pel_http_refuse(call, 0, &fault);
        protobuf_c_message_free_unpacked(message, NULL);
        return;
    }
    free(command->view);
    command->view = strdup(view);
    call->answer->kind = PEL_HTTP_PLACE;
    call->answer->place = command;
}

void pel_http_put_place(const struct pel_http_call *call)
{
    struct pel_fault fault;
    ProtobufCMessage *message = NULL;
    enum pel_err err = pel_http_body_if_any(
        call, &pelagos__cluster_place_command__descriptor, &message, &fault);
    if (!err && !((Pelagos__ClusterPlaceCommand *)message)->node) {
        protobuf_c_message_free_unpacked(message, NULL);
        err = pel_fault_value(&fault, PEL_ERR_INVALID, "node", "",
                              "a node is needed, as in {\"node\": \"a\"}");
    }
    if (err) {
        pel_http_refuse(call, err == PEL_ERR_NOT_FOUND ? 400 : 0, &fault);
    } else {
        place(call, message);
    }
}

void pel_http_delete_place(const struct pel_http_call *call)
{
    place(call, pel_message_new(&pelagos__cluster_place_command__descriptor));
}

void pel_http_get_placed(const struct pel_http_call *call)
{
    bool here = true;
    const Pelagos__View *view = pel_http_need_view(call);
    if (!view) {
        return;
    }
    Pelagos__ClusterPlace *now =
        pel_cluster_placed(call->context->cluster, view->name, &here);
    pel_http_message(call->answer, here ? 200 : 503, &now->base, false);
}

void pel_http_get_exercises(const struct pel_http_call *call)
{
    carry_out_about(call, PELAGOS__EXERCISE_ACTION__LIST, PEL_HTTP_STATUS_OF);
}

void pel_http_get_one_exercise(const struct pel_http_call *call)
{
    carry_out_about(call, PELAGOS__EXERCISE_ACTION__SHOW, PEL_HTTP_EXERCISE_OF);
}

void pel_http_put_exercise(const struct pel_http_call *call)
{
    struct pel_fault fault;
    ProtobufCMessage *message = NULL;
    enum pel_err err = pel_http_body_if_any(
        call, &pelagos__exercise__descriptor, &message, &fault);
    if (err) {
        pel_http_refuse(call, err == PEL_ERR_NOT_FOUND ? 400 : 0, &fault);
        return;
    }
    const Pelagos__ExerciseCommand save =
        about(call, PELAGOS__EXERCISE_ACTION__SAVE);
    Pelagos__ExerciseCommand *command =
        (Pelagos__ExerciseCommand *)pel_message_copy(&save.base);
    command->exercise = (Pelagos__Exercise *)message;
    carry_out(call, command, 400, PEL_HTTP_SAVED);
}

void pel_http_delete_exercise(const struct pel_http_call *call)
{
    carry_out_about(call, PELAGOS__EXERCISE_ACTION__DELETE, PEL_HTTP_NOTHING);
}

/* `ship`, and nothing else. */
static enum pel_err read_ship(const struct pel_http_call *call,
                              Pelagos__ExerciseCommand *command,
                              struct pel_fault *fault)
{
    enum pel_err err = PEL_OK;
    double value = 0;
    for (size_t i = 0; i < call->target->query_count && !err; i++) {
        const struct pel_http_pair *pair = &call->target->query[i];
        err = strcmp(pair->name, "ship") == 0
                  ? pel_command_number(command->base.descriptor, pair->name,
                                       pair->value, &value, fault)
                  : pel_fault_value(fault, PEL_ERR_INVALID, pair->name,
                                    pair->value,
                                    "no such parameter: ship is known");
        command->has_ship = !err;
        command->ship = (uint32_t)value;
    }
    return err;
}

/* All of them, which the exercise keeps below 64 MiB. */
void pel_http_get_facts(const struct pel_http_call *call)
{
    g_autoptr(GString) text = g_string_new(NULL);
    struct pel_fault fault;
    Pelagos__ExerciseCommand command =
        about(call, PELAGOS__EXERCISE_ACTION__FACTS);
    if (read_ship(call, &command, &fault)) {
        pel_http_refuse(call, 0, &fault);
        return;
    }
    for (bool more = true; more && text->len <= MOST_FACTS;) {
        Pelagos__ExerciseStatus *status = ask(call, &command, 404);
        if (!status) {
            return;
        }
        g_string_append(text, status->facts);
        more = status->has_more;
        command.has_time = true;
        command.time = status->more;
        pelagos__exercise_status__free_unpacked(status, NULL);
    }
    call->answer->status = 200;
    call->answer->type = "text/csv; charset=utf-8";
    call->answer->size = text->len;
    call->answer->owned = g_string_free(g_steal_pointer(&text), FALSE);
    call->answer->body = call->answer->owned;
}
