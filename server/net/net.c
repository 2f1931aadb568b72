#include "net/net.h"

#include <malloc.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <unistd.h>

#include <glib.h>

#include "base/clock.h"
#include "base/log.h"
#include "base/watch.h"
#include "bounds.h"
#include "net/http_server.h"
#include "net/listener.h"
#include "net/rtsp.h"
#include "net/session.h"
#include "net/tls.h"
#include "net/token.h"

#define DRAIN_LOOK_MS 20

struct pel_net {
    struct pel_net_options options;
    struct pel_scene *scene;
    struct pel_frames *frames;
    struct pel_token *token; /* NULL: none is asked for */
    struct pel_tls *tls;     /* NULL: TCP and RTSP are plain */
    struct pel_http_server *http;
    struct pel_sessions *sessions;
    struct pel_series *series;
    struct pel_claims *claims;
    struct pel_rtsp *rtsp; /* NULL: off */
    struct pel_listener *http_listener, *tcp_listener, *unix_listener;
    uint16_t http_port, tcp_port;
    bool joined; /* the metrics */
    struct {
        guint timer; /* 0: not draining */
        int64_t end_ns;
        void (*done)(void *user);
        void *user;
    } drain;
};

void pel_net_limits_default(struct pel_net_limits *limits)
{
    *limits = (struct pel_net_limits){
        .http_connections = PEL_BOUND_HTTP_CONNECTIONS,
        .http_per_source = PEL_BOUND_HTTP_PER_SOURCE,
        .http_per_loopback = PEL_BOUND_HTTP_PER_LOOPBACK,
        .http_body_bytes = PEL_BOUND_HTTP_BODY_BYTES,
        .http_header_s = PEL_BOUND_HTTP_HEADER_S,
        .http_body_s = PEL_BOUND_HTTP_BODY_S,
        .http_idle_s = 15.0,
        .http_stall_s = 30.0,
        .http_answer_s = PEL_BOUND_HTTP_ANSWER_S,
        .sessions = PEL_BOUND_SESSIONS,
        .session_requests = PEL_BOUND_SESSION_REQUESTS,
        .session_message_bytes = PEL_BOUND_SESSION_MESSAGE_BYTES,
        .session_output_bytes = PEL_BOUND_SESSION_OUTPUT_BYTES,
        .session_login_s = PEL_BOUND_SESSION_LOGIN_S,
        .session_message_s = PEL_BOUND_SESSION_MESSAGE_S,
        .session_stall_s = PEL_BOUND_SESSION_STALL_S,
    };
}

static bool accept_http(void *user, int fd, const struct sockaddr *address,
                        socklen_t size)
{
    struct pel_net *net = user;
    return pel_http_server_accept(net->http, fd, address, size);
}

static bool starved_http(void *user)
{
    struct pel_net *net = user;
    return pel_http_server_starved(net->http);
}

static bool starved_tcp(void *user)
{
    struct pel_net *net = user;
    return pel_sessions_starved(net->sessions);
}

static bool accept_tcp(void *user, int fd, const struct sockaddr *address,
                       socklen_t size)
{
    (void)address;
    (void)size;
    struct pel_net *net = user;
    if (!net->tls) {
        return pel_sessions_accept(net->sessions, fd, PEL_TRANSPORT_TCP);
    }
    int plain =
        pel_tls_serve(net->tls, fd, false, net->options.limits.session_login_s,
                      net->options.limits.session_stall_s);
    if (plain >= 0 &&
        !pel_sessions_accept(net->sessions, plain, PEL_TRANSPORT_TCP)) {
        close(plain); /* the refusal still goes out */
    }
    return true;
}

static bool accept_unix(void *user, int fd, const struct sockaddr *address,
                        socklen_t size)
{
    (void)address;
    (void)size;
    struct pel_net *net = user;
    return pel_sessions_accept(net->sessions, fd, PEL_TRANSPORT_UNIX);
}

/* --- metrics -------------------------------------------------------------- */

/* When this process began, UTC; 0: not known. */
static double process_start_s(void)
{
    static double start_s;
    char text[1024];
    double up_s = 0, ticks = 0;
    FILE *stat = start_s > 0 ? NULL : fopen("/proc/self/stat", "re");
    FILE *uptime = stat ? fopen("/proc/uptime", "re") : NULL;
    /* The name in brackets may hold anything; the start is the 20th after. */
    char *at =
        stat && fgets(text, sizeof text, stat) ? strrchr(text, ')') : NULL;
    for (int i = 0; at && i < 20; i++) {
        at = strchr(at + 1, ' ');
    }
    ticks = at ? strtod(at, NULL) : 0;
    if (uptime && ticks > 0 && fscanf(uptime, "%lf", &up_s) == 1) {
        start_s = (double)g_get_real_time() * 1e-6 - up_s +
                  ticks / (double)sysconf(_SC_CLK_TCK);
    }
    if (uptime) {
        fclose(uptime);
    }
    if (stat) {
        fclose(stat);
    }
    return start_s;
}

static void collect_process(struct pel_metrics_page *page)
{
    long pages = 0, resident = 0;
    FILE *file = fopen("/proc/self/statm", "re");
    if (file && fscanf(file, "%ld %ld", &pages, &resident) == 2) {
        pel_metric(page, "process_resident_memory_bytes", PEL_METRIC_GAUGE,
                   "Resident memory.", NULL,
                   (double)resident * (double)sysconf(_SC_PAGESIZE));
    }
    if (file) {
        fclose(file);
    }
    pel_metric(page, "process_virtual_memory_bytes", PEL_METRIC_GAUGE,
               "Virtual memory.", NULL,
               (double)pages * (double)sysconf(_SC_PAGESIZE));
    pel_metric(page, "process_start_time_seconds", PEL_METRIC_GAUGE,
               "When the process began, in seconds since 1970, UTC.", NULL,
               process_start_s());
    struct rlimit descriptors;
    if (getrlimit(RLIMIT_NOFILE, &descriptors) == 0) {
        pel_metric(page, "process_max_fds", PEL_METRIC_GAUGE,
                   "File descriptors that may be open.", NULL,
                   (double)descriptors.rlim_cur);
    }
    struct mallinfo2 heap = mallinfo2();
    pel_metric(page, "process_heap_bytes", PEL_METRIC_GAUGE,
               "Memory that malloc has given out: without what it keeps.", NULL,
               (double)(heap.uordblks + heap.hblkhd));
    struct rusage use;
    if (getrusage(RUSAGE_SELF, &use) == 0) {
        double busy =
            (double)(use.ru_utime.tv_sec + use.ru_stime.tv_sec) +
            1e-6 * (double)(use.ru_utime.tv_usec + use.ru_stime.tv_usec);
        pel_metric(page, "process_cpu_seconds_total", PEL_METRIC_COUNTER,
                   "Processor time used.", NULL, busy);
    }
    GDir *dir = g_dir_open("/proc/self/fd", 0, NULL);
    double open = -1; /* the directory itself */
    while (dir && g_dir_read_name(dir)) {
        open++;
    }
    if (dir) {
        g_dir_close(dir);
        pel_metric(page, "process_open_fds", PEL_METRIC_GAUGE,
                   "Open file descriptors.", NULL, open);
    }
}

static void collect(void *user, struct pel_metrics_page *page)
{
    const struct pel_net *net = user;
    const Pelagos__State *state = pel_scene_state(net->scene);
    pel_metric(page, "pelagos_info", PEL_METRIC_GAUGE, "The version that runs.",
               "version=\"" PEL_VERSION "\"", 1);
    pel_metric(page, "pelagos_revision", PEL_METRIC_GAUGE,
               "Edits accepted to the state.", NULL, (double)state->revision);
    pel_metric(page, "pelagos_simulated_time_seconds", PEL_METRIC_GAUGE,
               "Simulated time.", NULL, pel_scene_time(net->scene));
    pel_metric(page, "pelagos_starved_total", PEL_METRIC_COUNTER,
               "Clients turned away for want of file descriptors.", NULL,
               (double)(pel_listener_starved(net->http_listener) +
                        pel_listener_starved(net->tcp_listener) +
                        pel_listener_starved(net->unix_listener)));
    collect_process(page);
    pel_sessions_collect(net->sessions, page);
    pel_series_collect(net->series, page);
    pel_claims_collect(net->claims, page);
    if (net->http) {
        pel_http_server_collect(net->http, page);
    }
    if (net->rtsp) {
        pel_rtsp_collect(net->rtsp, page);
    }
}

static void on_commit(void *user)
{
    struct pel_net *net = user;
    if (net->sessions) {
        pel_sessions_changed(net->sessions);
    }
    if (net->rtsp) {
        pel_rtsp_changed(net->rtsp);
    }
}

/* --- life ----------------------------------------------------------------- */

static enum pel_err of_option(const char *option, enum pel_err err,
                              struct pel_fault *fault)
{
    if (err != PEL_OK && fault) {
        g_autofree char *why = g_strdup(fault->message);
        (void)pel_fault_set(fault, err, "%s: %s", option, why);
    }
    return err;
}

static enum pel_err load_secrets(struct pel_net *net, struct pel_fault *fault)
{
    const struct pel_net_options *o = &net->options;
    enum pel_err err = PEL_OK;
    if (o->token_path) {
        err = of_option("--token-file",
                        pel_token_create(o->token_path, &net->token, fault),
                        fault);
    }
    if (err == PEL_OK && o->tls_cert_path) {
        err = of_option(
            "--tls-cert, --tls-key",
            pel_tls_create(o->tls_cert_path, o->tls_key_path, &net->tls, fault),
            fault);
    }
    return err;
}

/* Ends everything that was begun with a token that has been taken back. */
static void end_revoked(struct pel_net *net)
{
    pel_sessions_revoke(net->sessions);
    if (net->http) {
        pel_http_server_revoke(net->http);
    }
    if (net->rtsp) {
        pel_rtsp_revoke(net->rtsp);
    }
}

void pel_net_reload(struct pel_net *net)
{
    struct pel_fault fault;
    if (net->token && pel_token_reload(net->token, &fault) != PEL_OK) {
        pel_error("NET-008", "the old token stays in use: %s", fault.message);
    } else if (net->token) {
        end_revoked(net);
    }
    if (net->tls && pel_tls_reload(net->tls, &fault) != PEL_OK) {
        pel_error("NET-009", "the old certificate stays in use: %s",
                  fault.message);
    }
}

static enum pel_err listen_all(struct pel_net *net, struct pel_fault *fault)
{
    const struct pel_net_options *o = &net->options;
    const bool remote = o->allow_remote && net->token;
    enum pel_err err = PEL_OK;
    if (o->http_address) {
        err = pel_listener_tcp("--http", o->http_address, o->http_port, remote,
                               accept_http, net, &net->http_listener, fault);
    }
    if (err == PEL_OK && net->http_listener) {
        pel_listener_on_starved(net->http_listener, starved_http);
    }
    if (err == PEL_OK && o->tcp_address) {
        err = pel_listener_tcp("--tcp", o->tcp_address, o->tcp_port, remote,
                               accept_tcp, net, &net->tcp_listener, fault);
    }
    if (err == PEL_OK && net->tcp_listener) {
        pel_listener_on_starved(net->tcp_listener, starved_tcp);
    }
    if (err == PEL_OK && o->unix_path) {
        err = pel_listener_unix(o->unix_path, accept_unix, net,
                                &net->unix_listener, fault);
    }
    if (err == PEL_OK && o->rtsp_address) {
        struct pel_rtsp_options rtsp = {
            .address = o->rtsp_address,
            .port = o->rtsp_port,
            .allow_remote = remote,
            .token = net->token,
            .tls = net->tls,
        };
        err =
            pel_rtsp_create(&rtsp, net->scene, net->frames, &net->rtsp, fault);
    }
    net->http_port = pel_listener_port(net->http_listener);
    net->tcp_port = pel_listener_port(net->tcp_listener);
    return err;
}

static void log_addresses(const struct pel_net *net)
{
    const struct pel_net_options *o = &net->options;
    bool six = o->http_address && strchr(o->http_address, ':');
    if (o->http_address) {
        pel_info("NET-002", "HTTP on http://%s%s%s:%u/", six ? "[" : "",
                 o->http_address, six ? "]" : "", net->http_port);
    }
    if (o->tcp_address) {
        pel_info("NET-003", "protobuf on %s %s port %u",
                 net->tls ? "TLS" : "TCP", o->tcp_address, net->tcp_port);
    }
    if (o->rtsp_address) {
        pel_info("NET-006", "RTSP on rtsp%s://%s%s%s:%u/VIEW",
                 net->tls ? "s" : "", strchr(o->rtsp_address, ':') ? "[" : "",
                 o->rtsp_address, strchr(o->rtsp_address, ':') ? "]" : "",
                 pel_rtsp_port(net->rtsp));
    }
    if (net->token) {
        pel_info("NET-007", "clients must give a token of %s", o->token_path);
    }
    if (o->unix_path) {
        pel_info("NET-004", "protobuf on %s", o->unix_path);
    }
}

static bool is_any(const char *address)
{
    return strcmp(address, "0.0.0.0") == 0 || strcmp(address, "::") == 0;
}

enum pel_err pel_net_create(const struct pel_net_options *options,
                            struct pel_scene *scene, struct pel_frames *frames,
                            struct pel_net **out, struct pel_fault *fault)
{
    struct pel_net *net = g_new0(struct pel_net, 1);
    net->options = *options;
    net->scene = scene;
    net->frames = frames;
    enum pel_err err = load_secrets(net, fault);
    net->sessions = pel_sessions_create(&options->limits, scene, frames,
                                        options->debrief, net->token);
    pel_sessions_exercises(net->sessions, options->exercises);
    pel_sessions_cluster(net->sessions, options->cluster);
    net->claims = pel_claims_create();
    pel_sessions_claims(net->sessions, net->claims);
    net->series = pel_series_create(scene, frames, net->claims);
    pel_sessions_series(net->sessions, net->series);
    if (err == PEL_OK && options->http_address) {
        struct pel_http_context context = {
            .scene = scene,
            .frames = frames,
            .debrief = options->debrief,
            .exercises = options->exercises,
            .cluster = options->cluster,
            .series = net->series,
            .metrics = options->metrics,
            .hosts = options->http_hosts,
            .origins = options->http_origins,
            .proxies = options->http_proxies,
            .token = net->token,
            .claims = net->claims,
            .body_limit = options->limits.http_body_bytes,
        };
        const struct pel_whep_places whep = {
            .address =
                is_any(options->http_address) ? NULL : options->http_address,
            .port_min = options->whep_port_min,
            .port_max = options->whep_port_max,
            .servers = options->whep_servers,
            .peers = options->whep_peers,
        };
        err = pel_http_server_create(&options->limits, &context, &whep, frames,
                                     &net->http, fault);
    }
    if (err == PEL_OK) {
        err = listen_all(net, fault);
    }
    if (err != PEL_OK) {
        pel_net_destroy(net);
        return err;
    }
    pel_metrics_add(options->metrics, collect, net);
    net->joined = true;
    pel_scene_on_commit(scene, on_commit, net);
    log_addresses(net);
    *out = net;
    return PEL_OK;
}

static void close_listeners(struct pel_net *net)
{
    pel_listener_destroy(net->http_listener);
    pel_listener_destroy(net->tcp_listener);
    pel_listener_destroy(net->unix_listener);
    net->http_listener = net->tcp_listener = net->unix_listener = NULL;
}

static gboolean drain(gpointer user)
{
    PEL_WATCH("service");
    struct pel_net *net = user;
    bool idle = pel_sessions_in_flight(net->sessions) == 0 &&
                (!net->http || pel_http_server_in_flight(net->http) == 0);
    if (!idle && pel_now_ns() < net->drain.end_ns) {
        return G_SOURCE_CONTINUE;
    }
    net->drain.timer = 0;
    net->drain.done(net->drain.user);
    return G_SOURCE_REMOVE;
}

void pel_net_ready(struct pel_net *net)
{
    if (net->http) {
        pel_http_server_ready(net->http);
    }
}

void pel_net_drain(struct pel_net *net, int within_ms, void (*done)(void *user),
                   void *user)
{
    close_listeners(net);
    pel_sessions_stop(net->sessions);
    if (net->rtsp) {
        pel_rtsp_stop(net->rtsp);
    }
    if (net->http) {
        pel_http_server_stop(net->http);
    }
    net->drain.done = done;
    net->drain.user = user;
    net->drain.end_ns = pel_now_ns() + within_ms * INT64_C(1000000);
    net->drain.timer = g_timeout_add(DRAIN_LOOK_MS, drain, net);
}

void pel_net_destroy(struct pel_net *net)
{
    if (!net) {
        return;
    }
    close_listeners(net);
    if (net->drain.timer != 0) {
        g_source_remove(net->drain.timer);
    }
    if (net->joined) {
        pel_metrics_remove(net->options.metrics, collect, net);
    }
    pel_http_server_destroy(net->http);
    pel_rtsp_destroy(net->rtsp);
    net->rtsp = NULL;
    pel_sessions_destroy(net->sessions);
    pel_series_destroy(net->series);
    pel_claims_destroy(net->claims);
    pel_tls_destroy(net->tls);
    pel_token_destroy(net->token);
    g_free(net);
}

uint16_t pel_net_http_port(const struct pel_net *net)
{
    return net->http_port;
}

uint16_t pel_net_tcp_port(const struct pel_net *net)
{
    return net->tcp_port;
}
