#include "net/http_hangup.h"

#include <poll.h>
#include <sys/epoll.h>
#include <sys/socket.h>
#include <unistd.h>

#include "base/watch.h"
#include "net/fdsource.h"

#define AT_ONCE 8    /* the others in the next turn */
#define PROBE_MS 100 /* most answers are there by then */

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
    if (server->probing) {
        g_source_remove(server->probing);
        server->probing = 0;
    }
    if (server->hangup_source) {
        pel_fdsource_destroy(server->hangup_source);
        close(server->hangups);
        server->hangup_source = NULL;
    }
}

/* Told at the edges: the end of what it sends, the end of all. Without an epoll
 * the sweep finds them. */
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

bool pel_http_polls(const struct client *client, short events)
{
    struct pollfd probe = { .fd = client->fd, .events = events };
    return poll(&probe, 1, 0) == 1;
}

/* The end of what a client sends looks the same, whether it still reads or not.
 * An interim answer, which every client of HTTP/1.1 takes (RFC 9110, 15.2),
 * tells: where nobody reads, the kernel sends a reset back. */
static void probe(struct client *client)
{
    static const char interim[] = "HTTP/1.1 100 Continue\r\n\r\n";
    bool probed = client->probed;
    client->probed = true;
    if (!probed && client->interim) {
        (void)send(client->fd, interim, sizeof interim - 1,
                   MSG_DONTWAIT | MSG_NOSIGNAL);
    }
}

static gboolean probe_all(gpointer user)
{
    PEL_WATCH("http");
    struct pel_http_server *server = user;
    server->probing = 0;
    for (guint i = 0; i < server->clients->len; i++) {
        struct client *client = g_ptr_array_index(server->clients, i);
        if (!client->gone || !client->suspended ||
            client->phase == PHASE_CLOSED) {
            continue;
        }
        if (client->phase != PHASE_STREAM) {
            probe(client);
        }
        pel_http_left(client);
    }
    return G_SOURCE_REMOVE;
}

void pel_http_probe_soon(struct pel_http_server *server)
{
    if (!server->probing && server->hangup_source) {
        server->probing = g_timeout_add(PROBE_MS, probe_all, server);
    }
}
