#include "bridges/modbus.h"

#include <errno.h>
#include <fcntl.h>
#include <glib-unix.h>
#include <math.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "base/clock.h"
#include "base/log.h"
#include "base/metrics.h"
#include "base/watch.h"
#include "bounds.h"
#include "bridges/endpoint.h"
#include "bridges/modbus_adu.h"
#include "bridges/modbus_rtu.h"
#include "bridges/modbus_units.h"
#include "scene/scene.h"

#define MS 1000000LL
#define SWEEP_MS 100
/* A client that takes no answer goes. */
#define STALL_NS (5000 * MS)
/* One idle for so long gives way to a new client when all are taken. */
#define IDLE_NS (60000 * MS)
#define CHUNK 256
/* The shortest request has 8 bytes, of RTU 4: CHUNK of them, and one begun
 * before. */
#define MAX_ANSWERS ((CHUNK / 4 + 1) * PEL_MODBUS_MAX_ADU)

struct pel_modbus_session {
    struct pel_modbus *modbus;
    uint8_t adu[PEL_MODBUS_MAX_ADU];
    size_t used;
    int64_t since_ns; /* first byte of the ADU at hand */
};

struct client {
    struct pel_modbus_session session;
    int fd;
    guint source; /* 0: held */
    bool held;    /* neither answered nor read until commits are in effect */
    int64_t active_ns;
    uint8_t out[MAX_ANSWERS];
    size_t out_size, out_sent;
};

struct pel_modbus {
    struct pel_modbus_options options;
    struct pel_scene *scene;
    struct pel_allow allow;
    struct unit {
        struct pel_modbus_map map;
        enum pel_modbus_source source;
        int64_t heartbeat_ns;
    } units[PEL_MODBUS_MAX_UNITS];
    size_t unit_count;
    Pelagos__Patch *safe; /* NULL: nothing but the ship is stopped */
    struct pel_modbus_responder responder;
    struct pel_modbus_counters counters;
    int fd, reserve_fd;
    uint16_t port;
    guint accept_source, sweep_source;
    GPtrArray *clients; /* struct client */
};

struct pel_modbus_options pel_modbus_default_options(void)
{
    return (struct pel_modbus_options){
        .listen = "127.0.0.1:1502",
        .order = PEL_MODBUS_ABCD,
        .units = "any",
        .max_clients = PEL_BOUND_MODBUS_CLIENTS,
        .request_ms = 5000,
        .heartbeat_ms = 1000,
        .extrapolate_ms = 5000,
        .safe = "",
    };
}

/* --- the sources' heartbeats -------------------------------------------- */

static const char *unit_name(const struct unit *u, char out[12])
{
    if (u->map.unit.number < 0) {
        return "any";
    }
    snprintf(out, 12, "%d", u->map.unit.number);
    return out;
}

static void report_stale(struct pel_modbus *m)
{
    bool stale = false;
    for (size_t i = 0; i < m->unit_count; i++) {
        stale = stale || m->units[i].source >= PEL_MODBUS_STALE;
    }
    pel_scene_set_stale(m->scene, PEL_STALE_MODBUS, stale);
}

static bool has_view(const Pelagos__State *state, const char *name)
{
    bool has = false;
    for (size_t i = 0; i < state->n_views && !has; i++) {
        has = strcmp(state->views[i]->name, name) == 0;
    }
    return has;
}

/* Safe values make no camera: a misspelt one would never be noticed. */
static enum pel_err need_views(const Pelagos__State *state,
                               const Pelagos__Patch *safe,
                               struct pel_fault *fault)
{
    const Pelagos__State *to = safe->state;
    for (size_t i = 0; to && i < to->n_views; i++) {
        if (!has_view(state, to->views[i]->name)) {
            return pel_fault_set(fault, PEL_ERR_NOT_FOUND,
                                 "there is no view called %.64s; add it to the "
                                 "state, or name another",
                                 to->views[i]->name);
        }
    }
    return PEL_OK;
}

static void on_safe(void *user, enum pel_err err, const struct pel_fault *fault)
{
    (void)user;
    if (err) {
        pel_warn("MBS-009", "the safe values are refused: %s", fault->message);
    }
}

/* The source stays silent: its ship is stopped, and the safe values are set. */
static void hold(struct pel_modbus *m, struct unit *u)
{
    const struct pel_scene_wish wish = { .patch = m->safe, .source = m };
    struct pel_fault fault;
    if (u->map.steers) { /* else another input moves the ship */
        pel_warn("MBS-006", "own ship is stopped at its extrapolated position");
        pel_modbus_map_stop_ship(&u->map);
    }
    if (m->safe && need_views(pel_scene_state(m->scene), m->safe, &fault)) {
        on_safe(NULL, fault.code, &fault);
    } else if (m->safe) {
        pel_scene_submit(m->scene, &wish, on_safe, NULL);
    }
}

static void watch(struct pel_modbus *m, struct unit *u, int64_t now_ns)
{
    enum pel_modbus_source before = u->source;
    char name[12];
    if (u->map.heard) {
        u->map.heard = false;
        u->heartbeat_ns = now_ns;
        m->counters.heartbeats++;
        if (u->source != PEL_MODBUS_LIVE) {
            pel_info("MBS-004", "the source of Modbus unit %s is alive",
                     unit_name(u, name));
        }
        u->source = PEL_MODBUS_LIVE;
    }
    int64_t silent = now_ns - u->heartbeat_ns - m->options.heartbeat_ms * MS;
    if (u->source == PEL_MODBUS_LIVE && silent > 0) {
        pel_warn("MBS-005",
                 "the source of Modbus unit %s is stale: no heartbeat for %d "
                 "ms; own ship is extrapolated for %d ms",
                 unit_name(u, name), m->options.heartbeat_ms,
                 m->options.extrapolate_ms);
        u->source = PEL_MODBUS_STALE;
        m->counters.stale++;
    }
    if (u->source == PEL_MODBUS_STALE &&
        silent > m->options.extrapolate_ms * MS) {
        u->source = PEL_MODBUS_HELD;
        hold(m, u);
    }
    if (u->source != before) {
        report_stale(m);
    }
}

static void refresh_inputs(struct pel_modbus *m, struct unit *u, int64_t now_ns)
{
    struct pel_modbus_inputs *in = &u->map.inputs;
    uint64_t refused = 0;
    for (size_t i = 0; i < G_N_ELEMENTS(m->counters.exceptions); i++) {
        refused += m->counters.exceptions[i];
    }
    in->status = (struct pel_modbus_status){ 0 };
    if (m->options.status) {
        m->options.status(m->options.user, &in->status);
    }
    in->source = u->source;
    in->clients = m->clients->len;
    in->heartbeat_age_s = u->source == PEL_MODBUS_NEVER
                              ? NAN
                              : (double)(now_ns - u->heartbeat_ns) * 1e-9;
    in->commits = u->map.commits;
    in->refused = refused;
    in->malformed = m->counters.malformed;
}

/* --- a stream of ADUs --------------------------------------------------- */

static struct unit *find_unit(struct pel_modbus *m, unsigned number)
{
    for (size_t i = 0; i < m->unit_count; i++) {
        int ours = m->units[i].map.unit.number;
        if (ours < 0 ? number <= 1 || number == 255
                     : number == (unsigned)ours) {
            return &m->units[i];
        }
    }
    return NULL;
}

static void count_commits(struct pel_modbus *m)
{
    m->counters.commits = m->counters.refused_commits = 0;
    for (size_t i = 0; i < m->unit_count; i++) {
        m->counters.commits += m->units[i].map.commits;
        m->counters.refused_commits += m->units[i].map.refused_commits;
    }
}

static size_t answer_unit(struct pel_modbus_session *s, struct unit *u,
                          uint8_t *answer, enum pel_modbus_exception *code)
{
    struct pel_modbus *m = s->modbus;
    int64_t now_ns = pel_now_ns();
    watch(m, u, now_ns);
    refresh_inputs(m, u, now_ns);
    size_t size = pel_modbus_answer(&m->responder, &u->map, s->adu, s->used,
                                    answer, code);
    watch(m, u, now_ns);
    count_commits(m);
    return size;
}

/* As a unit on a line does: what is for all of them nobody answers, nor what
 * is for one that is not there. */
static size_t answer_frame(struct pel_modbus_session *s, uint8_t *answer)
{
    struct pel_modbus *m = s->modbus;
    enum pel_modbus_exception code = PEL_MODBUS_DONE;
    size_t size = 0;
    s->used = pel_modbus_rtu_to_tcp(s->adu, s->used);
    struct unit *u = s->adu[6] == 0 ? NULL : find_unit(m, s->adu[6]);
    m->counters.requests++;
    if (u) {
        size = pel_modbus_tcp_to_rtu(answer, answer_unit(s, u, answer, &code));
    }
    for (size_t i = 0; i < m->unit_count && s->adu[6] == 0; i++) {
        (void)answer_unit(s, &m->units[i], answer, &code);
    }
    m->counters.wrong_unit += !u && s->adu[6] != 0;
    if (code) {
        m->counters.exceptions[code]++;
    }
    return size;
}

static size_t answer_adu(struct pel_modbus_session *s, uint8_t *answer)
{
    struct pel_modbus *m = s->modbus;
    enum pel_modbus_exception code;
    size_t size;
    m->counters.requests++;
    struct unit *u = find_unit(m, s->adu[6]);
    if (u) {
        size = answer_unit(s, u, answer, &code);
    } else {
        m->counters.wrong_unit++;
        code = PEL_MODBUS_NO_TARGET;
        size = pel_modbus_refuse(&m->responder, s->adu, code, answer);
    }
    if (code) {
        m->counters.exceptions[code]++;
    }
    return size;
}

/* Bytes the ADU at hand has in all, as far as its header is read; 0: it is not
 * Modbus/TCP. */
static size_t adu_size(const struct pel_modbus_session *s)
{
    if (s->used >= 3 && (s->adu[2] != 0 || (s->used > 3 && s->adu[3] != 0))) {
        return 0;
    }
    if (s->used < 6) {
        return 6;
    }
    unsigned length = (unsigned)s->adu[4] << 8 | s->adu[5];
    return length < 2 || length > 254 ? 0 : 6 + length;
}

static enum pel_modbus_frame frame_of(const struct pel_modbus_session *s)
{
    if (s->modbus->options.rtu) {
        return pel_modbus_rtu_frame(s->adu, s->used);
    }
    size_t whole = adu_size(s);
    return whole == 0                      ? PEL_MODBUS_BROKEN
           : s->used < whole || whole == 6 ? PEL_MODBUS_PART
                                           : PEL_MODBUS_WHOLE;
}

long pel_modbus_session_feed(struct pel_modbus_session *s, const uint8_t *bytes,
                             size_t size, uint8_t *answer, size_t answer_size)
{
    size_t written = 0;
    while (size > 0) {
        if (s->used == 0) {
            s->since_ns = pel_now_ns();
        }
        s->adu[s->used++] = *bytes++;
        size--;
        enum pel_modbus_frame frame = frame_of(s);
        if (frame == PEL_MODBUS_BROKEN) {
            s->modbus->counters.malformed++;
            return -1;
        }
        if (frame == PEL_MODBUS_PART) {
            continue;
        }
        uint8_t one[PEL_MODBUS_MAX_ADU];
        size_t length =
            s->modbus->options.rtu ? answer_frame(s, one) : answer_adu(s, one);
        s->used = 0;
        if (length <= answer_size - written) {
            memcpy(answer + written, one, length);
            written += length;
        }
    }
    return (long)written;
}

struct pel_modbus_session *pel_modbus_session_open(struct pel_modbus *modbus)
{
    struct pel_modbus_session *s = g_new0(struct pel_modbus_session, 1);
    s->modbus = modbus;
    return s;
}

void pel_modbus_session_close(struct pel_modbus_session *session)
{
    g_free(session);
}

/* --- clients ------------------------------------------------------------ */

static void close_client(struct client *c)
{
    struct pel_modbus *m = c->session.modbus;
    if (c->source) {
        g_source_remove(c->source);
    }
    close(c->fd);
    g_ptr_array_remove_fast(m->clients, c);
    g_free(c);
}

static gboolean on_client(gint fd, GIOCondition condition, gpointer user);

static bool commits_wait(const struct pel_modbus *m)
{
    bool wait = false;
    for (size_t i = 0; i < m->unit_count; i++) {
        wait = wait || m->units[i].map.waiting > 0;
    }
    return wait;
}

/* Sends what waits; reading goes on once all of it is gone. False: the client
 * was closed. */
static bool flush_client(struct client *c, bool writing)
{
    while (c->out_sent < c->out_size) {
        ssize_t n = send(c->fd, c->out + c->out_sent, c->out_size - c->out_sent,
                         MSG_NOSIGNAL);
        if (n < 0 && errno == EINTR) {
            continue;
        }
        if (n < 0 && errno != EAGAIN) {
            close_client(c);
            return false;
        }
        if (n < 0) {
            break;
        }
        c->out_sent += (size_t)n;
        c->active_ns = pel_now_ns();
    }
    bool waiting = c->out_sent < c->out_size;
    if (!waiting) {
        c->out_size = c->out_sent = 0;
    }
    if (waiting != writing) {
        g_source_remove(c->source);
        c->source =
            g_unix_fd_add(c->fd, waiting ? G_IO_OUT : G_IO_IN, on_client, c);
    }
    return true;
}

/* Answers go out, and more is read, when what they say is in effect. */
static void on_settled(void *user)
{
    struct pel_modbus *m = user;
    count_commits(m);
    for (guint i = m->clients->len; i > 0 && !commits_wait(m); i--) {
        struct client *c = g_ptr_array_index(m->clients, i - 1);
        if (c->held) {
            c->held = false;
            c->active_ns = pel_now_ns();
            c->source = g_unix_fd_add(c->fd, G_IO_IN, on_client, c);
            flush_client(c, false);
        }
    }
}

static gboolean on_client(gint fd, GIOCondition condition, gpointer user)
{
    PEL_WATCH("modbus");
    struct client *c = user;
    guint source = c->source;
    if (c->out_size > 0) {
        bool open = flush_client(c, true);
        return open && c->source == source;
    }
    (void)condition;
    uint8_t chunk[CHUNK];
    ssize_t n = recv(fd, chunk, sizeof chunk, 0);
    if (n < 0 && (errno == EAGAIN || errno == EINTR)) {
        return G_SOURCE_CONTINUE;
    }
    if (n <= 0) {
        close_client(c);
        return G_SOURCE_REMOVE;
    }
    c->active_ns = pel_now_ns();
    long size = pel_modbus_session_feed(&c->session, chunk, (size_t)n, c->out,
                                        sizeof c->out);
    if (size < 0) {
        static struct pel_log_limit limit;
        pel_log_limited(&limit, PEL_LOG_WARNING, "MBS-007",
                        "a Modbus connection was closed: not %s",
                        c->session.modbus->options.rtu ? "Modbus RTU"
                                                       : "Modbus/TCP");
        close_client(c);
        return G_SOURCE_REMOVE;
    }
    c->out_size = (size_t)size;
    if (commits_wait(c->session.modbus)) {
        c->held = true;
        c->source = 0;
        return G_SOURCE_REMOVE;
    }
    bool open = flush_client(c, false);
    return open && c->source == source;
}

/* The client longest idle, if it is idle long enough to give way. */
static struct client *idle_client(struct pel_modbus *m, int64_t now_ns)
{
    struct client *idlest = NULL;
    for (guint i = 0; i < m->clients->len; i++) {
        struct client *c = g_ptr_array_index(m->clients, i);
        if (!idlest || c->active_ns < idlest->active_ns) {
            idlest = c;
        }
    }
    return idlest && now_ns - idlest->active_ns > IDLE_NS ? idlest : NULL;
}

static void add_client(struct pel_modbus *m, int fd,
                       const struct sockaddr *peer)
{
    int64_t now_ns = pel_now_ns();
    bool allowed = pel_allow_has(&m->allow, peer);
    if (allowed && m->clients->len >= (guint)m->options.max_clients) {
        struct client *idle = idle_client(m, now_ns);
        if (idle) {
            close_client(idle);
        }
    }
    if (!allowed || m->clients->len >= (guint)m->options.max_clients) {
        static struct pel_log_limit limit;
        pel_log_limited(&limit, PEL_LOG_WARNING, "MBS-008",
                        "a Modbus client was refused: %s",
                        allowed ? "all connections are taken"
                                : "not in the list of allowed addresses");
        m->counters.refused_clients++;
        close(fd);
        return;
    }
    int yes = 1;
    setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
    struct client *c = g_new0(struct client, 1);
    c->session.modbus = m;
    c->fd = fd;
    c->active_ns = now_ns;
    c->source = g_unix_fd_add(fd, G_IO_IN, on_client, c);
    g_ptr_array_add(m->clients, c);
    m->counters.accepted++;
}

/* With no descriptor left a connection would wait and wake us for ever: the
 * one in reserve takes and closes it. */
static void refuse_without_descriptor(struct pel_modbus *m)
{
    close(m->reserve_fd);
    int fd = accept(m->fd, NULL, NULL);
    if (fd >= 0) {
        close(fd);
        m->counters.refused_clients++;
    }
    m->reserve_fd = open("/dev/null", O_RDONLY | O_CLOEXEC);
}

static gboolean on_accept(gint fd, GIOCondition condition, gpointer user)
{
    PEL_WATCH("modbus");
    (void)condition;
    struct pel_modbus *m = user;
    struct sockaddr_storage peer = { 0 };
    socklen_t size = sizeof peer;
    int client = accept4(fd, (struct sockaddr *)&peer, &size,
                         SOCK_NONBLOCK | SOCK_CLOEXEC);
    if (client >= 0) {
        add_client(m, client, (struct sockaddr *)&peer);
    } else if (errno == EMFILE || errno == ENFILE) {
        refuse_without_descriptor(m);
    }
    return G_SOURCE_CONTINUE;
}

static void close_if_slow(struct pel_modbus *m, struct client *c,
                          int64_t now_ns)
{
    const struct pel_modbus_session *s = &c->session;
    static struct pel_log_limit limit;
    if (s->used > 0 && now_ns - s->since_ns > m->options.request_ms * MS) {
        pel_log_limited(&limit, PEL_LOG_WARNING, "MBS-010",
                        "a Modbus connection was closed: %zu of %zu bytes of a "
                        "request came in %d ms",
                        s->used, adu_size(s), m->options.request_ms);
        m->counters.late++;
        close_client(c);
    } else if (c->out_size > 0 && !c->held &&
               now_ns - c->active_ns > STALL_NS) {
        pel_log_limited(&limit, PEL_LOG_WARNING, "MBS-011",
                        "a Modbus connection was closed: it took no answer for "
                        "%lld ms",
                        STALL_NS / MS);
        m->counters.stalled++;
        close_client(c);
    }
}

static gboolean on_sweep(gpointer user)
{
    PEL_WATCH("modbus");
    struct pel_modbus *m = user;
    int64_t now_ns = pel_now_ns();
    for (size_t i = 0; i < m->unit_count; i++) {
        watch(m, &m->units[i], now_ns);
    }
    for (guint i = m->clients->len; i-- > 0;) {
        close_if_slow(m, g_ptr_array_index(m->clients, i), now_ns);
    }
    return G_SOURCE_CONTINUE;
}

/* --- metrics ------------------------------------------------------------ */

static void collect(void *user, struct pel_metrics_page *page)
{
    const struct pel_modbus *m = user;
    const struct pel_modbus_counters *c = pel_modbus_counters(m);
    const struct {
        const char *name, *help;
        uint64_t value;
    } counters[] = {
        { "pelagos_modbus_connections_total", "Modbus clients taken.",
          c->accepted },
        { "pelagos_modbus_refused_connections_total",
          "Modbus clients not allowed or too many.", c->refused_clients },
        { "pelagos_modbus_requests_total", "Modbus requests.", c->requests },
        { "pelagos_modbus_malformed_total",
          "Modbus connections closed for a bad protocol id or length.",
          c->malformed },
        { "pelagos_modbus_late_total",
          "Modbus connections closed as a request was not whole in 5 s.",
          c->late },
        { "pelagos_modbus_stalled_total",
          "Modbus connections closed as no answer was taken for 5 s.",
          c->stalled },
        { "pelagos_modbus_commits_total", "Changes of the scene by Modbus.",
          c->commits },
        { "pelagos_modbus_refused_commits_total",
          "Commits that the scene refused.", c->refused_commits },
        { "pelagos_modbus_heartbeats_total", "Heartbeats of Modbus sources.",
          c->heartbeats },
        { "pelagos_modbus_stale_total",
          "Times the heartbeat was silent too long.", c->stale },
    };
    for (size_t i = 0; i < G_N_ELEMENTS(counters); i++) {
        pel_metric(page, counters[i].name, PEL_METRIC_COUNTER, counters[i].help,
                   NULL, (double)counters[i].value);
    }
    for (size_t i = 1; i < G_N_ELEMENTS(c->exceptions); i++) {
        char label[32];
        snprintf(label, sizeof label, "code=\"%zu\"", i);
        pel_metric(page, "pelagos_modbus_exceptions_total", PEL_METRIC_COUNTER,
                   "Modbus requests refused, by exception code.", label,
                   (double)c->exceptions[i]);
    }
    pel_metric(page, "pelagos_modbus_clients", PEL_METRIC_GAUGE,
               "Modbus clients connected.", NULL,
               (double)pel_modbus_clients(m));
    for (size_t i = 0; i < m->unit_count; i++) {
        char label[32], name[12];
        snprintf(label, sizeof label, "unit=\"%s\"",
                 unit_name(&m->units[i], name));
        pel_metric(page, "pelagos_modbus_source", PEL_METRIC_GAUGE,
                   "Source of a Modbus unit: 0 no heartbeat yet, 1 live, 2 "
                   "stale, 3 held.",
                   label, m->units[i].source);
    }
}

/* --- life --------------------------------------------------------------- */

static enum pel_err check_options(const struct pel_modbus_options *o,
                                  struct pel_fault *fault)
{
    const struct {
        const char *name;
        int value, minimum, maximum;
    } numbers[] = {
        { "modbus-clients", o->max_clients, 1, 256 },
        { "modbus request_ms", o->request_ms, 1, 60000 },
        { "modbus-heartbeat", o->heartbeat_ms, 100, 60000 },
        { "modbus-extrapolate", o->extrapolate_ms, 0, 60000 },
        { "modbus-order", (int)o->order, PEL_MODBUS_ABCD, PEL_MODBUS_DCBA },
    };
    for (size_t i = 0; i < G_N_ELEMENTS(numbers); i++) {
        if (numbers[i].value < numbers[i].minimum ||
            numbers[i].value > numbers[i].maximum) {
            return pel_fault_set(fault, PEL_ERR_INVALID,
                                 "%s: %d is not in %d..%d", numbers[i].name,
                                 numbers[i].value, numbers[i].minimum,
                                 numbers[i].maximum);
        }
    }
    return PEL_OK;
}

/* The safe values, tried on the scene as it is now. */
static enum pel_err open_safe(struct pel_modbus *m, struct pel_fault *fault)
{
    struct pel_fault why;
    const struct pel_snapshot *safe = NULL;
    enum pel_err err = pel_modbus_safe_read(m->options.safe, &m->safe, &why);
    if (!err && m->safe) {
        err = need_views(pel_scene_state(m->scene), m->safe, &why);
    }
    if (!err && m->safe) {
        err = pel_scene_try_snapshot(m->scene, m->safe, &safe, &why);
        pel_snapshot_unref(safe);
    }
    return err ? pel_fault_set(fault, err, "--modbus-safe: %.240s", why.message)
               : PEL_OK;
}

static enum pel_err open_units(struct pel_modbus *m, struct pel_fault *fault)
{
    struct pel_modbus_unit units[PEL_MODBUS_MAX_UNITS];
    enum pel_err err = pel_modbus_units_read(m->options.units, m->options.order,
                                             units, &m->unit_count, fault);
    for (size_t i = 0; i < m->unit_count && !err; i++) {
        err = pel_modbus_map_init(&m->units[i].map, m->scene, &units[i], fault);
        m->units[i].map.settled = m->options.listen ? on_settled : NULL;
        m->units[i].map.user = m;
        m->units[i].map.exercise.all = m->options.exercises;
    }
    if (!err) {
        err = open_safe(m, fault);
    }
    return err;
}

enum pel_err pel_modbus_create(const struct pel_modbus_options *options,
                               struct pel_scene *scene, struct pel_modbus **out,
                               struct pel_fault *fault)
{
    enum pel_err err = check_options(options, fault);
    if (err) {
        return err;
    }
    struct pel_modbus *m = g_new0(struct pel_modbus, 1);
    m->options = *options;
    m->scene = scene;
    m->fd = -1;
    m->reserve_fd = open("/dev/null", O_RDONLY | O_CLOEXEC);
    m->clients = g_ptr_array_new();
    err = pel_modbus_responder_init(&m->responder, fault);
    if (!err) {
        err = open_units(m, fault);
    }
    if (!err) {
        err = pel_allow_parse(options->allow, &m->allow, fault);
    }
    if (!err && options->listen) {
        err = pel_endpoint_open("modbus", options->listen, options->allow,
                                SOCK_STREAM, &m->fd, &m->port, fault);
    }
    if (err) {
        pel_modbus_destroy(m);
        return err;
    }
    if (m->fd >= 0) {
        m->accept_source = g_unix_fd_add(m->fd, G_IO_IN, on_accept, m);
        pel_info("MBS-001", "%s on %s, port %u",
                 options->rtu ? "Modbus RTU over TCP" : "Modbus/TCP",
                 options->listen, m->port);
    }
    m->sweep_source = g_timeout_add(SWEEP_MS, on_sweep, m);
    if (options->metrics) {
        pel_metrics_add(options->metrics, collect, m);
    }
    *out = m;
    return PEL_OK;
}

void pel_modbus_destroy(struct pel_modbus *m)
{
    if (!m) {
        return;
    }
    for (size_t i = 0; i < m->unit_count; i++) {
        pel_scene_forget(m->scene, &m->units[i].map);
    }
    if (m->sweep_source) {
        g_source_remove(m->sweep_source);
        if (m->options.metrics) {
            pel_metrics_remove(m->options.metrics, collect, m);
        }
    }
    if (m->accept_source) {
        g_source_remove(m->accept_source);
    }
    while (m->clients->len > 0) {
        close_client(g_ptr_array_index(m->clients, 0));
    }
    g_ptr_array_free(m->clients, TRUE);
    pel_modbus_responder_finish(&m->responder);
    if (m->safe) {
        pelagos__patch__free_unpacked(m->safe, NULL);
    }
    if (m->fd >= 0) {
        close(m->fd);
    }
    if (m->reserve_fd >= 0) {
        close(m->reserve_fd);
    }
    g_free(m);
}

const struct pel_modbus_counters *
pel_modbus_counters(const struct pel_modbus *modbus)
{
    return &modbus->counters;
}

size_t pel_modbus_clients(const struct pel_modbus *modbus)
{
    return modbus->clients->len;
}

enum pel_modbus_source pel_modbus_source(const struct pel_modbus *modbus)
{
    return modbus->units[0].source;
}

uint16_t pel_modbus_port(const struct pel_modbus *modbus)
{
    return modbus->port;
}
