/* /v1/presets: changes of the state under a name. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <glib.h>

#include "base/reserve.h"
#include "json.h"
#include "message.h"
#include "net/command.h"
#include "net/http_view.h"
#include "path.h"
#include "scene/presets.h"

enum { NAME = 2 }; /* segment of /v1/presets/NAME */

static const char *name_of(const struct pel_http_call *call)
{
    return call->target->segments[NAME];
}

static const Pelagos__Preset *find(const struct pel_http_call *call)
{
    const Pelagos__State *state = pel_scene_state(call->context->scene);
    for (size_t i = 0; i < state->n_presets; i++) {
        if (strcmp(state->presets[i]->name, name_of(call)) == 0) {
            return state->presets[i];
        }
    }
    return NULL;
}

/* NULL: none, and answered with 404. */
static const Pelagos__Preset *need(const struct pel_http_call *call)
{
    const Pelagos__Preset *preset = find(call);
    if (!preset) {
        struct pel_fault fault;
        pel_fault_set(&fault, PEL_ERR_NOT_FOUND,
                      "there is no preset called `%.64s`", name_of(call));
        snprintf(fault.path, sizeof fault.path, "presets.%.64s", name_of(call));
        pel_http_refuse(call, 404, &fault);
    }
    return preset;
}

void pel_http_get_presets(const struct pel_http_call *call)
{
    const Pelagos__State *state = pel_scene_state(call->context->scene);
    Pelagos__State only = PELAGOS__STATE__INIT;
    only.presets = state->presets;
    only.n_presets = state->n_presets;
    if (state->n_presets > 0) {
        pel_http_copy(call->answer, 200, &only.base);
    } else {
        pel_http_json(call->answer, 200, pel_sure_strdup("{\"presets\":[]}"));
    }
}

static void answer_preset(const struct pel_http_call *call, int status)
{
    const Pelagos__Preset *preset = need(call);
    if (preset) {
        pel_http_copy(call->answer, status, &preset->base);
    }
}

void pel_http_get_preset(const struct pel_http_call *call)
{
    answer_preset(call, 200);
}

static enum pel_err put(const struct pel_http_call *call,
                        Pelagos__Preset *preset, bool exists,
                        struct pel_fault *fault)
{
    if (preset->name && strcmp(preset->name, name_of(call)) != 0) {
        return pel_fault_value(fault, PEL_ERR_INVALID, "name", preset->name,
                               "must be the name in the URL, or absent");
    }
    if (!preset->patch) {
        return pel_fault_value(fault, PEL_ERR_INVALID, "patch", "",
                               "must be a merge patch of the state, as text");
    }
    if (!preset->name) {
        preset->name = pel_sure_strdup(name_of(call));
    }
    Pelagos__Patch *patch = pel_patch_new();
    if (exists && !preset->title) {
        char path[96];
        snprintf(path, sizeof path, "presets.%.64s.title", preset->name);
        pel_message_append_string(&patch->remove, &patch->n_remove, path);
    }
    Pelagos__State state = PELAGOS__STATE__INIT;
    state.presets = &preset;
    state.n_presets = 1;
    Pelagos__State *own = patch->state;
    patch->state = &state;
    enum pel_err err = pel_scene_patch(call->context->scene, patch, fault);
    patch->state = own;
    pelagos__patch__free_unpacked(patch, NULL);
    return err;
}

void pel_http_put_preset(const struct pel_http_call *call)
{
    if (!pel_http_precondition(call)) {
        return;
    }
    struct pel_fault fault;
    ProtobufCMessage *message = NULL;
    bool exists = find(call) != NULL;
    enum pel_err err =
        pel_http_body(call, &pelagos__preset__descriptor, &message, &fault);
    if (err == PEL_OK) {
        err = put(call, (Pelagos__Preset *)message, exists, &fault);
        protobuf_c_message_free_unpacked(message, NULL);
    }
    if (err != PEL_OK) {
        pel_http_refuse(call, err == PEL_ERR_NOT_FOUND ? 400 : 0, &fault);
        return;
    }
    answer_preset(call, exists ? 200 : 201);
    snprintf(call->answer->location, sizeof call->answer->location,
             "/v1/presets/%.64s", name_of(call));
}

void pel_http_post_preset(const struct pel_http_call *call)
{
    const Pelagos__Preset *preset = need(call);
    struct pel_fault fault;
    Pelagos__Patch *patch;
    if (!preset || !pel_http_precondition(call)) {
        return;
    }
    if (call->request->body_size > 0) {
        pel_fault_set(&fault, PEL_ERR_INVALID, "nothing is taken here");
        pel_http_refuse(call, 400, &fault);
    } else if (pel_preset_patch(preset, &patch, &fault) != PEL_OK) {
        pel_http_refuse(call, 400, &fault);
    } else {
        call->answer->kind = PEL_HTTP_PATCH;
        call->answer->patch = patch;
        call->answer->if_unchanged =
            pel_http_find_header(call->request, "If-Match", NULL) != NULL;
    }
}

void pel_http_delete_preset(const struct pel_http_call *call)
{
    if (!need(call) || !pel_http_precondition(call)) {
        return;
    }
    char path[80];
    snprintf(path, sizeof path, "presets.%.64s", name_of(call));
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
