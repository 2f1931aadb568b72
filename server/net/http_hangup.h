/* Clients that go while they are made to wait: the library does not watch
 * connections that are suspended, so an epoll of ours does. Control thread. */
#pragma once

#include "net/http_client.h"

void pel_http_watch_hangups(struct pel_http_server *server);
void pel_http_unwatch_hangups(struct pel_http_server *server);

/* From the connection's begin to its end. */
void pel_http_watch_hangup(struct client *client);
void pel_http_unwatch_hangup(struct client *client);

/* Whether any of these events, of poll(2), or the end of both directions is
 * there. */
bool pel_http_polls(const struct client *client, short events);

/* Soon: someone waits who sends no more, and may have gone. */
void pel_http_probe_soon(struct pel_http_server *server);

/* http_server.c: the client sends no more; it ends where it is made to wait and
 * does not read either, and where it is sent a stream. */
void pel_http_left(struct client *client);
