/* Clients that go while they are made to wait: the library does not watch
 * connections that are suspended, so an epoll of ours does. Control thread. */
#pragma once

#include "net/http_client.h"

void pel_http_watch_hangups(struct pel_http_server *server);
void pel_http_unwatch_hangups(struct pel_http_server *server);

/* From the connection's begin to its end. */
void pel_http_watch_hangup(struct client *client);
void pel_http_unwatch_hangup(struct client *client);

/* At the loop's next turn: someone waits who has gone already. */
void pel_http_look_soon(struct pel_http_server *server);

/* http_server.c: the client sends no more; it ends where it is made to wait. */
void pel_http_left(struct client *client);
