#include "net/http_check.h"

#include <stdio.h>
#include <string.h>
#include <strings.h>

#include <glib.h>

#include "net/command.h"
#include "net/roles.h"
#include "net/whep.h"

#define SURFACE_BODY 8 /* times the limit of other bodies */

bool pel_http_is_safe(const char *method)
{
    return strcmp(method, "GET") == 0 || strcmp(method, "HEAD") == 0;
}

/* Folded or damaged header lines: another reader may see other headers. */
static bool headers_are_plain(const struct pel_http_request *request)
{
    for (size_t i = 0; i < request->header_count; i++) {
        const char *name = request->headers[i].name;
        const char *value = request->headers[i].value;
        if (!*name || name[strcspn(name, " \t\r\n:\"(),/;<=>?@[\\]{}")]) {
            return false;
        }
        for (; *value; value++) {
            unsigned char c = (unsigned char)*value;
            if ((c < 0x20 && c != '\t') || c == 0x7f) {
                return false;
            }
        }
    }
    return true;
}

static bool all_digits(const char *text)
{
    size_t digits = strspn(text, "0123456789");
    return digits > 0 && digits <= 15 && text[digits] == '\0';
}

enum pel_err pel_http_check_head(const struct pel_http_context *context,
                                 const struct pel_http_request *request,
                                 int *status, struct pel_fault *fault)
{
    size_t hosts = 0, lengths = 0, encodings = 0, origins = 0;
    const char *host = pel_http_find_header(request, "Host", &hosts);
    const char *encoding =
        pel_http_find_header(request, "Transfer-Encoding", &encodings);
    const char *origin = pel_http_find_header(request, "Origin", &origins);
    const char *length =
        pel_http_find_header(request, "Content-Length", &lengths);
    *status = 400;
    if (!headers_are_plain(request) || (length && !all_digits(length))) {
        return pel_fault_set(fault, PEL_ERR_MALFORMED,
                             "a header line is folded or damaged");
    }
    if (hosts != 1) {
        return pel_fault_set(fault, PEL_ERR_MALFORMED,
                             "there must be exactly one Host header");
    }
    if (encodings + lengths > 1) {
        return pel_fault_set(fault, PEL_ERR_MALFORMED,
                             "Content-Length and Transfer-Encoding are one "
                             "too many");
    }
    if (encoding && strcasecmp(encoding, "chunked") != 0) {
        *status = 501;
        return pel_fault_set(fault, PEL_ERR_INVALID,
                             "only the transfer encoding `chunked` is known");
    }
    *status = 403;
    const char *strange =
        !pel_http_host_is_ours(host, context->hosts) ? host
        : request->authority &&
                !pel_http_host_is_ours(request->authority, context->hosts)
            ? request->authority
            : NULL;
    if (strange) {
        return pel_fault_set(fault, PEL_ERR_INVALID,
                             "Host `%.80s` is no name of this server: use its "
                             "address or localhost",
                             strange);
    }
    if (origins > 0 && !pel_http_is_safe(request->method) &&
        strcmp(request->method, "OPTIONS") != 0 &&
        !pel_http_origin_is_ours(origin, pel_http_host(request)) &&
        !pel_http_allowed_origin(request, context->origins)) {
        return pel_fault_set(fault, PEL_ERR_INVALID,
                             "pages of %.80s may not change this server",
                             origin);
    }
    return PEL_OK;
}

/* A page of another origin that asks for pictures: it could not see them, but
 * have them drawn. Its browser says so, and where from, if not by Origin then,
 * as a rule, by Referer. */
static bool is_foreign(const struct pel_http_request *request)
{
    const char *origin = pel_http_find_header(request, "Origin", NULL);
    const char *site = pel_http_find_header(request, "Sec-Fetch-Site", NULL);
    return origin ? !pel_http_origin_is_ours(origin, pel_http_host(request))
                  : site && (strcasecmp(site, "cross-site") == 0 ||
                             strcasecmp(site, "same-site") == 0);
}

enum pel_err pel_http_check_site(const struct pel_http_context *context,
                                 const struct pel_http_request *request,
                                 const struct pel_route *route,
                                 struct pel_fault *fault)
{
    const char *origin = pel_http_find_header(request, "Origin", NULL);
    bool watches =
        pel_role_of_route(route->method, route->pattern) <= PEL_ROLE_WATCH;
    bool edit = !pel_http_is_safe(route->method);
    if (!(route->flags & ROUTE_COSTLY || edit) || !is_foreign(request)) {
        return PEL_OK;
    }
    if (!pel_http_allowed_origin(request, context->origins)) {
        return pel_fault_set(fault, PEL_ERR_INVALID,
                             "pages of %.80s may not ask for pictures of this "
                             "server; pelagosd --allow-origin ORIGIN lets them",
                             origin ? origin : "another origin");
    }
    if (edit && !watches) {
        return pel_fault_set(fault, PEL_ERR_INVALID,
                             "pages of %.80s may watch this server, not change "
                             "it: --allow-origin lets them do what the role "
                             "`watch` may",
                             origin ? origin : "another origin");
    }
    return PEL_OK;
}

static bool is_sdp(const char *type)
{
    size_t length = strcspn(type, "; \t");
    return length == strlen(PEL_WHEP_TYPE) &&
           g_ascii_strncasecmp(type, PEL_WHEP_TYPE, length) == 0;
}

enum pel_err pel_http_check_body(const struct pel_http_context *context,
                                 const struct pel_http_request *request,
                                 const struct pel_route *route, size_t *limit,
                                 int *status, struct pel_fault *fault)
{
    const char *length = pel_http_find_header(request, "Content-Length", NULL);
    const char *type = pel_http_find_header(request, "Content-Type", NULL);
    bool chunked = pel_http_find_header(request, "Transfer-Encoding", NULL);
    double announced = length ? g_ascii_strtod(length, NULL) : 0.0;
    bool sdp = route->flags & ROUTE_SDP;
    bool takes = route->flags & ROUTE_BODY || sdp;
    *limit = !takes                       ? 0
             : route->flags & ROUTE_LARGE ? SURFACE_BODY * context->body_limit
                                          : context->body_limit;
    if (announced > (double)*limit || (!takes && chunked)) {
        *status = takes ? 413 : 400;
        return pel_fault_set(fault, PEL_ERR_INVALID,
                             takes ? "the body may have at most %zu bytes"
                                   : "this request takes no body",
                             *limit);
    }
    if (sdp && (!type || !is_sdp(type))) {
        *status = 415;
        return pel_fault_set(fault, PEL_ERR_INVALID,
                             "Content-Type must be " PEL_WHEP_TYPE);
    }
    bool nothing = announced == 0.0 && !chunked;
    if (takes && !sdp && !(nothing && route->flags & ROUTE_EMPTY_OK) &&
        (!type || !pel_http_type_is_json(type))) {
        *status = 415;
        return pel_fault_set(fault, PEL_ERR_INVALID,
                             "Content-Type must be application/json%s",
                             strcmp(request->method, "PATCH") == 0
                                 ? " or application/merge-patch+json"
                                 : "");
    }
    return PEL_OK;
}

/* --- parameters ----------------------------------------------------------- */

static const struct {
    const char *id, *name;
} parameters[] = {
#define PEL_PARAMETER(id, name, type, minimum, maximum, unit, text)            \
    { #id, name },
#include "proto/routes.def"
};

/* Whether they are alike but for case and one character that is wrong, missing,
 * too many, or in its neighbour's place. */
static bool is_near(const char *a, const char *b)
{
    size_t m = strlen(a), n = strlen(b), head = 0, tail = 0;
    while (head < m && head < n &&
           g_ascii_tolower(a[head]) == g_ascii_tolower(b[head])) {
        head++;
    }
    while (head + tail < m && head + tail < n &&
           g_ascii_tolower(a[m - 1 - tail]) ==
               g_ascii_tolower(b[n - 1 - tail])) {
        tail++;
    }
    m -= head + tail;
    n -= head + tail;
    bool swapped = m == 2 && n == 2 &&
                   g_ascii_tolower(a[head]) == g_ascii_tolower(b[head + 1]) &&
                   g_ascii_tolower(a[head + 1]) == g_ascii_tolower(b[head]);
    return (m <= 1 && n <= 1) || swapped;
}

/* Whether the route takes such a parameter; *near: the name that is meant
 * instead, or NULL. */
static bool knows(const struct pel_route *route, const char *name,
                  const char **near)
{
    bool known = false;
    *near = NULL;
    char **words = g_strsplit(route->query, " ", -1);
    for (int i = 0; words[i] && !known; i++) {
        for (size_t p = 0; p < G_N_ELEMENTS(parameters); p++) {
            if (strcmp(words[i], parameters[p].id) == 0) {
                known = known || strcmp(name, parameters[p].name) == 0;
                *near = is_near(name, parameters[p].name) ? parameters[p].name
                                                          : *near;
            }
        }
    }
    g_strfreev(words);
    return known;
}

/* A name as a header can have it. */
static void append_name(char *list, size_t room, const char *name)
{
    char *plain = g_uri_escape_string(name, NULL, false);
    size_t used = strlen(list);
    if (used + strlen(plain) + 3 < room) {
        snprintf(list + used, room - used, "%s%s", used ? ", " : "", plain);
    }
    g_free(plain);
}

static enum pel_err ignore_unknown(const struct pel_route *route,
                                   struct pel_http_target *target,
                                   char *ignored, size_t room,
                                   struct pel_fault *fault)
{
    size_t kept = 0;
    for (size_t i = 0; i < target->query_count; i++) {
        const struct pel_http_pair pair = target->query[i];
        const char *near;
        if (knows(route, pair.name, &near)) {
            target->query[kept++] = pair;
        } else if (near) {
            char words[96];
            snprintf(words, sizeof words, "no such parameter; `%s` is meant",
                     near);
            return pel_fault_value(fault, PEL_ERR_NOT_FOUND, pair.name,
                                   pair.value, words);
        } else {
            append_name(ignored, room, pair.name);
        }
    }
    target->query_count = kept;
    return PEL_OK;
}

enum pel_err pel_http_check_query(const struct pel_route *route,
                                  struct pel_http_target *target, char *ignored,
                                  size_t room, struct pel_fault *fault)
{
    if (route->flags & ROUTE_LAX) {
        enum pel_err err = ignore_unknown(route, target, ignored, room, fault);
        if (err != PEL_OK) {
            return err;
        }
    } else if (target->query_count > 0 && !(route->flags & ROUTE_QUERY)) {
        return pel_fault_value(fault, PEL_ERR_NOT_FOUND, target->query[0].name,
                               target->query[0].value,
                               "no parameters are taken here");
    }
    for (size_t i = 0; i < target->query_count; i++) {
        for (size_t j = 0; j < i; j++) {
            if (strcmp(target->query[i].name, target->query[j].name) == 0) {
                return pel_fault_value(
                    fault, PEL_ERR_MALFORMED, target->query[i].name,
                    target->query[i].value, "is given twice; say it once");
            }
        }
    }
    return PEL_OK;
}
