#include "net/http_route.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include <glib.h>

#include "cluster/cluster.h"
#include "fields.h"
#include "formats.h"
#include "json.h"
#include "message.h"
#include "net/command.h"
#include "net/http_auth.h"
#include "net/http_check.h"
#include "net/http_view.h"
#include "net/pages.h"
#include "net/whep.h"
#include "path.h"
#include "scene/missing.h"
#include "scene/spectra.h"

#define JSON_TYPE "application/json"
/* --- answers -------------------------------------------------------------- */

void pel_http_json(struct pel_http_answer *answer, int status, char *owned)
{
    answer->status = status;
    answer->type = JSON_TYPE;
    answer->size = strlen(owned);
    if (answer->size > 0 && owned[answer->size - 1] != '\n') {
        owned = g_realloc(owned, answer->size + 2);
        owned[answer->size++] = '\n';
        owned[answer->size] = '\0';
    }
    answer->owned = owned;
    answer->body = owned;
}

void pel_http_refuse(const struct pel_http_call *call, int status,
                     const struct pel_fault *fault)
{
    pel_http_problem(call->answer, status, fault);
}

#define WEAK "W/"

static void set_revision(const struct pel_http_context *context,
                         struct pel_http_answer *answer)
{
    const Pelagos__State *state = pel_scene_state(context->scene);
    /* Weak: of one revision, the clock's time goes on. */
    snprintf(answer->tag, sizeof answer->tag, WEAK "\"%llu\"",
             (unsigned long long)state->revision);
}

static void set_tag(const struct pel_http_call *call)
{
    set_revision(call->context, call->answer);
}

bool pel_http_precondition(const struct pel_http_call *call)
{
    const char *wanted = pel_http_find_header(call->request, "If-Match", NULL);
    if (!wanted) {
        return true;
    }
    set_tag(call);
    /* Weak or not: what is compared is the revision. */
    const char *tag = call->answer->tag + strlen(WEAK);
    if (pel_http_tag_matches(wanted, tag, true)) {
        return true;
    }
    struct pel_fault fault;
    pel_fault_set(&fault, PEL_ERR_CONFLICT,
                  "the state is at revision %s, not %s", tag, wanted);
    pel_http_refuse(call, 412, &fault);
    set_tag(call);
    return false;
}

void pel_http_answer_state(const struct pel_http_context *context,
                           enum pel_role role, struct pel_http_answer *answer)
{
    Pelagos__State state;
    pel_role_seen(role, pel_scene_state(context->scene), &state);
    pel_http_copy(answer, 200, &state.base);
    set_revision(context, answer);
}

void pel_http_answer_refused(struct pel_http_answer *answer,
                             const struct pel_fault *fault)
{
    /* A field that does not exist is the body's fault, not the URL's. */
    pel_http_problem(answer, fault->code == PEL_ERR_NOT_FOUND ? 400 : 0, fault);
}

/* Whether the client has it already; then it is answered with 304. */
static bool is_known(const struct pel_http_call *call)
{
    const char *known =
        pel_http_find_header(call->request, "If-None-Match", NULL);
    set_tag(call);
    if (!known ||
        !pel_http_tag_matches(known, call->answer->tag + strlen(WEAK), true)) {
        return false;
    }
    call->answer->status = 304;
    return true;
}

void pel_http_state(const struct pel_http_call *call)
{
    if (is_known(call)) {
        return;
    }
    pel_http_answer_state(call->context,
                          pel_http_role(call->context, call->request),
                          call->answer);
}

/* --- handlers ------------------------------------------------------------- */

static void append_quoted(GString *out, const char *text)
{
    char *quoted = pel_json_string(text);
    g_string_append(out, quoted);
    free(quoted);
}

/* What the state file names and is not there. */
static void append_missing(GString *out, const struct pel_missing *missing)
{
    const char *before = ",\"missing\":[";
    for (int i = 0; i < PEL_MISSING_COUNT; i++) {
        if (missing->fields[i].name) {
            g_string_append_printf(out, "%s{\"path\":\"%s\",\"value\":", before,
                                   pel_missing_path(i));
            append_quoted(out, missing->fields[i].name);
            g_string_append(out, ",\"reason\":");
            append_quoted(out, missing->fields[i].reason);
            g_string_append_c(out, '}');
            before = ",";
        }
    }
    if (*before == ',' && !before[1]) {
        g_string_append_c(out, ']');
    }
}

/* Why it is degraded. */
static void append_troubles(GString *out, const struct pel_troubles *troubles)
{
    for (size_t i = 0; i < troubles->count; i++) {
        g_string_append_printf(
            out, "%s{\"what\":\"%s\",\"reason\":", i ? "," : ",\"degraded\":[",
            troubles->items[i].what);
        append_quoted(out, troubles->items[i].words);
        g_string_append_c(out, '}');
    }
    if (troubles->count > 0) {
        g_string_append_c(out, ']');
    }
}

static void get_health(const struct pel_http_call *call)
{
    const struct pel_http_context *context = call->context;
    bool stuck = context->frames && pel_frames_stuck(context->frames);
    struct pel_troubles troubles;
    pel_scene_troubles(context->scene, &troubles);
    const char *status = context->stopping    ? "stopping"
                         : stuck              ? "stuck"
                         : troubles.count > 0 ? "degraded"
                                              : "ok";
    const Pelagos__State *state = pel_scene_state(context->scene);
    GString *out = g_string_new(NULL);
    enum pel_role role = pel_http_role(context, call->request);
    bool known = role != PEL_ROLE_NONE;
    g_string_append_printf(out, "{\"status\":\"%s\"", status);
    if (known) {
        g_string_append_printf(out, ",\"version\":\"%s\",\"revision\":\"%llu\"",
                               PEL_VERSION,
                               (unsigned long long)state->revision);
        g_string_append_printf(out, ",\"role\":\"%s\"", pel_role_name(role));
        append_missing(out, pel_scene_missing(context->scene));
        append_troubles(out, &troubles);
    }
    if (context->frames && known) {
        struct pel_frames_stats stats;
        pel_frames_get_stats(context->frames, &stats);
        g_string_append(out, ",\"device\":");
        append_quoted(out, pel_frames_device(context->frames));
        g_string_append_printf(out, ",\"quality\":%.3f", stats.quality);
    }
    g_string_append(out, "}\n");
    bool well = !context->stopping && !stuck;
    pel_http_json(call->answer, well ? 200 : 503, g_string_free(out, FALSE));
    call->answer->retry_after_s = well ? 0 : 1;
}

static bool takes_part(const struct pel_http_context *context)
{
    if (!context->cluster) {
        return true;
    }
    Pelagos__Cluster *cluster = pel_cluster_status(context->cluster);
    bool joined = cluster->role != PELAGOS__CLUSTER_ROLE__JOINING;
    pelagos__cluster__free_unpacked(cluster, NULL);
    return joined;
}

/* Whether clients may be sent here, which is more than to be well. */
static void get_ready(const struct pel_http_call *call)
{
    const struct pel_http_context *context = call->context;
    const char *status = context->stopping ? "stopping"
                         : !context->ready ? "starting"
                         : context->frames && pel_frames_stuck(context->frames)
                             ? "stuck"
                         : !takes_part(context) ? "joining"
                                                : "ready";
    bool ready = strcmp(status, "ready") == 0;
    pel_http_json(call->answer, ready ? 200 : 503,
                  g_strdup_printf("{\"status\":\"%s\"}\n", status));
    call->answer->retry_after_s = ready ? 0 : 1;
}

static void get_metrics(const struct pel_http_call *call)
{
    struct pel_http_answer *answer = call->answer;
    answer->status = 200;
    answer->type = "text/plain; version=0.0.4; charset=utf-8";
    answer->owned = pel_metrics_text(call->context->metrics, &answer->size);
    answer->body = answer->owned;
}

static void patch_state(const struct pel_http_call *call)
{
    if (!pel_http_precondition(call)) {
        return;
    }
    struct pel_fault fault;
    Pelagos__Patch *patch = NULL;
    enum pel_err err = pel_http_merge_body(call, &patch, &fault);
    if (err != PEL_OK) {
        pel_http_answer_refused(call->answer, &fault);
        return;
    }
    if (pel_role_patch(pel_http_role(call->context, call->request), patch,
                       pel_scene_state(call->context->scene), &fault)) {
        pel_http_answer_refused(call->answer, &fault);
        pelagos__patch__free_unpacked(patch, NULL);
        return;
    }
    call->answer->kind = PEL_HTTP_PATCH;
    call->answer->patch = patch;
    call->answer->if_unchanged =
        pel_http_find_header(call->request, "If-Match", NULL) != NULL;
}

static char *path_of_segments(const struct pel_http_call *call)
{
    GString *path = g_string_new(NULL);
    for (size_t i = 2; i < call->target->segment_count; i++) {
        g_string_append_printf(path, "%s%s", i > 2 ? "." : "",
                               call->target->segments[i]);
    }
    return g_string_free(path, FALSE);
}

/* What an enum's field may be. */
static void append_names(GString *out, const ProtobufCFieldDescriptor *field)
{
    if (field->type != PROTOBUF_C_TYPE_ENUM) {
        return;
    }
    const ProtobufCEnumDescriptor *names = field->descriptor;
    for (unsigned i = 0; i < names->n_values; i++) {
        g_string_append_printf(out, "%s\"%s\"", i ? "," : ",\"values\":[",
                               names->values[i].name);
    }
    g_string_append_c(out, ']');
}

/* Which spectra depend on the field, where some do. */
static void append_spectra(GString *out, const char *path)
{
    const ProtobufCEnumDescriptor *all = &pelagos__spectrum_kind__descriptor;
    bool any = false;
    for (unsigned i = 0; i < all->n_values; i++) {
        const ProtobufCEnumValue *kind = &all->values[i];
        if (pel_spectrum_reads((Pelagos__SpectrumKind)kind->value, path)) {
            g_string_append_printf(out, "%s\"%s\"",
                                   any ? "," : ",\"spectra\":[", kind->name);
            any = true;
        }
    }
    g_string_append(out, any ? "]" : "");
}

static void append_info(GString *out, const struct pel_field *info)
{
    if (info->unit) {
        g_string_append_printf(out, ",\"unit\":\"%s\"", info->unit);
    }
    if (info->ranged) {
        char low[32], high[32];
        pel_json_number(info->minimum, low);
        pel_json_number(info->maximum, high);
        g_string_append_printf(out, ",\"minimum\":%s,\"maximum\":%s", low,
                               high);
    }
}

static void append_value(GString *out, const struct pel_path_info *info,
                         const char *text)
{
    ProtobufCType type = info->field->type;
    bool bare =
        *text == '{' || *text == '[' ||
        (type != PROTOBUF_C_TYPE_STRING && type != PROTOBUF_C_TYPE_ENUM);
    if (!*text) {
        g_string_append(out, "null");
    } else if (bare) {
        g_string_append(out, text);
    } else {
        append_quoted(out, text);
    }
}

/* Writes the value at answer->path. */
static void write_field(struct pel_http_answer *answer,
                        const ProtobufCMessage *message)
{
    enum { ROOM = 1 << 18 };
    struct pel_fault fault;
    struct pel_path_info info;
    const Pelagos__State *state = (const Pelagos__State *)message;
    char *text = g_malloc(ROOM);
    enum pel_err err = pel_path_find(answer->path, &info, &fault);
    if (err == PEL_OK) {
        err = pel_path_get(state, answer->path, text, ROOM, &fault);
    }
    if (err == PEL_OK) {
        GString *out = g_string_new("{\"path\":");
        append_quoted(out, answer->path);
        g_string_append(out, ",\"value\":");
        append_value(out, &info, text);
        append_info(out, info.info);
        g_string_append(out, "}\n");
        pel_http_json(answer, 200, g_string_free(out, FALSE));
    } else {
        pel_http_problem(answer, 404, &fault);
    }
    g_free(text);
}

static void get_field(const struct pel_http_call *call)
{
    struct pel_path_info info;
    struct pel_http_answer *answer = call->answer;
    const Pelagos__State *state = pel_scene_state(call->context->scene);
    g_autofree char *path = path_of_segments(call);
    struct pel_fault fault;
    if (pel_role_read(pel_http_role(call->context, call->request), path,
                      &fault) != PEL_OK) {
        pel_http_refuse(call, 403, &fault);
        return;
    }
    /* The time goes on without a revision. */
    bool moves = g_str_has_prefix(path, "clock");
    if (!moves && is_known(call)) {
        return;
    }
    g_strlcpy(answer->path, path, sizeof answer->path);
    if (moves) {
        answer->tag[0] = '\0';
    }
    if (pel_path_find(path, &info, NULL) == PEL_OK &&
        info.field->type == PROTOBUF_C_TYPE_MESSAGE) {
        pel_http_copy(answer, 200, &state->base);
        answer->write = write_field;
    } else {
        write_field(answer, &state->base);
    }
}

struct listing {
    GString *text;
    const struct pel_scene *scene;
};

static void append_field(const char *path, const struct pel_path_info *info,
                         void *user)
{
    const struct listing *listing = user;
    GString *out = listing->text;
    g_string_append_printf(out, "%s\n{\"path\":\"%s\"",
                           out->str[out->len - 1] == '[' ? "" : ",", path);
    append_info(out, info->info);
    append_names(out, info->field);
    if (strcmp(path, "sea.spectrum") == 0 &&
        !pel_scene_has_spectra(listing->scene)) {
        g_string_append(out, ",\"unusable\":[\"MEASURED\"]");
    }
    append_spectra(out, path);
    g_string_append(out, ",\"doc\":");
    append_quoted(out, info->info->doc ? info->info->doc : "");
    g_string_append_c(out, '}');
}

static void get_fields(const struct pel_http_call *call)
{
    struct listing listing = { g_string_new("{\"fields\":["),
                               call->context->scene };
    pel_path_each(append_field, &listing);
    g_string_append(listing.text, "]}\n");
    pel_http_json(call->answer, 200, g_string_free(listing.text, FALSE));
}

static void post_step(const struct pel_http_call *call)
{
    struct pel_fault fault;
    ProtobufCMessage *message = NULL;
    enum pel_err err = pel_http_body_if_any(
        call, &pelagos__clock_step__descriptor, &message, &fault);
    if (err == PEL_OK) {
        err = pel_command_check(message, &fault);
    }
    if (err == PEL_OK) {
        call->answer->kind = PEL_HTTP_STEP;
        call->answer->step = *(const Pelagos__ClockStep *)message;
    } else {
        pel_http_refuse(call, err == PEL_ERR_NOT_FOUND ? 400 : 0, &fault);
    }
    if (message) {
        protobuf_c_message_free_unpacked(message, NULL);
    }
}

static void post_surface(const struct pel_http_call *call)
{
    struct pel_fault fault;
    ProtobufCMessage *message = NULL;
    enum pel_err err = pel_http_body(call, &pelagos__surface_query__descriptor,
                                     &message, &fault);
    if (err != PEL_OK) {
        pel_http_refuse(call, err == PEL_ERR_NOT_FOUND ? 400 : 0, &fault);
        return;
    }
    call->answer->kind = PEL_HTTP_SURFACE;
    call->answer->surface = (Pelagos__SurfaceQuery *)message;
}

static void post_spectrum(const struct pel_http_call *call)
{
    struct pel_fault fault;
    ProtobufCMessage *message = NULL;
    enum pel_err err = pel_http_body_if_any(
        call, &pelagos__spectrum_query__descriptor, &message, &fault);
    if (err != PEL_OK) {
        pel_http_refuse(call, err == PEL_ERR_NOT_FOUND ? 400 : 0, &fault);
        return;
    }
    call->answer->kind = PEL_HTTP_SPECTRUM;
    call->answer->spectrum = (Pelagos__SpectrumQuery *)message;
}

static void get_models(const struct pel_http_call *call)
{
    call->answer->kind = PEL_HTTP_MODELS;
}

static void get_page(const struct pel_http_call *call, const char *path)
{
    struct pel_http_answer *answer = call->answer;
    const struct pel_page *page = NULL;
    for (size_t i = 0; i < pel_page_count && !page; i++) {
        page = strcmp(pel_pages[i].path, path) == 0 ? &pel_pages[i] : NULL;
    }
    for (size_t i = 0; i < pel_document_count && !page; i++) {
        page =
            strcmp(pel_documents[i].path, path) == 0 ? &pel_documents[i] : NULL;
    }
    if (!page) {
        struct pel_fault fault;
        pel_fault_set(&fault, PEL_ERR_NOT_FOUND, "there is no %s here", path);
        pel_http_refuse(call, 404, &fault);
        return;
    }
    snprintf(answer->tag, sizeof answer->tag, "%s", page->tag);
    answer->page = true;
    const char *known =
        pel_http_find_header(call->request, "If-None-Match", NULL);
    if (known && pel_http_tag_matches(known, page->tag, true)) {
        answer->status = 304;
        return;
    }
    answer->status = 200;
    answer->type = page->type;
    answer->body = page->data;
    answer->size = page->size;
}

static void get_schema(const struct pel_http_call *call)
{
    get_page(call, "/v1/schema");
}

static void get_openapi(const struct pel_http_call *call)
{
    get_page(call, "/v1/openapi.json");
}

static void get_file(const struct pel_http_call *call)
{
    char path[80] = "/";
    if (call->target->segment_count > 0) {
        snprintf(path + 1, sizeof path - 1, "%s", call->target->segments[0]);
    }
    get_page(call, path);
}

/* --- routes --------------------------------------------------------------- */

static const struct pel_route routes[] = {
#define PEL_ROUTE(method, path, flags, handler, query, body, answer, text)     \
    { method, path, flags, handler, query, body },
#include "proto/routes.def"
};

static bool is_ending(const char *text)
{
    return pel_format_by_ending(text) &&
           !strpbrk(text, "ABCDEFGHIJKLMNOPQRSTUVWXYZ");
}

/* `{name}`: any; `frame.{ending}`: of a format; else the very segment. */
static bool segment_matches(const char *pattern, size_t length,
                            const char *segment)
{
    const char *brace = memchr(pattern, '{', length);
    size_t plain = brace ? (size_t)(brace - pattern) : length;
    if (strncmp(segment, pattern, plain) != 0) {
        return false;
    }
    return !brace            ? segment[plain] == '\0'
           : brace > pattern ? is_ending(segment + plain)
                             : true;
}

static bool pattern_matches(const struct pel_route *route,
                            const struct pel_http_target *target)
{
    const char *at = route->pattern;
    for (size_t i = 0; i < target->segment_count; i++) {
        if (*at == '\0') {
            return (route->flags & ROUTE_REST) != 0;
        }
        size_t length = strcspn(at, "/");
        if (!segment_matches(at, length, target->segments[i])) {
            return false;
        }
        at += length;
        at += *at == '/';
    }
    return *at == '\0';
}

/* The Allow header of a place, from a few static strings. */
static const char *allow_of(const struct pel_http_target *target)
{
    bool get = false, head = false, put = false, patch = false, post = false,
         del = false;
    for (size_t i = 0; i < G_N_ELEMENTS(routes); i++) {
        const struct pel_route *route = &routes[i];
        if (pattern_matches(route, target)) {
            bool is_get = strcmp(route->method, "GET") == 0;
            get = get || is_get;
            head = head || (is_get && !(route->flags & ROUTE_NO_HEAD));
            put = put || strcmp(route->method, "PUT") == 0;
            patch = patch || strcmp(route->method, "PATCH") == 0;
            post = post || strcmp(route->method, "POST") == 0;
            del = del || strcmp(route->method, "DELETE") == 0;
        }
    }
    return put && post ? "GET, HEAD, PUT, POST, DELETE"
           : put       ? "GET, HEAD, PUT, DELETE"
           : patch     ? "GET, HEAD, PATCH"
           : post      ? head ? "GET, HEAD, POST" : "POST"
           : head      ? "GET, HEAD"
           : get       ? "GET"
           : del       ? "DELETE"
                       : NULL;
}

/* NULL: none. */
static const struct pel_route *route_of(const char *asked,
                                        const struct pel_http_target *target)
{
    bool head = strcmp(asked, "HEAD") == 0;
    const char *method = head ? "GET" : asked;
    for (size_t i = 0; i < G_N_ELEMENTS(routes); i++) {
        if (pattern_matches(&routes[i], target) &&
            strcmp(routes[i].method, method) == 0 &&
            !(head && routes[i].flags & ROUTE_NO_HEAD)) {
            return &routes[i];
        }
    }
    return NULL;
}

/* 404 or 405. */
static void refuse_place(const struct pel_http_request *request,
                         const char *method,
                         const struct pel_http_target *target,
                         struct pel_http_answer *answer)
{
    struct pel_fault fault;
    answer->allow = allow_of(target);
    if (answer->allow) {
        pel_fault_set(&fault, PEL_ERR_INVALID,
                      "%.16s is not possible here, "
                      "only %s",
                      method, answer->allow);
        pel_http_problem(answer, 405, &fault);
    } else {
        pel_fault_set(&fault, PEL_ERR_NOT_FOUND, "there is nothing at %.120s",
                      request->target);
        pel_http_problem(answer, 404, &fault);
    }
}

/* NULL: none; *answer says 404 or 405. */
static const struct pel_route *
find_route(const struct pel_http_request *request,
           const struct pel_http_target *target, struct pel_http_answer *answer)
{
    const struct pel_route *route = route_of(request->method, target);
    if (!route) {
        refuse_place(request, request->method, target, answer);
    }
    return route;
}

/* Lists the methods of this place; to a page of another origin it says whether
 * the request that the browser is about to send is allowed (a preflight of the
 * Fetch standard, which has no token). */
static void answer_options(const struct pel_http_context *context,
                           const struct pel_http_request *request,
                           const struct pel_http_target *target,
                           struct pel_http_answer *answer)
{
    struct pel_fault fault;
    const char *method =
        pel_http_find_header(request, "Access-Control-Request-Method", NULL);
    bool preflight = method && pel_http_find_header(request, "Origin", NULL);
    const struct pel_route *route = preflight ? route_of(method, target) : NULL;
    if (!allow_of(target) || (preflight && !route)) {
        refuse_place(request, preflight ? method : "OPTIONS", target, answer);
    } else if (preflight &&
               pel_http_check_site(context, request, route, &fault) != PEL_OK) {
        pel_http_problem(answer, 403, &fault);
    } else {
        answer->status = 204;
        answer->allow = allow_of(target);
        answer->preflight = !preflight                        ? NULL
                            : pel_http_is_safe(route->method) ? "GET, HEAD"
                                                              : route->method;
    }
}

bool pel_http_admit(const struct pel_http_context *context,
                    const struct pel_http_request *request, size_t *body_limit,
                    struct pel_http_answer *answer)
{
    struct pel_http_target target;
    struct pel_fault fault;
    int status = 0;
    size_t limit = 0;
    *answer = (struct pel_http_answer){ .kind = PEL_HTTP_WHOLE };
    enum pel_err err = pel_http_check_head(context, request, &status, &fault);
    if (err != PEL_OK) {
        answer->close = true;
        pel_http_problem(answer, status, &fault);
        return false;
    }
    if (strlen(request->target) >= PEL_HTTP_MAX_TARGET) {
        status = 414;
    }
    err = pel_http_parse_target(request->target, &target, &fault);
    if (err != PEL_OK) {
        pel_http_problem(answer, status == 414 ? 414 : 400, &fault);
        return false;
    }
    if (body_limit) {
        *body_limit = 0;
    }
    if (strcmp(request->method, "OPTIONS") == 0) {
        return true; /* it asks what may be asked */
    }
    const struct pel_route *route = find_route(request, &target, answer);
    if (!route) {
        return false;
    }
    if (!(route->flags & ROUTE_OPEN) &&
        !pel_http_is_authorized(context, request)) {
        pel_http_refuse_stranger(request, answer);
        return false;
    }
    char what[80];
    snprintf(what, sizeof what, "%s /%.60s", route->method, route->pattern);
    err = route->flags & ROUTE_OPEN
              ? PEL_OK
              : pel_role_need(pel_http_role(context, request),
                              pel_role_of_route(route->method, route->pattern),
                              what, &fault);
    if (err != PEL_OK) {
        pel_http_problem(answer, 403, &fault);
        return false;
    }
    err = pel_http_check_body(context, request, route, &limit, &status, &fault);
    if (err == PEL_OK) {
        status = 403;
        err = pel_http_check_site(context, request, route, &fault);
    }
    if (err != PEL_OK) {
        pel_http_problem(answer, status, &fault);
        return false;
    }
    if (body_limit) {
        *body_limit = limit;
    }
    return true;
}

const char *pel_http_about(const struct pel_http_request *request, bool *edits)
{
    struct pel_http_target target;
    struct pel_fault fault;
    *edits = false;
    if (pel_http_parse_target(request->target, &target, &fault)) {
        return NULL;
    }
    const struct pel_route *route = route_of(request->method, &target);
    if (!route) {
        return NULL;
    }
    *edits = !(route->flags & ROUTE_OPEN) &&
             pel_role_of_route(route->method, route->pattern) > PEL_ROLE_WATCH;
    bool message = route->body[0] && !(route->flags & ROUTE_SDP);
    return message ? route->body : NULL;
}

void pel_http_route(const struct pel_http_context *context,
                    const struct pel_http_request *request,
                    struct pel_http_answer *answer)
{
    struct pel_http_target target;
    struct pel_fault fault;
    *answer = (struct pel_http_answer){ .kind = PEL_HTTP_WHOLE };
    if (pel_http_parse_target(request->target, &target, &fault) != PEL_OK) {
        pel_http_problem(answer, 400, &fault);
        return;
    }
    if (strcmp(request->method, "OPTIONS") == 0) {
        answer_options(context, request, &target, answer);
        return;
    }
    const struct pel_route *route = find_route(request, &target, answer);
    if (!route) {
        return;
    }
    struct pel_http_context own = *context;
    struct pel_http_call call = { context, request, &target, answer };
    char ignored[sizeof answer->ignored] = "";
    if (pel_http_check_query(route, &target, ignored, sizeof ignored, &fault) !=
        PEL_OK) {
        pel_http_problem(answer, 400, &fault);
        return;
    }
    if (pel_http_of_debrief(&own, &call)) {
        route->handle(&call);
    }
    g_strlcpy(answer->ignored, ignored, sizeof answer->ignored);
}
