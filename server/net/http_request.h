/* One HTTP request as data, and its parts decoded. No sockets, no library:
 * everything here is a function of its arguments. Any thread. */
#pragma once

#include <stdbool.h>
#include <stddef.h>

#include "base/err.h"
#include "bounds.h"

#define PEL_HTTP_MAX_SEGMENTS 8
#define PEL_HTTP_MAX_QUERY PEL_BOUND_HTTP_QUERY
#define PEL_HTTP_MAX_TARGET (PEL_BOUND_HTTP_TARGET_BYTES + 1)

struct pel_http_header {
    const char *name, *value;
};

struct pel_http_read;

struct pel_http_request {
    const char *method;
    const char *target; /* the path, with the query */
    /* HOST:PORT of a target in absolute form (RFC 9112, 3.2.2), which holds
     * instead of Host; NULL: it was not */
    const char *authority;
    const struct pel_http_header *headers;
    size_t header_count;
    const char *body; /* need not be terminated */
    size_t body_size;
    struct pel_http_read *read; /* the body as a message, or NULL: not yet */
};

/* First value of a header (any case), or NULL; *count (may be NULL): how many
 * there are. */
const char *pel_http_find_header(const struct pel_http_request *request,
                                 const char *name, size_t *count);

/* The host name asked for: of an absolute target, else of the Host header;
 * NULL: none. */
const char *pel_http_host(const struct pel_http_request *request);

/* Takes a target in absolute form apart: its path, which begins with `?` where
 * it has none; *authority: HOST:PORT of it, g_free(). Any other target: itself,
 * *authority NULL. */
const char *pel_http_split_target(const char *target, char **authority);

struct pel_http_pair {
    char *name, *value;
};

/* A target taken apart: percent-decoded segments and query. */
struct pel_http_target {
    char text[2 * PEL_HTTP_MAX_TARGET]; /* holds the strings below */
    size_t used;
    char *segments[PEL_HTTP_MAX_SEGMENTS];
    size_t segment_count; /* "/" has none */
    struct pel_http_pair query[PEL_HTTP_MAX_QUERY];
    size_t query_count;
};

/* MALFORMED: not an absolute path, a bad escape, a control character, more
 * segments or parameters than there is room for. Nothing between two `&` is no
 * parameter. */
PEL_CHECK enum pel_err pel_http_parse_target(const char *target,
                                             struct pel_http_target *out,
                                             struct pel_fault *fault);

/* Whether a Host header names this server for certain: an address, localhost
 * or a name in `hosts` (NULL-terminated; NULL: none). Any other name may be a
 * stranger's that was made to resolve to us (DNS rebinding). */
bool pel_http_host_is_ours(const char *host, const char *const *hosts);

/* Whether Origin (`scheme://host:port`) is the page of this very Host. */
bool pel_http_origin_is_ours(const char *origin, const char *host);

/* The one of `origins` (NULL-terminated; NULL: none) that the page is of which
 * made the request, by Origin or else by Referer; NULL: of none of them. */
const char *pel_http_allowed_origin(const struct pel_http_request *request,
                                    const char *const *origins);

/* Whether a Content-Type is JSON or a JSON merge patch, in UTF-8. */
bool pel_http_type_is_json(const char *content_type);

/* Whether one of the entity tags in an If-Match or If-None-Match value equals
 * `tag` (with quotes), or the value is `*`. `weak`: W/ makes no difference. */
bool pel_http_tag_matches(const char *value, const char *tag, bool weak);
