/* What libmicrohttpd does not see or does not say of the head of a request, and
 * answers written past it. Control thread. */
#pragma once

#include "net/http_client.h"

/* Of a target as the library has just found it: the end of the version behind
 * it; NULL: there is none, or a NUL in the line ends what the library takes for
 * the target before it. */
const char *pel_http_head_version(const char *target);

/* Whether method, target and headers are all that the head has: no NUL cuts one
 * of them short, no line goes on with the next. With the first call of the
 * library's handler for a request; `target` as it was found, and what
 * pel_http_head_version said of it. */
bool pel_http_head_is_plain(struct MHD_Connection *connection,
                            const char *method, const char *target,
                            const char *version);

/* Whether the whole head has come. */
bool pel_http_head_is_in(struct MHD_Connection *connection);

/* Writes problem+json straight to the socket, counted as malformed, where the
 * library could not send an answer or would send its own; whatever the socket
 * does not take is lost. The connection is to be closed then. */
void pel_http_head_refuse(struct client *client, int status,
                          const struct pel_fault *fault);
