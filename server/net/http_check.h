/* Tests a request before it is carried out: its framing, the page that asks,
 * the form of its body, the names in its query. Internals of
 * http_route.c; no sockets. Any thread. */
#pragma once

#include "net/http_route.h"
#include "net/http_view.h"

enum pel_route_flags {
    ROUTE_BODY = 1,     /* takes JSON */
    ROUTE_EMPTY_OK = 2, /* or nothing */
    ROUTE_LARGE = 4,    /* with the larger limit */
    ROUTE_NO_HEAD = 8,  /* GET only */
    ROUTE_REST = 16,    /* the last segment stands for all that follow */
    ROUTE_QUERY = 32,   /* takes parameters */
    ROUTE_OPEN = 64,    /* for those without the token too */
    ROUTE_COSTLY = 128, /* pages of other origins may not ask */
    ROUTE_SDP = 256,    /* takes an offer of WebRTC */
    ROUTE_LAX = 512,    /* parameters that it does not know are ignored */
};

struct pel_route {
    const char *method;
    const char *pattern; /* as in proto/routes.def */
    int flags;
    void (*handle)(const struct pel_http_call *call);
    const char *query; /* its parameters, likewise */
    const char *body;  /* a message of the schema, "merge", "sdp" or "" */
};

/* GET, HEAD. */
bool pel_http_is_safe(const char *method);

/* Framing that two readers could understand differently, and strangers.
 * *status: of the refusal. */
PEL_CHECK enum pel_err
pel_http_check_head(const struct pel_http_context *context,
                    const struct pel_http_request *request, int *status,
                    struct pel_fault *fault);

/* Whether the page of another origin that asks, if one does, may use this
 * route: any GET but costly ones, and where --allow-origin names it all that
 * the role `watch` may. */
PEL_CHECK enum pel_err
pel_http_check_site(const struct pel_http_context *context,
                    const struct pel_http_request *request,
                    const struct pel_route *route, struct pel_fault *fault);

/* *limit: the most bytes of its body. */
PEL_CHECK enum pel_err
pel_http_check_body(const struct pel_http_context *context,
                    const struct pel_http_request *request,
                    const struct pel_route *route, size_t *limit, int *status,
                    struct pel_fault *fault);

/* Refuses parameters where there are none, and one that is given twice. Of a
 * ROUTE_LAX it takes those out of the query that the route does not know and
 * appends their names to `ignored`, percent-encoded, separated by ", "; but a
 * name that differs from a known one by its case or by one character that is
 * wrong, missing, too many or in its neighbour's place is refused and told. */
PEL_CHECK enum pel_err pel_http_check_query(const struct pel_route *route,
                                            struct pel_http_target *target,
                                            char *ignored, size_t room,
                                            struct pel_fault *fault);
