/* Admission of connections: shares by source address, places that streams leave
 * free, and a reserve for /healthz and for clients that have the token. Control
 * thread. */
#pragma once

#include "net/http_client.h"

#define PEL_HTTP_RESERVE 8 /* connections beyond the limits */

struct pel_http_source pel_http_source_of(const struct pel_http_server *server,
                                          const struct sockaddr *address);

/* Whether a connection may be opened; one that waits for the rest of a head or
 * a body for longest may have been closed for it. *reserve: it has one of the
 * places for those of pel_http_share_admit. False: the client has been told. */
bool pel_http_share_open(struct pel_http_server *server, int fd,
                         const struct pel_http_source *source, bool *reserve);

/* Whether this request, whose head has arrived, is admitted: `open`: it asks
 * for a public resource (health); `holder`: it has the token. */
bool pel_http_share_admit(struct client *client,
                          const struct pel_http_request *request, bool open,
                          bool holder, struct pel_http_answer *answer);

/* Whether a stream may begin: an eighth of a share is for other requests. */
bool pel_http_share_stream(struct client *client,
                           struct pel_http_answer *answer);

/* Ends a connection and cancels its request. */
void pel_http_shut(struct client *client);
