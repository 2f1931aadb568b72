/* /v1/series and GET /v1/spectrum: from a request to a query. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <glib.h>

#include "fields.h"
#include "json.h"
#include "message.h"
#include "net/command.h"
#include "net/http_view.h"
#include "path.h"
#include "sweep.h"

/* What the URL names: `brdf`, `spectrum`…; the message that its parameters are
 * of. NULL: there is no such question. */
static ProtobufCMessage *question_named(Pelagos__SeriesQuery *query,
                                        const char *name)
{
    static const char *const own[] = { "spectrum", "surface" };
    for (size_t i = 0; i < G_N_ELEMENTS(own); i++) {
        if (strcmp(name, own[i]) == 0) {
            return pel_message_child(
                &query->base,
                pel_field_by_name(query->base.descriptor, name, strlen(name)));
        }
    }
    const ProtobufCFieldDescriptor *field = pel_field_by_name(
        &pelagos__optics_query__descriptor, name, strlen(name));
    if (!field || !(field->flags & PROTOBUF_C_FIELD_FLAG_ONEOF)) {
        return NULL;
    }
    ProtobufCMessage *optics = pel_message_child(
        &query->base, pel_field_by_name(query->base.descriptor, "optics", 6));
    return pel_message_child(optics, field);
}

/* `EAST,NORTH;EAST,NORTH…` */
static enum pel_err read_points(const char *text, Pelagos__SurfaceQuery *query,
                                struct pel_fault *fault)
{
    g_auto(GStrv) parts = g_strsplit(text, ";", -1);
    for (char **part = parts; *part; part++) {
        char *end = NULL, *north;
        double east = g_ascii_strtod(*part, &north);
        double up = *north == ',' ? g_ascii_strtod(north + 1, &end) : 0;
        if (!end || *end || end == north + 1 || north == *part) {
            return pel_fault_value(fault, PEL_ERR_INVALID, "points", *part,
                                   "must be EAST,NORTH in metres, with ; "
                                   "between several");
        }
        Pelagos__Point *point = (Pelagos__Point *)pel_message_append(
            &query->base,
            pel_field_by_name(query->base.descriptor, "points", 6));
        point->has_east = point->has_north = true;
        point->east = east;
        point->north = up;
    }
    return PEL_OK;
}

/* Where a path's change goes; NULL: the question has no patch. */
static Pelagos__Patch **patch_of(Pelagos__SeriesQuery *query)
{
    switch (query->question_case) {
    case PELAGOS__SERIES_QUERY__QUESTION_OPTICS:
        return &query->optics->patch;
    case PELAGOS__SERIES_QUERY__QUESTION_SPECTRUM:
        return &query->spectrum->patch;
    default:
        return NULL;
    }
}

static enum pel_err read_parameter(const struct pel_http_call *call,
                                   const struct pel_http_pair *pair,
                                   Pelagos__SeriesQuery *query,
                                   ProtobufCMessage *question,
                                   struct pel_fault *fault)
{
    Pelagos__Patch **patch = patch_of(query);
    bool optics =
        query->question_case == PELAGOS__SERIES_QUERY__QUESTION_OPTICS;
    if (strcmp(pair->name, "sweep") == 0) {
        return pel_sweep_parse(pair->value, query, fault);
    }
    if (strcmp(pair->name, "points") == 0 && !patch) {
        return read_points(pair->value, query->surface, fault);
    }
    if (strchr(pair->name, '.') && patch) {
        *patch = *patch ? *patch : pel_patch_new();
        return pel_path_set(*patch, pel_scene_state(call->context->scene),
                            pair->name, pair->value, fault);
    }
    bool above = optics && (strcmp(pair->name, "from") == 0 ||
                            strcmp(pair->name, "time") == 0);
    return pel_http_number(above ? &query->optics->base : question, pair->name,
                           pair->value, fault);
}

/* GET /v1/spectrum: fields of SpectrumQuery, paths of the state, `format`. */
static enum pel_err spectrum_parameter(const struct pel_http_call *call,
                                       const struct pel_http_pair *pair,
                                       Pelagos__SpectrumQuery *query,
                                       struct pel_fault *fault)
{
    static const char *const forms[] = { "json", "ww3", "swan", "ndbc",
                                         "netcdf" };
    if (strchr(pair->name, '.')) {
        query->patch = query->patch ? query->patch : pel_patch_new();
        return pel_path_set(query->patch, pel_scene_state(call->context->scene),
                            pair->name, pair->value, fault);
    }
    if (strcmp(pair->name, "format") != 0) {
        return pel_http_number(&query->base, pair->name, pair->value, fault);
    }
    for (size_t i = 0; i < G_N_ELEMENTS(forms); i++) {
        if (g_ascii_strcasecmp(pair->value, forms[i]) == 0) {
            query->has_format = true;
            query->format = (Pelagos__SpectrumForm)i;
            return PEL_OK;
        }
    }
    return pel_fault_value(fault, PEL_ERR_INVALID, "format", pair->value,
                           "must be json, ww3, swan, ndbc or netcdf");
}

void pel_http_get_spectrum(const struct pel_http_call *call)
{
    struct pel_fault fault;
    enum pel_err err = PEL_OK;
    Pelagos__SpectrumQuery *query = (Pelagos__SpectrumQuery *)pel_message_new(
        &pelagos__spectrum_query__descriptor);
    for (size_t i = 0; i < call->target->query_count && err == PEL_OK; i++) {
        err = spectrum_parameter(call, &call->target->query[i], query, &fault);
    }
    if (err != PEL_OK) {
        pelagos__spectrum_query__free_unpacked(query, NULL);
        pel_http_refuse(call, err == PEL_ERR_NOT_FOUND ? 400 : 0, &fault);
        return;
    }
    call->answer->kind = PEL_HTTP_SPECTRUM;
    call->answer->spectrum = query;
}

/* By the parameter `format`, or by Accept. */
static enum pel_err read_format(const struct pel_http_call *call,
                                Pelagos__SeriesQuery *query,
                                struct pel_fault *fault)
{
    const char *word = NULL;
    Pelagos__SeriesFormat format;
    for (size_t i = 0; i < call->target->query_count; i++) {
        const struct pel_http_pair *pair = &call->target->query[i];
        word = strcmp(pair->name, "format") == 0 ? pair->value : word;
    }
    const char *accept = pel_http_find_header(call->request, "Accept", NULL);
    if (!pel_series_format(word, accept, &format)) {
        return pel_fault_value(fault, PEL_ERR_INVALID, "format", word,
                               "must be json, csv or netcdf");
    }
    if (word || !query->has_format) {
        query->has_format = true;
        query->format = format;
    }
    return PEL_OK;
}

static void carry_out(const struct pel_http_call *call,
                      Pelagos__SeriesQuery *query, enum pel_err err,
                      struct pel_fault *fault)
{
    if (!err) {
        err = read_format(call, query, fault);
    }
    if (err) {
        pelagos__series_query__free_unpacked(query, NULL);
        pel_http_refuse(call, err == PEL_ERR_NOT_FOUND ? 400 : 0, fault);
        return;
    }
    call->answer->kind = PEL_HTTP_SERIES;
    call->answer->series = query;
}

void pel_http_get_series(const struct pel_http_call *call)
{
    enum { QUESTION = 2 };
    const char *name = call->target->segments[QUESTION];
    struct pel_fault fault;
    Pelagos__SeriesQuery *query = (Pelagos__SeriesQuery *)pel_message_new(
        &pelagos__series_query__descriptor);
    ProtobufCMessage *question = question_named(query, name);
    if (!question) {
        pelagos__series_query__free_unpacked(query, NULL);
        pel_fault_set(&fault, PEL_ERR_NOT_FOUND,
                      "there is no series of %.60s, but of brdf, sky, water, "
                      "spectrum, surface",
                      name);
        pel_http_refuse(call, 404, &fault);
        return;
    }
    enum pel_err err = PEL_OK;
    for (size_t i = 0; i < call->target->query_count && err == PEL_OK; i++) {
        const struct pel_http_pair *pair = &call->target->query[i];
        if (strcmp(pair->name, "format") != 0) {
            err = read_parameter(call, pair, query, question, &fault);
        }
    }
    carry_out(call, query, err, &fault);
}

void pel_http_post_series(const struct pel_http_call *call)
{
    struct pel_fault fault;
    ProtobufCMessage *message = NULL;
    enum pel_err err = PEL_OK;
    for (size_t i = 0; i < call->target->query_count && err == PEL_OK; i++) {
        const struct pel_http_pair *pair = &call->target->query[i];
        if (strcmp(pair->name, "format") != 0) {
            err =
                pel_fault_value(&fault, PEL_ERR_NOT_FOUND, pair->name,
                                pair->value, "only format is a parameter here");
        }
    }
    if (err == PEL_OK) {
        err = pel_http_body(call, &pelagos__series_query__descriptor, &message,
                            &fault);
    }
    if (err != PEL_OK) {
        pel_http_refuse(call, err == PEL_ERR_NOT_FOUND ? 400 : 0, &fault);
        return;
    }
    carry_out(call, (Pelagos__SeriesQuery *)message, err, &fault);
}
