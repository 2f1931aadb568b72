#include "net/http_hangup.h"

#include <sys/epoll.h>
#include <unistd.h>

#include "base/watch.h"
#include "net/fdsource.h"

#define AT_ONCE 64

static void on_hangups(void *user, GIOCondition ready)
{
    (void)ready;
    struct pel_http_server *server = user;
    struct epoll_event events[AT_ONCE];
    int count = epoll_wait(server->hangups, events, AT_ONCE, 0);
    for (int i = 0; i < count; i++) {
        pel_http_left(events[i].data.ptr);
    }
}

void pel_http_watch_hangups(struct pel_http_server *server)
{
    server->hangups = epoll_create1(EPOLL_CLOEXEC);
    if (server->hangups >= 0) {
        server->hangup_source =
            pel_fdsource_create(server->hangups, G_IO_IN, on_hangups, server);
    }
}

void pel_http_unwatch_hangups(struct pel_http_server *server)
{
    if (server->look) {
        g_source_remove(server->look);
        server->look = 0;
    }
    if (server->hangup_source) {
        pel_fdsource_destroy(server->hangup_source);
        close(server->hangups);
        server->hangup_source = NULL;
    }
}

/* Told once: at the edge. Without an epoll the sweep finds them. */
void pel_http_watch_hangup(struct client *client)
{
    struct epoll_event event = { .events = EPOLLRDHUP | EPOLLET,
                                 .data.ptr = client };
    epoll_ctl(client->server->hangups, EPOLL_CTL_ADD, client->fd, &event);
}

void pel_http_unwatch_hangup(struct client *client)
{
    epoll_ctl(client->server->hangups, EPOLL_CTL_DEL, client->fd, NULL);
}

static gboolean look(gpointer user)
{
    PEL_WATCH("http");
    struct pel_http_server *server = user;
    server->look = 0;
    for (guint i = 0; i < server->clients->len; i++) {
        struct client *client = g_ptr_array_index(server->clients, i);
        if (client->gone) {
            pel_http_left(client);
        }
    }
    return G_SOURCE_REMOVE;
}

void pel_http_look_soon(struct pel_http_server *server)
{
    if (!server->look && server->hangup_source) {
        server->look = g_idle_add(look, server);
    }
}
