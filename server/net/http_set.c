/* GET /v1/frames.jpg and its like: pictures of several views of one frame. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <glib.h>

#include "base/reserve.h"
#include "message.h"
#include "net/command.h"
#include "net/http_view.h"

enum { FILE_NAME = 1 }; /* segment of /v1/FILE */

/* A list of views, or all of them where there is none. */
static void name_views(const struct pel_http_call *call, const char *list,
                       GPtrArray *names)
{
    const Pelagos__State *state = pel_scene_state(call->context->scene);
    if (list) {
        char **parts = g_strsplit(list, ",", PEL_MAX_VIEWS + 2);
        for (char **part = parts; *part; part++) {
            g_ptr_array_add(names, g_strdup(*part));
        }
        g_strfreev(parts);
        return;
    }
    for (size_t i = 0; i < state->n_views; i++) {
        g_ptr_array_add(names, g_strdup(state->views[i]->name));
    }
}

/* Everything but the views, which it finds. */
static enum pel_err read_query(const struct pel_http_call *call,
                               Pelagos__FrameRequest *each, const char **views,
                               struct pel_fault *fault)
{
    enum pel_err err = PEL_OK;
    for (size_t i = 0; i < call->target->query_count && err == PEL_OK; i++) {
        const struct pel_http_pair *pair = &call->target->query[i];
        if (strcmp(pair->name, "views") == 0) {
            *views = pair->value;
        } else {
            err = pel_http_frame_parameter(each, pair, fault);
        }
    }
    return err;
}

/* A copy of `each` for a view. */
static Pelagos__FrameRequest *for_view(const Pelagos__FrameRequest *each,
                                       const char *view)
{
    Pelagos__FrameRequest *one = (Pelagos__FrameRequest *)pel_message_new(
        &pelagos__frame_request__descriptor);
    *one = *each;
    one->view = pel_sure_strdup(view);
    one->n_layers = 0;
    one->layers = NULL;
    for (size_t i = 0; i < each->n_layers; i++) {
        pel_message_append_string(&one->layers, &one->n_layers,
                                  each->layers[i]);
    }
    return one;
}

static enum pel_err fill(const struct pel_http_call *call,
                         Pelagos__FrameRequest *each,
                         Pelagos__FramesRequest *set, struct pel_fault *fault)
{
    const char *views = NULL;
    enum pel_err err = read_query(call, each, &views, fault);
    if (err != PEL_OK) {
        return err;
    }
    GPtrArray *names = g_ptr_array_new_with_free_func(g_free);
    name_views(call, views, names);
    set->has_time = each->has_time;
    set->time = each->time;
    each->has_time = false;
    if (names->len < 1 || names->len > PEL_MAX_VIEWS) {
        err = pel_fault_value(fault, PEL_ERR_INVALID, "views", views,
                              "must be names of 1 to 64 views, separated by "
                              "commas");
    } else {
        set->frames = malloc(names->len * sizeof(Pelagos__FrameRequest *));
        for (guint i = 0; set->frames && i < names->len; i++) {
            set->frames[set->n_frames++] =
                for_view(each, g_ptr_array_index(names, i));
        }
    }
    g_ptr_array_free(names, TRUE);
    return err;
}

void pel_http_get_frames(const struct pel_http_call *call)
{
    struct pel_fault fault;
    Pelagos__FramesRequest *set = (Pelagos__FramesRequest *)pel_message_new(
        &pelagos__frames_request__descriptor);
    Pelagos__FrameRequest *each = (Pelagos__FrameRequest *)pel_message_new(
        &pelagos__frame_request__descriptor);
    each->has_format = true;
    each->format = pel_http_frame_format(call->target->segments[FILE_NAME]);
    enum pel_err err = fill(call, each, set, &fault);
    pelagos__frame_request__free_unpacked(each, NULL);
    if (err != PEL_OK) {
        pelagos__frames_request__free_unpacked(set, NULL);
        pel_http_refuse(call, 400, &fault);
        return;
    }
    call->answer->kind = PEL_HTTP_FRAMES;
    call->answer->frames = set;
}
