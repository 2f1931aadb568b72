/* Bodies of requests as messages, and of answers as text: what takes time of
 * both may be done by any thread. */
#include <stdlib.h>
#include <string.h>

#include "base/reserve.h"
#include "fields.h"
#include "json.h"
#include "message.h"
#include "net/http_view.h"
#include "scene/presets.h"

/* --- requests ------------------------------------------------------------- */

/* The word for a merge patch of State in proto/routes.def. */
#define MERGE "merge"

static const ProtobufCMessageDescriptor *type_named(const char *name)
{
    for (size_t i = 0; i < pel_field_table_count; i++) {
        if (strcmp(pel_field_tables[i].message->short_name, name) == 0) {
            return pel_field_tables[i].message;
        }
    }
    return NULL;
}

static enum pel_err read_merge(const char *body, size_t size,
                               ProtobufCMessage **out, struct pel_fault *fault)
{
    Pelagos__Patch *patch = NULL;
    enum pel_err err = pel_json_merge_patch(body, size, &patch, fault);
    if (!err && patch->state) {
        pel_presets_learn(patch->state);
    }
    *out = patch ? &patch->base : NULL;
    return err;
}

void pel_http_read(const char *name, const char *body, size_t size,
                   struct pel_http_read *out)
{
    const ProtobufCMessageDescriptor *type = type_named(name);
    *out = (struct pel_http_read){ .err = PEL_OK };
    if (strcmp(name, MERGE) == 0) {
        out->err = read_merge(body, size, &out->message, &out->fault);
    } else if (type) {
        out->err =
            pel_json_to_message(body, size, type, &out->message, &out->fault);
    } else {
        out->err = pel_fault_set(&out->fault, PEL_ERR_INTERNAL,
                                 "there is no message %s", name);
    }
}

void pel_http_read_finish(struct pel_http_read *read)
{
    if (read->message) {
        protobuf_c_message_free_unpacked(read->message, NULL);
        read->message = NULL;
    }
}

/* It was read already; who reads a body of no message has none. */
static enum pel_err take(struct pel_http_read *read, ProtobufCMessage **out,
                         struct pel_fault *fault)
{
    *out = read->message;
    read->message = NULL;
    if (read->err) {
        *fault = read->fault;
    }
    return read->err;
}

enum pel_err pel_http_body(const struct pel_http_call *call,
                           const ProtobufCMessageDescriptor *type,
                           ProtobufCMessage **out, struct pel_fault *fault)
{
    const struct pel_http_request *request = call->request;
    *out = NULL;
    return request->read
               ? take(request->read, out, fault)
               : pel_json_to_message(request->body, request->body_size, type,
                                     out, fault);
}

enum pel_err pel_http_body_if_any(const struct pel_http_call *call,
                                  const ProtobufCMessageDescriptor *type,
                                  ProtobufCMessage **out,
                                  struct pel_fault *fault)
{
    const struct pel_http_request *request = call->request;
    return request->read || request->body_size > 0
               ? pel_http_body(call, type, out, fault)
               : pel_json_to_message("{}", 2, type, out, fault);
}

enum pel_err pel_http_merge_body(const struct pel_http_call *call,
                                 Pelagos__Patch **out, struct pel_fault *fault)
{
    const struct pel_http_request *request = call->request;
    ProtobufCMessage *message = NULL;
    enum pel_err err =
        request->read
            ? take(request->read, &message, fault)
            : read_merge(request->body, request->body_size, &message, fault);
    *out = (Pelagos__Patch *)message;
    return err;
}

/* --- answers -------------------------------------------------------------- */

void pel_http_message(struct pel_http_answer *answer, int status,
                      ProtobufCMessage *message, bool pretty)
{
    answer->status = status;
    answer->type = "application/json";
    answer->message = message;
    answer->pretty = pretty;
}

/* A long one packed: that is one piece of memory, which another thread frees,
 * and half the time of a copy. */
void pel_http_copy(struct pel_http_answer *answer, int status,
                   const ProtobufCMessage *message)
{
    size_t size = protobuf_c_message_get_packed_size(message);
    if (size <= PEL_HTTP_AT_ONCE) {
        pel_http_message(answer, status, pel_message_copy(message), false);
        return;
    }
    pel_http_message(answer, status, NULL, false);
    answer->packed = pel_sure_malloc(size);
    answer->packed_size = protobuf_c_message_pack(message, answer->packed);
    answer->packed_type = message->descriptor;
}

bool pel_http_is_long(const struct pel_http_answer *answer)
{
    return answer->packed ||
           (answer->message && protobuf_c_message_get_packed_size(
                                   answer->message) > PEL_HTTP_AT_ONCE);
}

void pel_http_write(struct pel_http_answer *answer)
{
    ProtobufCMessage *message = answer->message;
    if (answer->packed) {
        message = protobuf_c_message_unpack(
            answer->packed_type, NULL, answer->packed_size, answer->packed);
        free(answer->packed);
        answer->packed = NULL;
    }
    if (!message) {
        return;
    }
    answer->message = NULL;
    if (answer->write) {
        answer->write(answer, message);
    } else {
        pel_http_json(answer, answer->status,
                      pel_json_from_message(message, answer->pretty));
    }
    protobuf_c_message_free_unpacked(message, NULL);
}
