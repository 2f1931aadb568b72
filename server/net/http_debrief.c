/* Recordings and the debrief over HTTP. */
#include <string.h>

#include "json.h"
#include "net/command.h"
#include "net/http_view.h"

/* The body as a tested message; NULL: answered. */
static ProtobufCMessage *read_body(const struct pel_http_call *call,
                                   const ProtobufCMessageDescriptor *type)
{
    struct pel_fault fault;
    ProtobufCMessage *message = NULL;
    enum pel_err err = pel_http_body(call, type, &message, &fault);
    if (!err) {
        err = pel_command_check(message, &fault);
    }
    if (err) {
        if (message) {
            protobuf_c_message_free_unpacked(message, NULL);
        }
        pel_http_refuse(call, err == PEL_ERR_NOT_FOUND ? 400 : 0, &fault);
        return NULL;
    }
    return message;
}

static bool has_debrief(const struct pel_http_call *call)
{
    struct pel_fault fault;
    if (!call->context->debrief) {
        pel_fault_set(&fault, PEL_ERR_NOT_FOUND,
                      "there are no recordings here");
        pel_http_refuse(call, 404, &fault);
    }
    return call->context->debrief != NULL;
}

void pel_http_get_recordings(const struct pel_http_call *call)
{
    if (has_debrief(call)) {
        call->answer->kind = PEL_HTTP_RECORDINGS;
    }
}

void pel_http_post_recording(const struct pel_http_call *call)
{
    struct pel_fault fault;
    ProtobufCMessage *command =
        has_debrief(call)
            ? read_body(call, &pelagos__recording_command__descriptor)
            : NULL;
    if (!command) {
        return;
    }
    enum pel_err err = pel_debrief_record(
        call->context->debrief, (Pelagos__RecordingCommand *)command, &fault);
    protobuf_c_message_free_unpacked(command, NULL);
    if (err) {
        pel_http_refuse(call, 0, &fault);
    } else {
        call->answer->kind = PEL_HTTP_RECORDINGS;
    }
}

static void answer_status(const struct pel_http_call *call)
{
    const Pelagos__Debrief *status = pel_debrief_status(call->context->debrief);
    pel_http_copy(call->answer, 200, &status->base);
}

void pel_http_get_debrief(const struct pel_http_call *call)
{
    if (has_debrief(call)) {
        answer_status(call);
    }
}

void pel_http_post_debrief(const struct pel_http_call *call)
{
    struct pel_fault fault;
    ProtobufCMessage *command =
        has_debrief(call)
            ? read_body(call, &pelagos__debrief_command__descriptor)
            : NULL;
    if (!command) {
        return;
    }
    enum pel_err err = pel_debrief_do(
        call->context->debrief, (Pelagos__DebriefCommand *)command, &fault);
    protobuf_c_message_free_unpacked(command, NULL);
    if (err) {
        pel_http_refuse(call, 0, &fault);
    } else {
        answer_status(call);
    }
}

bool pel_http_of_debrief(struct pel_http_context *context,
                         struct pel_http_call *call)
{
    struct pel_http_target *target = call->target;
    struct pel_fault fault;
    if (target->segment_count < 3 || strcmp(target->segments[1], "debrief")) {
        return true;
    }
    if (!context->debrief || !pel_debrief_scene(context->debrief)) {
        pel_fault_set(&fault, PEL_ERR_NOT_FOUND,
                      "no recording is open for a debrief");
        pel_http_refuse(call, 404, &fault);
        return false;
    }
    context->scene = pel_debrief_scene(context->debrief);
    context->frames = pel_debrief_frames(context->debrief);
    call->context = context;
    call->answer->debrief = true;
    /* The rest of the place is that of the live one. */
    for (size_t i = 1; i + 1 < target->segment_count; i++) {
        target->segments[i] = target->segments[i + 1];
    }
    target->segment_count--;
    return true;
}
