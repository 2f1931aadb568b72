/* HTTP on sockets, over libmicrohttpd: the one module that knows the library.
 * Control thread. What requests mean is http_route's business. */
#pragma once

#include <netinet/in.h>
#include <stdbool.h>
#include <stdint.h>
#include <sys/socket.h>

#include "base/metrics.h"
#include "net/http_route.h"
#include "net/net.h"
#include "net/wheppeer.h"

struct pel_http_server;

/* INTERNAL if the library refuses. The context and `whep` are copied, what they
 * point to is borrowed. */
PEL_CHECK enum pel_err pel_http_server_create(
    const struct pel_net_limits *limits, const struct pel_http_context *context,
    const struct pel_whep_places *whep, struct pel_frames *frames,
    struct pel_http_server **out, struct pel_fault *fault);
void pel_http_server_destroy(struct pel_http_server *server);

/* Takes over a non-blocking socket, or returns false when a limit is reached;
 * the client has then been told. */
bool pel_http_server_accept(struct pel_http_server *server, int fd,
                            const struct sockaddr *address, socklen_t size);

/* As pel_listener_on_starved wants it. */
bool pel_http_server_starved(struct pel_http_server *server);

/* From now on /readyz says that clients may be sent here. */
void pel_http_server_ready(struct pel_http_server *server);

/* From now on /healthz says that the server stops, and other requests that
 * are new are refused with 503. */
void pel_http_server_stop(struct pel_http_server *server);

/* Tokens have changed: whoever has one that does not hold ends. */
void pel_http_server_revoke(struct pel_http_server *server);

/* Requests being answered, streams not counted. */
unsigned pel_http_server_in_flight(const struct pel_http_server *server);

void pel_http_server_collect(const struct pel_http_server *server,
                             struct pel_metrics_page *page);
