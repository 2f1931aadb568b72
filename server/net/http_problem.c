#include "net/http_route.h"

#include <stdlib.h>
#include <string.h>

#include <glib.h>

#include "json.h"

int pel_http_status(enum pel_err err)
{
    switch (err) {
    case PEL_OK:
        return 200;
    case PEL_ERR_MALFORMED:
    case PEL_ERR_OUT_OF_RANGE:
    case PEL_ERR_INVALID:
        return 400;
    case PEL_ERR_NOT_FOUND:
        return 404;
    case PEL_ERR_CONFLICT:
        return 409;
    case PEL_ERR_BUSY:
        return 503;
    case PEL_ERR_UNAUTHORIZED:
        return 401;
    case PEL_ERR_FORBIDDEN:
        return 403;
    case PEL_ERR_FULL:
        return 507;
    case PEL_ERR_IO:
    case PEL_ERR_GPU:
    case PEL_ERR_NO_MEMORY:
    case PEL_ERR_INTERNAL:
        break;
    }
    return 500;
}

static const char *title_of(int status)
{
    switch (status) {
    case 400:
        return "Bad Request";
    case 401:
        return "Unauthorized";
    case 403:
        return "Forbidden";
    case 404:
        return "Not Found";
    case 405:
        return "Method Not Allowed";
    case 409:
        return "Conflict";
    case 412:
        return "Precondition Failed";
    case 413:
        return "Content Too Large";
    case 414:
        return "URI Too Long";
    case 415:
        return "Unsupported Media Type";
    case 429:
        return "Too Many Requests";
    case 501:
        return "Not Implemented";
    case 503:
        return "Service Unavailable";
    case 507:
        return "Insufficient Storage";
    default:
        return "Internal Server Error";
    }
}

static void append_string(GString *out, const char *name, const char *text)
{
    if (!*text) {
        return;
    }
    char *quoted = pel_json_string(text);
    g_string_append_printf(out, ",\"%s\":%s", name, quoted);
    free(quoted);
}

static void append_number(GString *out, const char *name, double value)
{
    char text[32];
    pel_json_number(value, text);
    g_string_append_printf(out, ",\"%s\":%s", name, text);
}

void pel_http_problem(struct pel_http_answer *answer, int status,
                      const struct pel_fault *fault)
{
    struct pel_fault shown = *fault;
    pel_fault_clean(&shown);
    fault = &shown;
    pel_http_answer_finish(answer);
    status = status ? status : pel_http_status(fault->code);
    GString *out = g_string_new(NULL);
    g_string_append_printf(out,
                           "{\"type\":\"about:blank\",\"title\":\"%s\","
                           "\"status\":%d,\"code\":\"%s\"",
                           title_of(status), status, pel_err_name(fault->code));
    append_string(out, "detail", fault->message);
    append_string(out, "path", fault->path);
    append_string(out, "value", fault->value);
    append_string(out, "unit", fault->unit ? fault->unit : "");
    if (fault->minimum <= fault->maximum) {
        append_number(out, "minimum", fault->minimum);
        append_number(out, "maximum", fault->maximum);
    }
    g_string_append(out, "}\n");
    *answer = (struct pel_http_answer){
        .status = status,
        .type = "application/problem+json",
        .size = out->len,
        .allow = answer->allow,
        .close = answer->close,
        .retry_after_s = status == 503 || status == 429 ? 1 : 0,
    };
    answer->owned = g_string_free(out, FALSE);
    answer->body = answer->owned;
}

void pel_http_answer_finish(struct pel_http_answer *answer)
{
    free(answer->owned);
    answer->owned = NULL;
    answer->body = NULL;
    free(answer->packed);
    answer->packed = NULL;
    if (answer->message) {
        protobuf_c_message_free_unpacked(answer->message, NULL);
        answer->message = NULL;
    }
    if (answer->frame) {
        pelagos__frame_request__free_unpacked(answer->frame, NULL);
        answer->frame = NULL;
    }
    if (answer->frames) {
        pelagos__frames_request__free_unpacked(answer->frames, NULL);
        answer->frames = NULL;
    }
    if (answer->patch) {
        pelagos__patch__free_unpacked(answer->patch, NULL);
        answer->patch = NULL;
    }
    if (answer->exercise) {
        pelagos__exercise_command__free_unpacked(answer->exercise, NULL);
        answer->exercise = NULL;
    }
    if (answer->place) {
        pelagos__cluster_place_command__free_unpacked(answer->place, NULL);
        answer->place = NULL;
    }
    if (answer->spectrum) {
        pelagos__spectrum_query__free_unpacked(answer->spectrum, NULL);
        answer->spectrum = NULL;
    }
    if (answer->soundings) {
        pelagos__soundings_query__free_unpacked(answer->soundings, NULL);
        answer->soundings = NULL;
    }
    if (answer->almanac) {
        pelagos__almanac_query__free_unpacked(answer->almanac, NULL);
        answer->almanac = NULL;
    }
    if (answer->optics) {
        pelagos__optics_query__free_unpacked(answer->optics, NULL);
        answer->optics = NULL;
    }
    if (answer->series) {
        pelagos__series_query__free_unpacked(answer->series, NULL);
        answer->series = NULL;
    }
    if (answer->surface) {
        pelagos__surface_query__free_unpacked(answer->surface, NULL);
        answer->surface = NULL;
    }
}
