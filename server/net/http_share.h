/* Admission of connections and requests: shares by source address, by role and
 * by token, places that streams leave free, and a reserve for /healthz and for
 * clients who steer or instruct. Control thread. */
#pragma once

#include "net/http_client.h"

#define PEL_HTTP_RESERVE 8 /* connections beyond the limits */

struct pel_http_source pel_http_source_of(const struct pel_http_server *server,
                                          const struct sockaddr *address);

/* Who a connection is of before its first head. */
struct pel_who pel_http_first_who(const struct pel_http_server *server);

/* Whether a connection may be opened; one that is idle, or waits for the rest
 * of a head or a body, may have been closed for it, of the lowest role first
 * and the oldest of that. *reserve: it has one of the places for those of
 * pel_http_share_admit. False: the client has been told. */
bool pel_http_share_open(struct pel_http_server *server, int fd,
                         const struct pel_http_source *source, bool *reserve);

/* Where descriptors run out: ends the one that can best be spared, an idle one
 * or one without a token or that only watches; false: there is none. */
bool pel_http_share_starved(struct pel_http_server *server);

/* Whether this request, whose head has arrived, is admitted: what is public
 * (client->open) always is, others by client->who; for who steers or instructs
 * a request of a lower role may have been ended. */
bool pel_http_share_admit(struct client *client,
                          const struct pel_http_request *request,
                          struct pel_http_answer *answer);

/* Whether a stream may begin: an eighth of a share is for other requests. */
bool pel_http_share_stream(struct client *client,
                           struct pel_http_answer *answer);

/* Ends a connection and cancels its request. */
void pel_http_shut(struct client *client);
