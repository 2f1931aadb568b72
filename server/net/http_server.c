#include "net/http_share.h"

#include <netinet/tcp.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <glib.h>
#include <microhttpd.h>

#include "base/clock.h"
#include "base/log.h"
#include "base/watch.h"
#include "bounds.h"
#include "net/http_auth.h"
#include "net/http_hangup.h"
#include "net/http_head.h"
#include "net/tcpinfo.h"
#include "scene/led.h"

#define IDLE_S 10 /* silence that the library ends by itself */
#define MEMORY_BYTES PEL_BOUND_HTTP_HEAD_BYTES
#define MAX_HEADERS PEL_BOUND_HTTP_HEADERS
#define SWEEP_MS 250
#define CLOSING_ROOM 128 /* connections that are being closed */
#define TURNS_AT_ONCE                                                          \
    32 /* of the library, before we look what keeps it busy                    \
        */

struct daemon_source {
    GSource source;
    struct pel_http_server *server;
    void *tag;
    gint64 due_us;
};

/* --- requests ------------------------------------------------------------- */

struct headers {
    struct pel_http_header list[MAX_HEADERS];
    size_t count;
};

static enum MHD_Result take_header(void *user, enum MHD_ValueKind kind,
                                   const char *name, const char *value)
{
    (void)kind;
    struct headers *headers = user;
    if (headers->count == MAX_HEADERS) {
        headers->count++;
        return MHD_NO;
    }
    headers->list[headers->count++] =
        (struct pel_http_header){ name, value ? value : "" };
    return MHD_YES;
}

/* False: more headers than a request may have. */
static bool describe(struct client *client, const char *method,
                     struct headers *headers, struct pel_http_request *out)
{
    headers->count = 0;
    MHD_get_connection_values(client->connection, MHD_HEADER_KIND, take_header,
                              headers);
    *out = (struct pel_http_request){
        .method = method,
        .target = client->target ? client->target : "",
        .authority = client->authority,
        .headers = headers->list,
        .header_count = MIN(headers->count, MAX_HEADERS),
        .body = client->body ? client->body->str : "",
        .body_size = client->body ? client->body->len : 0,
        .read = client->parsed,
    };
    return headers->count <= MAX_HEADERS;
}

static bool is_health(const struct pel_http_request *request)
{
    size_t path = strcspn(request->target, "?");
    return (path == strlen("/healthz") &&
            strncmp(request->target, "/healthz", path) == 0) ||
           (path == strlen("/readyz") &&
            strncmp(request->target, "/readyz", path) == 0);
}

static enum MHD_Result take_head(struct client *client, const char *method)
{
    struct headers headers;
    struct pel_http_request request;
    struct pel_http_answer answer = { .kind = PEL_HTTP_WHOLE };
    struct pel_fault fault;
    client->first = false;
    if (!pel_http_head_is_plain(client->connection, method, client->target_at,
                                client->version_at)) {
        pel_fault_set(&fault, PEL_ERR_MALFORMED,
                      "the head has a NUL or a folded line in it, or is no "
                      "HTTP/1.1");
        client->server->malformed++;
        return pel_http_send_fault(client, 400, &fault);
    }
    if (!describe(client, method, &headers, &request)) {
        pel_fault_set(&fault, PEL_ERR_MALFORMED,
                      "there may be at most %d headers", MAX_HEADERS);
        client->server->malformed++;
        return pel_http_send_fault(client, 400, &fault);
    }
    if (client->server->context.stopping && !is_health(&request)) {
        pel_fault_set(&fault, PEL_ERR_BUSY, "the server stops");
        return pel_http_send_fault(client, 0, &fault);
    }
    client->origin =
        pel_http_allowed_origin(&request, client->server->context.origins);
    bool admitted = pel_http_admit(&client->server->context, &request,
                                   &client->body_limit, &answer);
    if (!admitted) {
        client->server->malformed +=
            answer.status != 404 && answer.status != 401;
        return pel_http_send(client, &answer);
    }
    client->who = pel_http_who(&client->server->context, &request);
    client->open = is_health(&request);
    if (!pel_http_share_admit(client, &request, &answer)) {
        return pel_http_send(client, &answer);
    }
    client->phase = PHASE_BODY;
    client->since_ns = pel_now_ns();
    client->deadline_ns = pel_http_after(client->server->limits.http_body_s);
    return MHD_YES;
}

/* A body without announced length grew too long. The library cannot answer in
 * the middle of a body, so the answer is written past it. */
static enum MHD_Result refuse_body(struct client *client)
{
    struct pel_fault fault;
    pel_fault_set(&fault, PEL_ERR_OUT_OF_RANGE,
                  "the body has more than %zu bytes", client->body_limit);
    pel_http_head_refuse(client, 413, &fault);
    client->phase = PHASE_CLOSED;
    return MHD_NO;
}

static enum MHD_Result take_body(struct client *client, const char *data,
                                 size_t size)
{
    size_t have = client->body ? client->body->len : 0;
    if (have + size > client->body_limit) {
        return refuse_body(client);
    }
    if (!client->body) {
        client->body = g_string_new(NULL);
    }
    g_string_append_len(client->body, data, (gssize)size);
    return MHD_YES;
}

enum MHD_Result pel_http_take(struct client *client)
{
    struct headers headers;
    struct pel_http_request request;
    struct pel_http_answer answer;
    if (pel_http_take_later(client)) {
        return MHD_YES;
    }
    client->phase = PHASE_ANSWER;
    client->deadline_ns = pel_http_after(client->server->limits.http_answer_s);
    describe(client, client->method, &headers, &request);
    if (pel_http_read_later(client, &request)) {
        return MHD_YES;
    }
    struct pel_scene *scene = client->server->context.scene;
    bool gated = pel_scene_gated(scene);
    uint64_t before = pel_scene_state(scene)->revision;
    pel_http_route(&client->server->context, &request, &answer);
    bool changed = pel_scene_state(scene)->revision != before;
    bool edited = gated && changed;
    client->changes = changed || answer.kind == PEL_HTTP_PATCH ||
                      answer.kind == PEL_HTTP_STEP;
    client->of_debrief = answer.debrief;
    g_strlcpy(client->ignored, answer.ignored, sizeof client->ignored);
    answer.profile.who = client->who;
    bool picture = answer.kind == PEL_HTTP_FRAME ||
                   answer.kind == PEL_HTTP_FRAMES ||
                   answer.kind == PEL_HTTP_MJPEG || answer.kind == PEL_HTTP_TS;
    if (picture && strcmp(client->method, "HEAD") == 0) {
        return pel_http_send_head(client, &answer);
    }
    bool stream = answer.kind == PEL_HTTP_MJPEG || answer.kind == PEL_HTTP_TS ||
                  answer.kind == PEL_HTTP_LIVE;
    if (stream && !pel_http_share_stream(client, &answer)) {
        return pel_http_send(client, &answer);
    }
    switch (answer.kind) {
    case PEL_HTTP_FRAME:
        return pel_http_send_frame(client, &answer);
    case PEL_HTTP_FRAMES:
        return pel_http_send_frames(client, &answer);
    case PEL_HTTP_SURFACE:
        return pel_http_send_surface(client, &answer);
    case PEL_HTTP_OPTICS:
        return pel_http_send_optics(client, &answer);
    case PEL_HTTP_SPECTRUM:
        return pel_http_send_spectrum(client, &answer);
    case PEL_HTTP_SOUNDINGS:
        return pel_http_send_soundings(client, &answer);
    case PEL_HTTP_ALMANAC:
        return pel_http_send_almanac(client, &answer);
    case PEL_HTTP_SERIES:
        return pel_http_send_series(client, &answer);
    case PEL_HTTP_MODELS:
        return pel_http_send_models(client, &answer);
    case PEL_HTTP_RECORDINGS:
        return pel_http_send_recordings(client, &answer);
    case PEL_HTTP_EXERCISE:
        return pel_http_send_exercise(client, &answer);
    case PEL_HTTP_PLACE:
        return pel_http_send_place(client, &answer);
    case PEL_HTTP_STEP:
        return pel_http_send_stepped(client, &answer);
    case PEL_HTTP_PATCH:
        return pel_http_send_patched(client, &answer);
    case PEL_HTTP_MJPEG:
    case PEL_HTTP_TS:
        return pel_http_send_stream(client, &answer);
    case PEL_HTTP_HLS:
    case PEL_HTTP_HLS_FILE:
        return pel_http_send_hls(client, &answer);
    case PEL_HTTP_WHEP:
    case PEL_HTTP_WHEP_END:
        return pel_http_send_whep(client, &answer);
    case PEL_HTTP_LIVE:
        return pel_http_send_live(client, &answer);
    case PEL_HTTP_WHOLE:
        break;
    }
    client->server->malformed += answer.status == 400;
    return edited ? pel_http_send_sealed(client, &answer)
                  : pel_http_send(client, &answer);
}

static enum MHD_Result on_request(void *user, struct MHD_Connection *connection,
                                  const char *url, const char *method,
                                  const char *version, const char *data,
                                  size_t *size, void **state)
{
    (void)connection;
    (void)url;
    (void)user;
    struct client *client = *state;
    if (!client || client->phase == PHASE_CLOSED) {
        return MHD_NO;
    }
    client->interim = strcmp(version, "HTTP/1.1") == 0;
    if (client->phase == PHASE_HEADERS) {
        return take_head(client, method);
    }
    if (*size > 0) {
        enum MHD_Result result = take_body(client, data, *size);
        *size = 0;
        return result;
    }
    client->method = method;
    return pel_http_take(client);
}

static struct client *client_of(struct MHD_Connection *connection)
{
    const union MHD_ConnectionInfo *info =
        MHD_get_connection_info(connection, MHD_CONNECTION_INFO_SOCKET_CONTEXT);
    return info ? info->socket_context : NULL;
}

/* The request line is there: its target, as it came. */
static void *on_target(void *user, const char *target,
                       struct MHD_Connection *connection)
{
    (void)user;
    struct client *client = client_of(connection);
    if (client) {
        g_free(client->target);
        g_free(client->authority);
        const char *path = pel_http_split_target(target, &client->authority);
        /* Without a path: of the whole server. */
        client->target = g_strdup_printf(
            "%s%.*s", client->authority && *path != '/' ? "/" : "",
            PEL_HTTP_MAX_TARGET, path);
        client->target_at = target;
        client->version_at = pel_http_head_version(target);
    }
    return client;
}

static void forget_request(struct client *client)
{
    pel_http_call_off(client);
    pel_claim_give(&client->unread);
    g_free(client->target);
    g_free(client->authority);
    client->target = client->authority = NULL;
    client->ignored[0] = '\0';
    client->notice[0] = '\0';
    client->probed = false;
    if (client->body) {
        g_string_free(client->body, TRUE);
        client->body = NULL;
    }
}

/* A request that ended before it was whole. */
static void count_half(const struct client *client)
{
    /* The kernel counts the end of a stream as one byte. */
    bool more = pel_tcp_received(client->fd) > client->consumed + 1;
    if (client->phase == PHASE_BODY ||
        (client->phase == PHASE_HEADERS && more)) {
        client->server->malformed++;
    }
}

static void on_completed(void *user, struct MHD_Connection *connection,
                         void **state, enum MHD_RequestTerminationCode why)
{
    (void)user;
    (void)connection;
    (void)why;
    struct client *client = *state;
    *state = NULL;
    if (!client || client->upgraded) {
        return;
    }
    if (client->phase == PHASE_HEADERS || client->phase == PHASE_BODY) {
        client->server->malformed++; /* its request line came, not its end */
    }
    forget_request(client);
    client->consumed = pel_tcp_received(client->fd);
    if (client->phase != PHASE_CLOSED) {
        client->phase = PHASE_HEADERS;
        client->since_ns = pel_now_ns();
        client->deadline_ns =
            pel_http_after(client->server->limits.http_idle_s);
    }
}

/* --- connections ---------------------------------------------------------- */

static void on_connection(void *user, struct MHD_Connection *connection,
                          void **context,
                          enum MHD_ConnectionNotificationCode what)
{
    struct pel_http_server *server = user;
    if (what == MHD_CONNECTION_NOTIFY_STARTED) {
        struct client *client = g_new0(struct client, 1);
        client->server = server;
        client->connection = connection;
        client->fd = MHD_get_connection_info(connection,
                                             MHD_CONNECTION_INFO_CONNECTION_FD)
                         ->connect_fd;
        const struct sockaddr *address =
            MHD_get_connection_info(connection,
                                    MHD_CONNECTION_INFO_CLIENT_ADDRESS)
                ->client_addr;
        client->source = pel_http_source_of(server, address);
        client->who = pel_http_first_who(server);
        client->first = true;
        pel_http_watch_hangup(client);
        client->since_ns = pel_now_ns();
        client->deadline_ns = pel_http_after(server->limits.http_header_s);
        g_ptr_array_add(server->clients, client);
        *context = client;
        return;
    }
    struct client *client = *context;
    *context = NULL;
    if (client) {
        pel_http_end_live(client);
        count_half(client);
        forget_request(client);
        pel_http_unwatch_hangup(client);
        g_ptr_array_remove_fast(server->clients, client);
        g_free(client);
    }
}

void pel_http_shut(struct client *client)
{
    count_half(client);
    client->phase = PHASE_CLOSED;
    pel_http_call_off(client);
    pel_claim_give(&client->unread);
    pel_http_end_live(client);
    shutdown(client->fd, SHUT_RDWR);
    pel_http_resume(client);
    pel_http_kick(client->server);
}

bool pel_http_server_accept(struct pel_http_server *server, int fd,
                            const struct sockaddr *address, socklen_t size)
{
    struct pel_http_source source = pel_http_source_of(server, address);
    pel_http_share_open(server, &source);
    int on = 1;
    setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
    server->accepted++;
    /* The library closes the socket itself when it refuses it. */
    MHD_add_connection(server->daemon, fd, address, size);
    pel_http_kick(server);
    return true;
}

/* The library does not watch a suspended connection, and misses an end that
 * came together with the last bytes of half a request. Who sends no more may
 * wait for an answer all the same (half a close): pel_http_probe finds out. */
static bool vanished(const struct client *client)
{
    int unread = 0;
    if (client->suspended) {
        bool streams = client->phase == PHASE_STREAM;
        return pel_http_polls(client, streams ? POLLRDHUP : 0);
    }
    return (client->phase == PHASE_HEADERS || client->phase == PHASE_BODY) &&
           pel_http_polls(client, POLLRDHUP) &&
           ioctl(client->fd, FIONREAD, &unread) == 0 && unread == 0;
}

/* The library turns without end over a line of a chunk's size that is longer
 * than its memory: it can neither read on nor give up. */
static void end_stuck(struct pel_http_server *server)
{
    for (guint i = 0; i < server->clients->len; i++) {
        struct client *client = g_ptr_array_index(server->clients, i);
        int unread = 0;
        if ((client->phase != PHASE_HEADERS && client->phase != PHASE_BODY) ||
            client->suspended || ioctl(client->fd, FIONREAD, &unread) != 0 ||
            unread == 0) {
            client->read = 0;
            continue;
        }
        uint64_t read = pel_tcp_received(client->fd) - (uint64_t)unread;
        if (read != client->read) {
            client->read = read;
            continue;
        }
        struct pel_fault fault;
        pel_fault_set(&fault, PEL_ERR_MALFORMED,
                      "a line of the message is longer than %d bytes",
                      MEMORY_BYTES);
        pel_http_head_refuse(client, 400, &fault);
        pel_http_shut(client);
    }
}

/* Ends a client that has left while it waits, so that its places are free. */
void pel_http_left(struct client *client)
{
    client->gone = true;
    if (!client->suspended || client->phase == PHASE_CLOSED) {
        return;
    }
    if (vanished(client)) {
        client->server->vanished++;
        pel_http_shut(client);
    } else if (!client->probed) {
        pel_http_probe_soon(client->server);
    }
}

void pel_http_server_revoke(struct pel_http_server *server)
{
    for (guint i = 0; i < server->clients->len; i++) {
        struct client *client = g_ptr_array_index(server->clients, i);
        if (client->phase != PHASE_CLOSED &&
            !pel_token_holds(server->context.token, &client->who)) {
            server->evicted++;
            pel_http_shut(client);
        }
    }
    pel_whep_revoke(server->whep, server->context.token);
}

static gboolean sweep(gpointer user)
{
    PEL_WATCH("http");
    struct pel_http_server *server = user;
    int64_t now = pel_now_ns();
    for (guint i = 0; i < server->clients->len; i++) {
        struct client *client = g_ptr_array_index(server->clients, i);
        if (client->phase == PHASE_CLOSED) {
            continue;
        }
        if (vanished(client)) {
            server->vanished += client->suspended;
            pel_http_shut(client);
        } else if (client->phase != PHASE_STREAM && now > client->deadline_ns) {
            bool idle = client->phase == PHASE_HEADERS && !client->first &&
                        pel_tcp_received(client->fd) == client->consumed;
            server->timeouts += !idle;
            pel_http_shut(client);
        }
    }
    return G_SOURCE_CONTINUE;
}

/* --- the library in the main loop ----------------------------------------- */

static gboolean source_prepare(GSource *source, gint *timeout_ms)
{
    struct daemon_source *self = (struct daemon_source *)source;
    MHD_UNSIGNED_LONG_LONG ms = 0;
    bool timed = MHD_get_timeout(self->server->daemon, &ms) == MHD_YES;
    *timeout_ms = timed ? (gint)MIN(ms, 60000) : -1;
    self->due_us =
        timed ? g_source_get_time(source) + *timeout_ms * 1000LL : G_MAXINT64;
    return self->server->run_again || *timeout_ms == 0;
}

static gboolean source_check(GSource *source)
{
    struct daemon_source *self = (struct daemon_source *)source;
    return self->server->run_again ||
           g_source_query_unix_fd(source, self->tag) != 0 ||
           g_source_get_time(source) >= self->due_us;
}

static gboolean source_dispatch(GSource *source, GSourceFunc callback,
                                gpointer user)
{
    PEL_WATCH("http");
    (void)callback;
    (void)user;
    struct daemon_source *self = (struct daemon_source *)source;
    struct pel_http_server *server = self->server;
    MHD_UNSIGNED_LONG_LONG ms = 0;
    server->run_again = false;
    MHD_run(server->daemon);
    bool at_once = MHD_get_timeout(server->daemon, &ms) == MHD_YES && ms == 0;
    server->turns_at_once = at_once ? server->turns_at_once + 1 : 0;
    if (server->turns_at_once >= TURNS_AT_ONCE) {
        server->turns_at_once = 0;
        end_stuck(server);
    }
    return G_SOURCE_CONTINUE;
}

/* The library writes the head of its own answer to such a request twice. It
 * speaks of the matter first: then the answer is ours, and it finds the
 * connection shut. */
static void refuse_length(struct pel_http_server *server)
{
    struct pel_fault fault;
    pel_fault_set(&fault, PEL_ERR_MALFORMED,
                  "Content-Length must be a number, given once");
    for (guint i = 0; i < server->clients->len; i++) {
        struct client *client = g_ptr_array_index(server->clients, i);
        if (client->phase == PHASE_HEADERS &&
            pel_http_head_is_in(client->connection)) {
            pel_http_head_refuse(client, 400, &fault);
            pel_http_shut(client);
            return;
        }
    }
}

static void on_library_log(void *user, const char *format, va_list args)
{
    char text[256];
    vsnprintf(text, sizeof text, format, args);
    text[strcspn(text, "\n")] = '\0';
    if (strstr(text, "Content-Length' header. Closing")) {
        refuse_length(user);
    }
    pel_debug("NET-021", "libmicrohttpd: %s", text);
}

static struct MHD_Daemon *start_library(struct pel_http_server *server)
{
    return MHD_start_daemon(
        MHD_USE_EPOLL | MHD_ALLOW_SUSPEND_RESUME | MHD_ALLOW_UPGRADE |
            MHD_USE_NO_LISTEN_SOCKET | MHD_USE_ERROR_LOG,
        0, NULL, NULL, on_request, server, MHD_OPTION_EXTERNAL_LOGGER,
        on_library_log, server, MHD_OPTION_CONNECTION_LIMIT,
        server->limits.http_connections + PEL_HTTP_RESERVE +
            PEL_BOUND_HTTP_NEWCOMERS + CLOSING_ROOM,
        MHD_OPTION_CONNECTION_TIMEOUT, (unsigned)IDLE_S,
        MHD_OPTION_CONNECTION_MEMORY_LIMIT, (size_t)MEMORY_BYTES,
        /* pel_http_admit asks for the one Host, and says so as a problem. */
        MHD_OPTION_STRICT_FOR_CLIENT, 0, MHD_OPTION_URI_LOG_CALLBACK, on_target,
        server, MHD_OPTION_NOTIFY_COMPLETED, on_completed, server,
        MHD_OPTION_NOTIFY_CONNECTION, on_connection, server,
        MHD_OPTION_SIGPIPE_HANDLED_BY_APP, 1, MHD_OPTION_END);
}

enum pel_err pel_http_server_create(const struct pel_net_limits *limits,
                                    const struct pel_http_context *context,
                                    const struct pel_whep_places *whep,
                                    struct pel_frames *frames,
                                    struct pel_http_server **out,
                                    struct pel_fault *fault)
{
    static GSourceFuncs functions = {
        source_prepare, source_check, source_dispatch, NULL, NULL, NULL
    };
    struct pel_http_server *server = g_new0(struct pel_http_server, 1);
    server->limits = *limits;
    server->context = *context;
    server->frames = frames;
    server->clients = g_ptr_array_new();
    server->daemon = start_library(server);
    if (!server->daemon) {
        g_ptr_array_free(server->clients, TRUE);
        g_free(server);
        return pel_fault_set(fault, PEL_ERR_INTERNAL,
                             "libmicrohttpd does not start");
    }
    int epoll =
        MHD_get_daemon_info(server->daemon, MHD_DAEMON_INFO_EPOLL_FD)->epoll_fd;
    server->source = (struct daemon_source *)g_source_new(
        &functions, sizeof *server->source);
    server->source->server = server;
    server->source->tag =
        g_source_add_unix_fd(&server->source->source, epoll, G_IO_IN);
    g_source_attach(&server->source->source, NULL);
    server->sweeper = g_timeout_add(SWEEP_MS, sweep, server);
    pel_http_begin_later(server);
    pel_http_watch_hangups(server);
    server->hls = pel_hls_create(frames);
    server->whep = pel_whep_create(frames, whep);
    *out = server;
    return PEL_OK;
}

void pel_http_server_destroy(struct pel_http_server *server)
{
    if (!server) {
        return;
    }
    server->closing = true;
    g_source_remove(server->sweeper);
    g_source_destroy(&server->source->source);
    g_source_unref(&server->source->source);
    /* The library may not be stopped while connections are suspended. */
    for (guint i = 0; i < server->clients->len; i++) {
        pel_http_shut(g_ptr_array_index(server->clients, i));
    }
    MHD_run(server->daemon);
    MHD_stop_daemon(server->daemon);
    pel_http_end_later(server);
    pel_http_unwatch_hangups(server);
    pel_hls_destroy(server->hls);
    pel_whep_destroy(server->whep);
    g_ptr_array_free(server->clients, TRUE);
    g_free(server);
}

bool pel_http_server_starved(struct pel_http_server *server)
{
    return pel_http_share_starved(server);
}

void pel_http_server_ready(struct pel_http_server *server)
{
    server->context.ready = true;
}

void pel_http_server_stop(struct pel_http_server *server)
{
    server->context.stopping = true;
}

unsigned pel_http_server_in_flight(const struct pel_http_server *server)
{
    unsigned count = 0;
    for (guint i = 0; i < server->clients->len; i++) {
        const struct client *each = g_ptr_array_index(server->clients, i);
        count += each->phase == PHASE_BODY || each->phase == PHASE_ANSWER;
    }
    return count;
}

static void counter(struct pel_metrics_page *page, const char *name,
                    const char *help, const char *labels, uint64_t value)
{
    pel_metric(page, name, PEL_METRIC_COUNTER, help, labels, (double)value);
}

void pel_http_server_collect(const struct pel_http_server *server,
                             struct pel_metrics_page *page)
{
    for (int status = 0; status < PEL_HTTP_STATUS_MAX; status++) {
        char label[32];
        snprintf(label, sizeof label, "code=\"%d\"", status);
        if (server->answers[status] > 0 || status == 200 || status == 400) {
            counter(page, "pelagos_http_responses_total",
                    "Answers to HTTP requests.", label,
                    server->answers[status]);
        }
    }
    pel_metric(page, "pelagos_http_connections", PEL_METRIC_GAUGE,
               "HTTP connections open.", NULL, server->clients->len);
    counter(page, "pelagos_http_accepted_total", "HTTP connections accepted.",
            NULL, server->accepted);
    counter(page, "pelagos_http_evicted_total",
            "Idle or half-sent HTTP connections closed to make room.", NULL,
            server->evicted);
    counter(page, "pelagos_http_vanished_total",
            "HTTP clients that left before their answer.", NULL,
            server->vanished);
    counter(page, "pelagos_refused_total", "Clients turned away at a limit.",
            "input=\"http\"", server->refused);
    counter(page, "pelagos_malformed_total", "Messages that could not be read.",
            "input=\"http\"", server->malformed);
    counter(page, "pelagos_timeouts_total",
            "Clients closed for being too slow.", "input=\"http\"",
            server->timeouts);
    pel_metric(page, "pelagos_mjpeg_viewers", PEL_METRIC_GAUGE,
               "Motion-JPEG viewers.", NULL, server->mjpeg.viewers);
    counter(page, "pelagos_mjpeg_frames_sent_total",
            "Pictures sent to Motion-JPEG viewers.", NULL, server->mjpeg.sent);
    counter(page, "pelagos_mjpeg_frames_dropped_total",
            "Pictures that slow Motion-JPEG viewers missed.", NULL,
            server->mjpeg.dropped);
    counter(page, "pelagos_mjpeg_sent_bytes_total",
            "Bytes sent to Motion-JPEG viewers.", NULL, server->mjpeg.bytes);
    pel_live_collect(&server->live, page);
    pel_metric(page, "pelagos_ts_viewers", PEL_METRIC_GAUGE,
               "Readers of MPEG transport streams.", NULL, server->ts.viewers);
    counter(page, "pelagos_ts_frames_sent_total",
            "Pictures for readers of MPEG transport streams.", NULL,
            server->ts.sent);
    counter(page, "pelagos_ts_sent_bytes_total", "Bytes sent to them.", NULL,
            server->ts.bytes);
    counter(page, "pelagos_ts_starved_total", "Times that one fell behind.",
            NULL, server->ts.starved);
    pel_hls_collect(server->hls, page);
    pel_whep_collect(server->whep, page);
}
