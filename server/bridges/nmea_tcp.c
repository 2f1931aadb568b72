#include "bridges/nmea_tcp.h"

#include <errno.h>
#include <fcntl.h>
#include <glib-unix.h>
#include <netinet/in.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include "base/clock.h"
#include "base/log.h"
#include "base/watch.h"
#include "bounds.h"
#include "bridges/endpoint.h"
#include "bridges/nmea.h"

#define MAX_CLIENTS PEL_BOUND_NMEA_CLIENTS
#define CHUNK 4096
#define IDLE_NS 60000000000LL

struct client {
    struct pel_nmea_tcp *tcp;
    int fd; /* -1: free */
    guint source;
    int64_t heard_ns;
    bool began; /* something came */
    struct pel_nmea_lines lines;
};

struct pel_nmea_tcp {
    struct pel_nmea_tcp_options options;
    struct pel_nmea *nmea;
    struct pel_allow allow;
    int fd, reserve_fd;
    uint16_t port;
    guint source;
    uint64_t accepted, refused;
    struct client clients[MAX_CLIENTS];
};

static void hang_up(struct client *c)
{
    g_source_remove(c->source);
    close(c->fd);
    c->fd = -1;
}

/* A page of any origin may have a browser send its own lines after the head of
 * a request; no sentence begins like that. */
static bool is_browser(const char *chunk, size_t size)
{
    size_t method = 0;
    while (method < size && chunk[method] >= 'A' && chunk[method] <= 'Z') {
        method++;
    }
    return method > 0 && size > method + 1 && chunk[method] == ' ' &&
           chunk[method + 1] == '/';
}

static gboolean on_client(gint fd, GIOCondition condition, gpointer user)
{
    PEL_WATCH("nmea");
    struct client *c = user;
    char chunk[CHUNK];
    (void)condition;
    ssize_t n = recv(fd, chunk, sizeof chunk, 0);
    if (n < 0 && (errno == EAGAIN || errno == EINTR)) {
        return G_SOURCE_CONTINUE;
    }
    bool refused = n > 0 && !c->began && is_browser(chunk, (size_t)n);
    if (refused) {
        static struct pel_log_limit limit;
        pel_log_limited(&limit, PEL_LOG_WARNING, "NMT-003",
                        "HTTP came instead of NMEA: the sender was hung up on");
        c->tcp->refused++;
    }
    if (n > 0 && !refused) {
        c->began = true;
        c->heard_ns = pel_now_ns();
        pel_nmea_feed_stream(c->tcp->nmea, &c->lines, chunk, (size_t)n);
        return G_SOURCE_CONTINUE;
    }
    hang_up(c);
    return G_SOURCE_REMOVE;
}

/* A free place, if need be that of the one longest silent; NULL: none. */
static struct client *find_place(struct pel_nmea_tcp *tcp)
{
    struct client *idlest = &tcp->clients[0];
    for (int i = 0; i < MAX_CLIENTS; i++) {
        struct client *c = &tcp->clients[i];
        if (c->fd < 0) {
            return c;
        }
        idlest = c->heard_ns < idlest->heard_ns ? c : idlest;
    }
    if (pel_now_ns() - idlest->heard_ns <= IDLE_NS) {
        return NULL;
    }
    hang_up(idlest);
    return idlest;
}

static void take_client(struct pel_nmea_tcp *tcp, int fd,
                        const struct sockaddr *peer)
{
    static struct pel_log_limit limit;
    bool allowed = pel_allow_has(&tcp->allow, peer);
    struct client *c = allowed ? find_place(tcp) : NULL;
    if (!c) {
        pel_log_limited(&limit, PEL_LOG_WARNING, "NMT-002",
                        "a sender of NMEA was refused: %s",
                        allowed ? "all connections are taken"
                                : "not in the list of allowed addresses");
        tcp->refused++;
        close(fd);
        return;
    }
    *c = (struct client){ .tcp = tcp, .fd = fd, .heard_ns = pel_now_ns() };
    c->source = g_unix_fd_add(fd, G_IO_IN, on_client, c);
    tcp->accepted++;
}

/* With no descriptor left the connection would wake us for ever. */
static void refuse_without_descriptor(struct pel_nmea_tcp *tcp)
{
    close(tcp->reserve_fd);
    int fd = accept(tcp->fd, NULL, NULL);
    if (fd >= 0) {
        close(fd);
        tcp->refused++;
    }
    tcp->reserve_fd = open("/dev/null", O_RDONLY | O_CLOEXEC);
}

static gboolean on_accept(gint fd, GIOCondition condition, gpointer user)
{
    PEL_WATCH("nmea");
    struct pel_nmea_tcp *tcp = user;
    struct sockaddr_storage peer = { 0 };
    socklen_t size = sizeof peer;
    (void)condition;
    int client = accept4(fd, (struct sockaddr *)&peer, &size,
                         SOCK_NONBLOCK | SOCK_CLOEXEC);
    if (client >= 0) {
        take_client(tcp, client, (struct sockaddr *)&peer);
    } else if (errno == EMFILE || errno == ENFILE) {
        refuse_without_descriptor(tcp);
    }
    return G_SOURCE_CONTINUE;
}

static void collect(void *user, struct pel_metrics_page *page)
{
    const struct pel_nmea_tcp *tcp = user;
    int count = 0;
    for (int i = 0; i < MAX_CLIENTS; i++) {
        count += tcp->clients[i].fd >= 0;
    }
    pel_metric(page, "pelagos_nmea_tcp_clients", PEL_METRIC_GAUGE,
               "Senders of NMEA over TCP.", NULL, count);
    pel_metric(page, "pelagos_nmea_tcp_connections_total", PEL_METRIC_COUNTER,
               "Senders of NMEA over TCP taken.", NULL, (double)tcp->accepted);
    pel_metric(page, "pelagos_nmea_tcp_refused_total", PEL_METRIC_COUNTER,
               "Senders of NMEA over TCP not allowed or too many.", NULL,
               (double)tcp->refused);
}

enum pel_err pel_nmea_tcp_create(const struct pel_nmea_tcp_options *options,
                                 struct pel_nmea *nmea,
                                 struct pel_nmea_tcp **out,
                                 struct pel_fault *fault)
{
    struct pel_nmea_tcp made = { .options = *options, .nmea = nmea, .fd = -1 };
    enum pel_err err = pel_allow_parse(options->allow, &made.allow, fault);
    if (!err) {
        err = pel_endpoint_open("nmea-tcp", options->listen, options->allow,
                                SOCK_STREAM, &made.fd, &made.port, fault);
    }
    if (err) {
        return err;
    }
    struct pel_nmea_tcp *tcp = g_new(struct pel_nmea_tcp, 1);
    *tcp = made;
    for (int i = 0; i < MAX_CLIENTS; i++) {
        tcp->clients[i].fd = -1;
    }
    tcp->reserve_fd = open("/dev/null", O_RDONLY | O_CLOEXEC);
    tcp->source = g_unix_fd_add(tcp->fd, G_IO_IN, on_accept, tcp);
    if (options->metrics) {
        pel_metrics_add(options->metrics, collect, tcp);
    }
    pel_info("NMT-001", "NMEA 0183 on TCP %s, port %u", options->listen,
             tcp->port);
    *out = tcp;
    return PEL_OK;
}

void pel_nmea_tcp_destroy(struct pel_nmea_tcp *tcp)
{
    if (!tcp) {
        return;
    }
    if (tcp->options.metrics) {
        pel_metrics_remove(tcp->options.metrics, collect, tcp);
    }
    for (int i = 0; i < MAX_CLIENTS; i++) {
        if (tcp->clients[i].fd >= 0) {
            hang_up(&tcp->clients[i]);
        }
    }
    g_source_remove(tcp->source);
    close(tcp->fd);
    if (tcp->reserve_fd >= 0) {
        close(tcp->reserve_fd);
    }
    g_free(tcp);
}

uint16_t pel_nmea_tcp_port(const struct pel_nmea_tcp *tcp)
{
    return tcp->port;
}
