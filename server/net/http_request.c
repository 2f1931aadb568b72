#include "net/http_request.h"

#include <arpa/inet.h>
#include <ctype.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

#include <glib.h>

const char *pel_http_find_header(const struct pel_http_request *request,
                                 const char *name, size_t *count)
{
    const char *first = NULL;
    size_t found = 0;
    for (size_t i = 0; i < request->header_count; i++) {
        if (strcasecmp(request->headers[i].name, name) == 0) {
            first = first ? first : request->headers[i].value;
            found++;
        }
    }
    if (count) {
        *count = found;
    }
    return first;
}

const char *pel_http_host(const struct pel_http_request *request)
{
    return request->authority ? request->authority
                              : pel_http_find_header(request, "Host", NULL);
}

const char *pel_http_split_target(const char *target, char **authority)
{
    static const char *const schemes[] = { "http://", "https://" };
    *authority = NULL;
    for (size_t i = 0; i < 2; i++) {
        size_t length = strlen(schemes[i]);
        if (strncasecmp(target, schemes[i], length) == 0) {
            const char *host = target + length;
            const char *path = host + strcspn(host, "/?#");
            *authority = g_strndup(host, (gsize)(path - host));
            return path;
        }
    }
    return target;
}

static int hex(char c)
{
    if (c >= '0' && c <= '9') {
        return c - '0';
    }
    c = (char)(c | 0x20);
    return c >= 'a' && c <= 'f' ? c - 'a' + 10 : -1;
}

/* Decodes [from, end) into the target's text; NULL: not legal. */
static char *decode(struct pel_http_target *out, const char *from,
                    const char *end, bool plus)
{
    char *start = out->text + out->used;
    char *to = start;
    while (from < end) {
        int c = (unsigned char)*from++;
        if (c == '%') {
            int high = end - from >= 2 ? hex(from[0]) : -1;
            int low = high >= 0 ? hex(from[1]) : -1;
            if (low < 0) {
                return NULL;
            }
            c = high << 4 | low;
            from += 2;
        } else if (c == '+' && plus) {
            c = ' ';
        }
        if (c < 0x20 || c == 0x7f) {
            return NULL;
        }
        *to++ = (char)c;
    }
    *to++ = '\0';
    out->used = (size_t)(to - out->text);
    return start;
}

static bool parse_path(const char *path, const char *end,
                       struct pel_http_target *out)
{
    while (path < end) {
        path++; /* the slash */
        const char *stop = memchr(path, '/', (size_t)(end - path));
        stop = stop ? stop : end;
        if (stop == path && stop == end && out->segment_count == 0) {
            break; /* "/" alone */
        }
        if (out->segment_count == PEL_HTTP_MAX_SEGMENTS) {
            return false;
        }
        char *segment = decode(out, path, stop, false);
        if (!segment) {
            return false;
        }
        out->segments[out->segment_count++] = segment;
        path = stop;
    }
    return true;
}

static bool parse_query(const char *query, const char *end,
                        struct pel_http_target *out)
{
    while (query < end) {
        const char *stop = memchr(query, '&', (size_t)(end - query));
        stop = stop ? stop : end;
        const char *equals = memchr(query, '=', (size_t)(stop - query));
        const char *name_end = equals ? equals : stop;
        if (stop == query) {
            query++;
            continue;
        }
        if (out->query_count == PEL_HTTP_MAX_QUERY) {
            return false;
        }
        struct pel_http_pair pair = {
            .name = decode(out, query, name_end, true),
            .value = decode(out, equals ? equals + 1 : stop, stop, true),
        };
        if (!pair.name || !pair.value || !*pair.name) {
            return false;
        }
        out->query[out->query_count++] = pair;
        query = stop + (stop < end);
    }
    return true;
}

enum pel_err pel_http_parse_target(const char *target,
                                   struct pel_http_target *out,
                                   struct pel_fault *fault)
{
    out->used = 0;
    out->segment_count = 0;
    out->query_count = 0;
    size_t length = strlen(target);
    if (length >= PEL_HTTP_MAX_TARGET || target[0] != '/') {
        return pel_fault_set(fault, PEL_ERR_MALFORMED,
                             "the request target must be a path of at most "
                             "%d bytes",
                             PEL_HTTP_MAX_TARGET - 1);
    }
    const char *end = target + length;
    const char *mark = memchr(target, '?', length);
    if (!parse_path(target, mark ? mark : end, out)) {
        return pel_fault_set(fault, PEL_ERR_MALFORMED,
                             "the path has a bad escape or too many parts");
    }
    if (mark && !parse_query(mark + 1, end, out)) {
        return pel_fault_set(
            fault, PEL_ERR_MALFORMED,
            "the query has a bad escape, a parameter without a "
            "name or too many of them");
    }
    return PEL_OK;
}

/* Copies the host of `host[:port]` without brackets; false: not one. */
static bool split_host(const char *host, char *out, size_t size, bool *bracket)
{
    *bracket = host[0] == '[';
    size_t length;
    const char *rest;
    if (*bracket) {
        const char *close = strchr(host, ']');
        if (!close) {
            return false;
        }
        length = (size_t)(close - ++host);
        rest = close + 1;
    } else {
        length = strcspn(host, ":");
        rest = host + length;
    }
    if (length == 0 || length >= size) {
        return false;
    }
    memcpy(out, host, length);
    out[length] = '\0';
    if (*rest == '\0') {
        return true;
    }
    size_t digits = strspn(rest + 1, "0123456789");
    return *rest == ':' && digits <= 5 && rest[1 + digits] == '\0';
}

bool pel_http_host_is_ours(const char *host, const char *const *hosts)
{
    char name[256];
    bool bracket = false;
    if (!split_host(host, name, sizeof name, &bracket)) {
        return false;
    }
    struct in6_addr address;
    if (bracket) {
        return inet_pton(AF_INET6, name, &address) == 1;
    }
    if (inet_pton(AF_INET, name, &address) == 1 ||
        strcasecmp(name, "localhost") == 0) {
        return true;
    }
    for (; hosts && *hosts; hosts++) {
        if (strcasecmp(name, *hosts) == 0) {
            return true;
        }
    }
    return false;
}

bool pel_http_origin_is_ours(const char *origin, const char *host)
{
    const char *schemes[] = { "http://", "https://" };
    for (size_t i = 0; i < 2; i++) {
        size_t length = strlen(schemes[i]);
        if (strncasecmp(origin, schemes[i], length) == 0) {
            return strcasecmp(origin + length, host) == 0;
        }
    }
    return false;
}

const char *pel_http_allowed_origin(const struct pel_http_request *request,
                                    const char *const *origins)
{
    const char *from = pel_http_find_header(request, "Origin", NULL);
    from = from ? from : pel_http_find_header(request, "Referer", NULL);
    for (; from && origins && *origins; origins++) {
        size_t length = strlen(*origins);
        if (strncasecmp(from, *origins, length) == 0 &&
            (from[length] == '\0' || from[length] == '/')) {
            return *origins;
        }
    }
    return NULL;
}

bool pel_http_type_is_json(const char *type)
{
    size_t length = strcspn(type, "; \t");
    static const char *const known[] = { "application/json",
                                         "application/merge-patch+json" };
    bool json = false;
    for (size_t i = 0; i < 2; i++) {
        json = json || (strlen(known[i]) == length &&
                        strncasecmp(type, known[i], length) == 0);
    }
    const char *rest = type + length;
    rest += strspn(rest, "; \t");
    return json && (*rest == '\0' || strcasecmp(rest, "charset=utf-8") == 0 ||
                    strcasecmp(rest, "charset=\"utf-8\"") == 0);
}

bool pel_http_tag_matches(const char *value, const char *tag, bool weak)
{
    size_t length = strlen(tag);
    for (;;) {
        value += strspn(value, " \t,");
        if (*value == '\0') {
            return false;
        }
        if (value[0] == '*') {
            return true;
        }
        bool is_weak = strncmp(value, "W/", 2) == 0;
        value += is_weak ? 2 : 0;
        if (*value != '"') {
            return false;
        }
        const char *close = strchr(value + 1, '"');
        if (!close) {
            return false;
        }
        if ((weak || !is_weak) && (size_t)(close + 1 - value) == length &&
            strncmp(value, tag, length) == 0) {
            return true;
        }
        value = close + 1;
    }
}
