#include "net/http_view.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <glib.h>

#include "base/reserve.h"
#include "fields.h"
#include "formats.h"
#include "json.h"
#include "layers.h"
#include "message.h"
#include "net/command.h"
#include "path.h"

enum { NAME = 2, FILE_NAME = 3 }; /* segments of /v1/views/NAME/FILE */

const char *pel_http_view_name(const struct pel_http_call *call)
{
    return call->target->segments[NAME];
}

/* NULL: none, and answered with 404. */
static const Pelagos__View *find_view(const struct pel_http_call *call)
{
    const Pelagos__State *state = pel_scene_state(call->context->scene);
    for (size_t i = 0; i < state->n_views; i++) {
        if (strcmp(state->views[i]->name, pel_http_view_name(call)) == 0) {
            return state->views[i];
        }
    }
    return NULL;
}

const Pelagos__View *pel_http_need_view(const struct pel_http_call *call)
{
    const Pelagos__View *view = find_view(call);
    if (!view) {
        struct pel_fault fault;
        pel_fault_set(&fault, PEL_ERR_NOT_FOUND,
                      "there is no view called `%.64s`",
                      pel_http_view_name(call));
        snprintf(fault.path, sizeof fault.path, "views.%.64s",
                 pel_http_view_name(call));
        pel_http_refuse(call, 404, &fault);
    }
    return view;
}

void pel_http_get_views(const struct pel_http_call *call)
{
    const Pelagos__State *state = pel_scene_state(call->context->scene);
    Pelagos__State only = PELAGOS__STATE__INIT;
    only.views = state->views;
    only.n_views = state->n_views;
    if (state->n_views > 0) {
        pel_http_copy(call->answer, 200, &only.base);
    } else {
        pel_http_json(call->answer, 200, pel_sure_strdup("{\"views\":[]}"));
    }
}

static void answer_view(const struct pel_http_call *call, int status)
{
    const Pelagos__View *view = pel_http_need_view(call);
    if (view) {
        pel_http_copy(call->answer, status, &view->base);
    }
}

void pel_http_get_view(const struct pel_http_call *call)
{
    answer_view(call, 200);
}

/* PUT replaces: what the body leaves out goes back to its default. The view
 * itself stays, so that those who watch it go on. */
static void reset_absent(Pelagos__Patch *patch, const Pelagos__View *view)
{
    const ProtobufCMessageDescriptor *type = view->base.descriptor;
    for (unsigned i = 0; i < type->n_fields; i++) {
        const ProtobufCFieldDescriptor *field = &type->fields[i];
        const struct pel_field *info = pel_field_info(type, field);
        bool merged = field->type == PROTOBUF_C_TYPE_MESSAGE;
        if (!info->key && (merged || !pel_message_has(&view->base, field))) {
            char path[160];
            snprintf(path, sizeof path, "views.%s.%s", view->name, info->name);
            pel_message_append_string(&patch->remove, &patch->n_remove, path);
        }
    }
}

static enum pel_err put(const struct pel_http_call *call, Pelagos__View *view,
                        bool exists, struct pel_fault *fault)
{
    if (view->name && strcmp(view->name, pel_http_view_name(call)) != 0) {
        return pel_fault_value(fault, PEL_ERR_INVALID, "name", view->name,
                               "must be the name in the URL, or absent");
    }
    if (!view->name) {
        view->name = pel_sure_strdup(pel_http_view_name(call));
    }
    Pelagos__Patch *patch = pel_patch_new();
    if (exists) {
        reset_absent(patch, view);
    }
    Pelagos__State state = PELAGOS__STATE__INIT;
    state.views = &view;
    state.n_views = 1;
    Pelagos__State *own = patch->state;
    patch->state = &state;
    enum pel_err err = pel_scene_patch(call->context->scene, patch, fault);
    patch->state = own;
    pelagos__patch__free_unpacked(patch, NULL);
    return err;
}

void pel_http_put_view(const struct pel_http_call *call)
{
    if (!pel_http_precondition(call)) {
        return;
    }
    struct pel_fault fault;
    ProtobufCMessage *message = NULL;
    bool exists = find_view(call) != NULL;
    enum pel_err err =
        pel_http_body(call, &pelagos__view__descriptor, &message, &fault);
    if (err == PEL_OK) {
        err = put(call, (Pelagos__View *)message, exists, &fault);
        protobuf_c_message_free_unpacked(message, NULL);
    }
    if (err != PEL_OK) {
        pel_http_refuse(call, err == PEL_ERR_NOT_FOUND ? 400 : 0, &fault);
        return;
    }
    answer_view(call, exists ? 200 : 201);
    snprintf(call->answer->location, sizeof call->answer->location,
             "/v1/views/%.64s", pel_http_view_name(call));
}

void pel_http_delete_view(const struct pel_http_call *call)
{
    if (!pel_http_need_view(call) || !pel_http_precondition(call)) {
        return;
    }
    char path[80];
    snprintf(path, sizeof path, "views.%.64s", pel_http_view_name(call));
    char *remove[] = { path };
    Pelagos__Patch patch = PELAGOS__PATCH__INIT;
    patch.n_remove = 1;
    patch.remove = remove;
    struct pel_fault fault;
    if (pel_scene_patch(call->context->scene, &patch, &fault) == PEL_OK) {
        call->answer->status = 204;
    } else {
        pel_http_refuse(call, 0, &fault);
    }
}

/* --- pictures ------------------------------------------------------------- */

static enum pel_err set_layers(Pelagos__FrameRequest *frame, const char *list,
                               struct pel_fault *fault)
{
    char **names = g_strsplit(list, ",", PEL_LAYERS + 1);
    enum pel_err err = PEL_OK;
    for (char **name = names; *name; name++) {
        if (!pel_layer_find(*name)) {
            char words[256];
            snprintf(words, sizeof words,
                     "these are known: %s, separated by commas",
                     pel_layer_names);
            err =
                pel_fault_value(fault, PEL_ERR_INVALID, "layers", *name, words);
            break;
        }
        pel_message_append_string(&frame->layers, &frame->n_layers, *name);
    }
    g_strfreev(names);
    return err;
}

enum pel_err pel_http_frame_parameter(Pelagos__FrameRequest *frame,
                                      const struct pel_http_pair *pair,
                                      struct pel_fault *fault)
{
    const ProtobufCMessageDescriptor *type =
        &pelagos__frame_request__descriptor;
    double value = 0.0;
    enum pel_err err = PEL_OK;
    if (strcmp(pair->name, "layers") == 0) {
        return set_layers(frame, pair->value, fault);
    }
    if (strcmp(pair->name, "float") == 0) {
        bool yes = !strcmp(pair->value, "1") || !strcmp(pair->value, "true");
        bool no = !strcmp(pair->value, "0") || !strcmp(pair->value, "false");
        frame->has_float_samples = true;
        frame->float_samples = yes;
        return yes || no ? PEL_OK
                         : pel_fault_value(fault, PEL_ERR_INVALID, "float",
                                           pair->value, "must be 0 or 1");
    }
    struct {
        const char *name;
        protobuf_c_boolean *has;
        uint32_t *whole;
    } numbers[] = {
        { "width", &frame->has_width, &frame->width },
        { "height", &frame->has_height, &frame->height },
        { "quality", &frame->has_quality, &frame->quality },
        { "time", &frame->has_time, NULL },
    };
    for (size_t i = 0; i < G_N_ELEMENTS(numbers); i++) {
        if (strcmp(pair->name, numbers[i].name) == 0) {
            err = pel_command_number(type, pair->name, pair->value, &value,
                                     fault);
            *numbers[i].has = err == PEL_OK;
            if (err == PEL_OK && numbers[i].whole) {
                *numbers[i].whole = (uint32_t)value;
            } else if (err == PEL_OK) {
                frame->time = value;
            }
            return err;
        }
    }
    return pel_fault_value(fault, PEL_ERR_NOT_FOUND, pair->name, pair->value,
                           "no such parameter: width, height, time, layers, "
                           "float and quality are known");
}

Pelagos__FrameFormat pel_http_frame_format(const char *file)
{
    return pel_format_by_path(file)->format; /* the route has seen to it */
}

void pel_http_get_frame(const struct pel_http_call *call)
{
    if (!pel_http_need_view(call)) {
        return;
    }
    Pelagos__FrameRequest *frame = (Pelagos__FrameRequest *)pel_message_new(
        &pelagos__frame_request__descriptor);
    frame->view = pel_sure_strdup(pel_http_view_name(call));
    frame->has_format = true;
    frame->format = pel_http_frame_format(call->target->segments[FILE_NAME]);
    for (size_t i = 0; i < call->target->query_count; i++) {
        struct pel_fault fault;
        if (pel_http_frame_parameter(frame, &call->target->query[i], &fault) !=
            PEL_OK) {
            pelagos__frame_request__free_unpacked(frame, NULL);
            pel_http_refuse(call, 400, &fault);
            return;
        }
    }
    call->answer->kind = PEL_HTTP_FRAME;
    call->answer->frame = frame;
}

static enum pel_err set_fps(const char *text, double *out,
                            struct pel_fault *fault)
{
    char *end = NULL;
    double fps = g_ascii_strtod(text, &end);
    if (!*text || *end || !(fps >= 0.1 && fps <= 240.0)) {
        pel_fault_value(fault, PEL_ERR_OUT_OF_RANGE, "fps", text,
                        "must be between 0.1 and 240 1/s");
        fault->unit = "1/s";
        fault->minimum = 0.1;
        fault->maximum = 240.0;
        return fault->code;
    }
    *out = fps;
    return PEL_OK;
}

void pel_http_get_mjpeg(const struct pel_http_call *call)
{
    if (!pel_http_need_view(call)) {
        return;
    }
    double fps = 0.0, quality = 80.0;
    enum pel_err err = PEL_OK;
    struct pel_fault fault;
    for (size_t i = 0; i < call->target->query_count && err == PEL_OK; i++) {
        const struct pel_http_pair *pair = &call->target->query[i];
        if (strcmp(pair->name, "fps") == 0) {
            err = set_fps(pair->value, &fps, &fault);
        } else if (strcmp(pair->name, "quality") == 0) {
            err = pel_command_number(&pelagos__frame_request__descriptor,
                                     "quality", pair->value, &quality, &fault);
        } else {
            err = pel_fault_value(&fault, PEL_ERR_NOT_FOUND, pair->name,
                                  pair->value,
                                  "no such parameter: fps and quality are "
                                  "known");
        }
    }
    if (err != PEL_OK) {
        pel_http_refuse(call, 400, &fault);
        return;
    }
    call->answer->kind = PEL_HTTP_MJPEG;
    call->answer->fps = fps;
    call->answer->quality = (int)quality;
    snprintf(call->answer->view, sizeof call->answer->view, "%s",
             pel_http_view_name(call));
}
