/* Admission of connections and requests: shares by source address, by role and
 * by token, places that streams leave free, and a reserve for /healthz and for
 * clients who steer or instruct. Control thread. */
#pragma once

#include "net/http_client.h"

#define PEL_HTTP_RESERVE 8 /* connections beyond the limits */

struct pel_http_source pel_http_source_of(const struct pel_http_server *server,
                                          const struct sockaddr *address);

/* The rank of a connection before its first head. */
struct pel_who pel_http_first_who(const struct pel_http_server *server);

/* A connection is to be opened: the one of its source whose head has not come
 * for longest may be closed for it. */
void pel_http_share_open(struct pel_http_server *server,
                         const struct pel_http_source *source);

/* Where descriptors run out: ends the one that can best be spared, an idle one
 * or one without a token or that only watches; false: there is none. */
bool pel_http_share_starved(struct pel_http_server *server);

/* Whether this request, whose head has arrived, is admitted: what is public
 * (client->open) always is, others by client->who. Where places are taken one
 * that is idle, or in the middle of a head or a body, may have been closed, of
 * the lowest role first and the oldest of that, and for who steers or instructs
 * a request of a lower role. */
bool pel_http_share_admit(struct client *client,
                          const struct pel_http_request *request,
                          struct pel_http_answer *answer);

/* Whether a stream may begin: an eighth of a share is for other requests. */
bool pel_http_share_stream(struct client *client,
                           struct pel_http_answer *answer);

/* Ends a connection and cancels its request. */
void pel_http_shut(struct client *client);
