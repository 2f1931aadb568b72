#include "net/session.h"

#include <errno.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include <glib.h>

#include "base/clock.h"
#include "base/log.h"
#include "base/urgent.h"
#include "message.h"
#include "net/command.h"
#include "net/session_parts.h"
#include "wire.h"

#define READ_A_TURN 65536
#define MESSAGES_A_TURN 64
/* Above this many bytes waiting, nothing more is read from the session. */
#define OUTPUT_PAUSE 65536
#define LINGER_NS (2 * INT64_C(1000000000))

static const char *const transport_names[] = { "tcp", "unix" };
static const char *const command_names[PEL_SESSION_COMMANDS] = {
    [0] = "none",
    [PELAGOS__REQUEST__COMMAND_GET] = "get",
    [PELAGOS__REQUEST__COMMAND_PATCH] = "patch",
    [PELAGOS__REQUEST__COMMAND_FRAME] = "frame",
    [PELAGOS__REQUEST__COMMAND_FRAMES] = "frames",
    [PELAGOS__REQUEST__COMMAND_SURFACE] = "surface",
    [PELAGOS__REQUEST__COMMAND_STEP] = "step",
    [PELAGOS__REQUEST__COMMAND_WATCH] = "watch",
    [PELAGOS__REQUEST__COMMAND_SPECTRUM] = "spectrum",
    [PELAGOS__REQUEST__COMMAND_OPTICS] = "optics",
    [PELAGOS__REQUEST__COMMAND_MODELS] = "models",
    [PELAGOS__REQUEST__COMMAND_ALMANAC] = "almanac",
    [PELAGOS__REQUEST__COMMAND_RECORDINGS] = "recordings",
    [PELAGOS__REQUEST__COMMAND_RECORDING] = "recording",
    [PELAGOS__REQUEST__COMMAND_DEBRIEF] = "debrief",
    [PELAGOS__REQUEST__COMMAND_EXERCISE] = "exercise",
    [PELAGOS__REQUEST__COMMAND_LOGIN] = "login",
    [PELAGOS__REQUEST__COMMAND_SERIES] = "series",
    [PELAGOS__REQUEST__COMMAND_CLUSTER] = "cluster",
    [PELAGOS__REQUEST__COMMAND_PLACE] = "place",
};

static int64_t seconds(double s)
{
    return (int64_t)(s * 1e9);
}

static void session_free(void *data)
{
    struct session *self = data;
    pel_session_cancel(self);
    pel_claim_give(&self->unread);
    g_ptr_array_free(self->jobs, TRUE);
    pel_fdsource_destroy(self->source);
    close(self->fd);
    pel_outbox_finish(&self->out);
    g_free(self->in);
    g_free(self);
}

static void session_close(struct session *self)
{
    g_ptr_array_remove_fast(self->all->list, self);
}

/* By the role of the session's token. */
static enum pel_err may(const struct session *self,
                        const Pelagos__Request *request,
                        struct pel_fault *fault)
{
    unsigned command = request->command_case;
    const char *name =
        command < PEL_SESSION_COMMANDS ? command_names[command] : NULL;
    enum pel_role role = pel_role_of_rank(self->who.rank);
    enum pel_err err =
        pel_role_need(role, pel_role_of_command(request->command_case),
                      name ? name : "this command", fault);
    if (!err && request->command_case == PELAGOS__REQUEST__COMMAND_PATCH) {
        err = pel_role_patch(role, request->patch,
                             pel_scene_state(self->all->scene), fault);
    }
    return err;
}

static enum pel_err apply(struct session *self, const Pelagos__Request *request,
                          struct pel_fault *fault)
{
    enum pel_err err = PEL_OK;
    if (!request->get) { /* any member of the union */
        return pel_fault_set(fault, PEL_ERR_INVALID,
                             "the request has no command");
    }
    if (self->all->stopped) {
        return pel_fault_set(fault, PEL_ERR_CONFLICT, "the server stops");
    }
    err = may(self, request, fault);
    if (err) {
        return err;
    }
    switch (request->command_case) {
    case PELAGOS__REQUEST__COMMAND_GET:
    case PELAGOS__REQUEST__COMMAND_LOGIN: /* admitted already */
        break;
    case PELAGOS__REQUEST__COMMAND_PATCH:
        pel_session_patch(self, request);
        return PEL_OK;
    case PELAGOS__REQUEST__COMMAND_STEP:
        err = pel_command_check(&request->step->base, fault);
        if (err == PEL_OK) {
            pel_session_step(self, request);
        }
        return err;
    case PELAGOS__REQUEST__COMMAND_FRAME:
    case PELAGOS__REQUEST__COMMAND_FRAMES:
    case PELAGOS__REQUEST__COMMAND_SURFACE:
    case PELAGOS__REQUEST__COMMAND_OPTICS:
        return pel_session_start(self, request, fault);
    case PELAGOS__REQUEST__COMMAND_SPECTRUM:
        return pel_session_spectrum(self, request, fault);
    case PELAGOS__REQUEST__COMMAND_SERIES:
        return pel_session_series(self, request, fault);
    case PELAGOS__REQUEST__COMMAND_MODELS:
        return pel_session_models(self, request, fault);
    case PELAGOS__REQUEST__COMMAND_ALMANAC:
        return pel_session_almanac(self, request, fault);
    case PELAGOS__REQUEST__COMMAND_RECORDINGS:
    case PELAGOS__REQUEST__COMMAND_RECORDING:
        return pel_session_recordings(self, request, fault);
    case PELAGOS__REQUEST__COMMAND_DEBRIEF:
        return pel_session_debrief(self, request, fault);
    case PELAGOS__REQUEST__COMMAND_EXERCISE:
        return pel_session_exercise(self, request, fault);
    case PELAGOS__REQUEST__COMMAND_CLUSTER:
        pel_session_cluster(self, request);
        return PEL_OK;
    case PELAGOS__REQUEST__COMMAND_PLACE:
        return pel_session_place(self, request, fault);
    case PELAGOS__REQUEST__COMMAND_WATCH:
        self->watching = true;
        self->watch_has_id = request->has_id;
        self->watch_id = request->id;
        self->watch_due = false;
        break;
    default:
        return pel_fault_set(fault, PEL_ERR_INVALID,
                             "the request's command is not known");
    }
    if (err == PEL_OK) {
        pel_session_send_state(self, request->has_id, request->id);
    }
    return err;
}

static void malformed(struct session *self, const char *why)
{
    static struct pel_log_limit limit;
    self->all->malformed[self->transport]++;
    pel_log_limited(&limit, PEL_LOG_WARNING, "NET-010", "%s session closed: %s",
                    transport_names[self->transport], why);
    struct pel_fault fault;
    pel_fault_set(&fault, PEL_ERR_MALFORMED, "%s", why);
    pel_session_send_fault(self, false, 0, &fault);
    self->closing = true;
}

/* False: the request is no Login, or one with a wrong token, or no place is
 * left for whom it names. */
static bool admit(struct session *self, const Pelagos__Request *request,
                  struct pel_fault *fault)
{
    struct pel_token *token = self->all->token;
    bool login = request->command_case == PELAGOS__REQUEST__COMMAND_LOGIN;
    if (login && token && self->transport == PEL_TRANSPORT_TCP) {
        const char *text = request->login->token ? request->login->token : "";
        self->who = pel_token_who(token, text, strlen(text));
        self->stranger = true;
        if (self->who.rank != PEL_RANK_NOBODY) {
            self->stranger = !pel_session_find_place(self, fault);
            return !self->stranger;
        }
    }
    if (!self->stranger) {
        return true;
    }
    static struct pel_log_limit limit;
    self->all->unauthorized++;
    pel_log_limited(&limit, PEL_LOG_WARNING, "NET-012",
                    "a session over TCP gave %s token",
                    login ? "a wrong" : "no");
    pel_fault_set(fault, PEL_ERR_UNAUTHORIZED,
                  login ? "the token is wrong"
                        : "this server asks for a token: begin with Login");
    return false;
}

static void take_message(struct session *self, const uint8_t *data, size_t size)
{
    struct pel_unpack *unpack = &self->all->unpack;
    Pelagos__Request *request =
        pelagos__request__unpack(&unpack->allocator, size, data);
    if (!request) {
        pel_unpack_reset(unpack);
        malformed(self, "the message is not a pelagos.Request");
        return;
    }
    pel_message_forget_unknown(&request->base);
    unsigned command = request->command_case;
    if (command < PEL_SESSION_COMMANDS) {
        self->all->requests[command]++;
    }
    if (command == PELAGOS__REQUEST__COMMAND__NOT_SET) {
        self->all->malformed[self->transport]++;
    }
    self->active_ns = pel_now_ns();
    struct pel_fault fault;
    if (!admit(self, request, &fault)) {
        pel_session_send_fault(self, request->has_id, request->id, &fault);
        self->closing = true;
    } else if (apply(self, request, &fault) != PEL_OK) {
        pel_session_send_fault(self, request->has_id, request->id, &fault);
    }
    pel_unpack_reset(unpack);
}

/* Whether another message may be begun now. */
static bool may_take(const struct session *self)
{
    return !self->closing && !self->owes && self->out.bytes <= OUTPUT_PAUSE;
}

/* Takes whole messages from the buffer. `held` afterwards: it may hold more
 * of them, which wait for their turn or for the reader. */
static void take_messages(struct session *self)
{
    size_t used = 0;
    self->held = true;
    for (int i = 0; may_take(self) && i < MESSAGES_A_TURN; i++) {
        size_t offset = 0, length = 0;
        enum pel_wire found = pel_wire_next(
            self->in + used, self->in_size - used,
            self->all->limits.session_message_bytes, &offset, &length);
        if (found == PEL_WIRE_MORE) {
            self->held = false;
            break;
        }
        if (found == PEL_WIRE_MESSAGE) {
            take_message(self, self->in + used + offset, length);
            used += offset + length;
        } else {
            malformed(self, found == PEL_WIRE_TOO_LONG
                                ? "the message is longer than allowed"
                                : "the length before the message is not a "
                                  "varint");
        }
    }
    if (used > 0) {
        memmove(self->in, self->in + used, self->in_size - used);
        self->in_size -= used;
        self->message_since_ns = 0;
    }
    if (self->in_size > 0 && self->message_since_ns == 0) {
        self->message_since_ns = pel_now_ns();
    }
}

static void read_some(struct session *self)
{
    size_t most = self->all->limits.session_message_bytes + PEL_WIRE_MAX_PREFIX;
    if (self->in_size == self->in_capacity && self->in_capacity < most) {
        self->in_capacity = MIN(MAX(2 * self->in_capacity, 4096), most);
        self->in = g_realloc(self->in, self->in_capacity);
    }
    size_t room = self->in_capacity - self->in_size;
    if (room == 0) {
        return;
    }
    ssize_t n = recv(self->fd, self->in + self->in_size, room, MSG_DONTWAIT);
    if (n > 0) {
        self->in_size += (size_t)n;
        self->all->in_bytes += (uint64_t)n;
    } else if (n == 0 || (errno != EAGAIN && errno != EINTR)) {
        self->eof = true;
    }
}

/* --- the session's turn --------------------------------------------------- */

/* False: the client is gone. */
static bool write_some(struct session *self)
{
    size_t sent = 0;
    enum pel_outbox_result result =
        pel_outbox_flush(&self->out, self->fd, &sent);
    if (sent > 0) {
        self->progress_ns = pel_now_ns();
        self->all->out_bytes += sent;
    }
    if (self->nudge) {
        pel_nudge();
        self->nudge = false;
    }
    return result != PEL_OUTBOX_GONE;
}

static bool stalled(struct session *self, int64_t now)
{
    if (self->out.bytes > 0 &&
        now - self->progress_ns > seconds(self->all->limits.session_stall_s)) {
        self->all->timeouts[self->transport]++;
        return true;
    }
    return false;
}

static bool half_sent(struct session *self, int64_t now)
{
    if (self->message_since_ns && may_take(self) &&
        now - self->message_since_ns >
            seconds(self->all->limits.session_message_s)) {
        self->all->timeouts[self->transport]++;
        return true;
    }
    return false;
}

/* When a client that has not given the token has had its time. */
static int64_t stranger_time(const struct session *self)
{
    return self->active_ns + seconds(self->all->limits.session_login_s);
}

static bool loiters(struct session *self, int64_t now)
{
    if (self->stranger && now > stranger_time(self)) {
        self->all->timeouts[self->transport]++;
        return true;
    }
    return false;
}

static int64_t stall_time(const struct session *self)
{
    return self->progress_ns + seconds(self->all->limits.session_stall_s) +
           1000000;
}

/* The last replies go out, then the sending side is shut, and what the client
 * still sends is thrown away for a moment, so that a reset does not overtake
 * the Error. */
static void turn_closing(struct session *self, GIOCondition ready)
{
    int64_t now = pel_now_ns();
    bool over = !write_some(self) || stalled(self, now);
    if (self->out.bytes == 0 && self->close_by_ns == 0) {
        shutdown(self->fd, SHUT_WR);
        self->close_by_ns = now + LINGER_NS;
        over = over || self->eof;
    }
    if (ready & G_IO_IN) {
        char waste[READ_A_TURN];
        over = recv(self->fd, waste, sizeof waste, MSG_DONTWAIT) == 0 || over;
    } else if (ready & (G_IO_ERR | G_IO_HUP)) {
        over = true;
    }
    if (over || (self->close_by_ns && now >= self->close_by_ns)) {
        session_close(self);
        return;
    }
    pel_fdsource_want(self->source, self->close_by_ns ? G_IO_IN : G_IO_OUT);
    pel_fdsource_wake_at(self->source, self->close_by_ns ? self->close_by_ns
                                                         : stall_time(self));
}

static void plan_next(struct session *self)
{
    GIOCondition wanted = 0;
    int64_t wake = -1;
    if (!may_take(self)) {
        if (self->message_since_ns) {
            self->message_since_ns = pel_now_ns(); /* we made it wait */
        }
    } else if (self->held) {
        wake = 0;
    } else {
        wanted |= G_IO_IN;
        if (self->message_since_ns) {
            wake = self->message_since_ns +
                   seconds(self->all->limits.session_message_s) + 1000000;
        }
    }
    if (self->out.bytes > 0) {
        wanted |= G_IO_OUT;
        wake = wake < 0 ? stall_time(self) : MIN(wake, stall_time(self));
    }
    if (self->stranger) {
        int64_t end = stranger_time(self) + 1000000;
        wake = wake < 0 ? end : MIN(wake, end);
    }
    pel_fdsource_want(self->source, wanted);
    pel_fdsource_wake_at(self->source, wake);
}

/* The session that has read nothing for longest weighs most. */
static void note_unread(struct session *self)
{
    if (self->out.bytes > 0 || self->unread.all) {
        pel_claim_unread(self->all->claims, &self->who, self->out.bytes,
                         &self->unread);
        self->unread.since_ns = self->progress_ns;
    }
}

static void session_run(void *user, GIOCondition ready)
{
    struct session *self = user;
    if (self->ended) {
        session_close(self);
        return;
    }
    if (self->closing) {
        turn_closing(self, ready);
        return;
    }
    if (ready & G_IO_IN) {
        read_some(self);
    } else if (ready & (G_IO_ERR | G_IO_HUP)) {
        session_close(self);
        return;
    }
    take_messages(self);
    if (self->eof && !self->held) {
        self->closing = true;
    }
    bool alive = write_some(self);
    if (self->watch_due && self->out.bytes == 0 && !self->closing) {
        self->watch_due = false;
        pel_session_send_watched(self);
        alive = alive && write_some(self);
    }
    if (self->closing && alive) {
        pel_session_cancel(self);
        turn_closing(self, 0);
        return;
    }
    int64_t now = pel_now_ns();
    if (!alive || stalled(self, now) || half_sent(self, now) ||
        loiters(self, now)) {
        session_close(self);
        return;
    }
    note_unread(self);
    plan_next(self);
}

/* --- all sessions --------------------------------------------------------- */

struct pel_sessions *pel_sessions_create(const struct pel_net_limits *limits,
                                         struct pel_scene *scene,
                                         struct pel_frames *frames,
                                         struct pel_debrief *debrief,
                                         struct pel_token *token)
{
    struct pel_sessions *all = g_new0(struct pel_sessions, 1);
    all->limits = *limits;
    all->scene = scene;
    all->frames = frames;
    all->debrief = debrief;
    all->token = token;
    pel_unpack_init(&all->unpack);
    all->list = g_ptr_array_new_with_free_func(session_free);
    return all;
}

void pel_sessions_series(struct pel_sessions *all, struct pel_series *series)
{
    all->series = series;
}

void pel_sessions_claims(struct pel_sessions *all, struct pel_claims *claims)
{
    all->claims = claims;
}

void pel_sessions_exercises(struct pel_sessions *all,
                            struct pel_exercises *exercises)
{
    all->exercises = exercises;
}

void pel_sessions_cluster(struct pel_sessions *all, struct pel_cluster *cluster)
{
    all->cluster = cluster;
}

void pel_sessions_destroy(struct pel_sessions *all)
{
    if (all) {
        g_ptr_array_free(all->list, TRUE);
        pel_unpack_finish(&all->unpack);
        for (int rank = 0; rank < PEL_RANKS; rank++) {
            free(all->packed[rank].bytes);
        }
        g_free(all);
    }
}

static void tune_tcp(int fd)
{
    int on = 1, idle_s = 30, interval_s = 10, count = 3;
    setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
    setsockopt(fd, SOL_SOCKET, SO_KEEPALIVE, &on, sizeof on);
    setsockopt(fd, IPPROTO_TCP, TCP_KEEPIDLE, &idle_s, sizeof idle_s);
    setsockopt(fd, IPPROTO_TCP, TCP_KEEPINTVL, &interval_s, sizeof interval_s);
    setsockopt(fd, IPPROTO_TCP, TCP_KEEPCNT, &count, sizeof count);
}

bool pel_sessions_accept(struct pel_sessions *all, int fd,
                         enum pel_transport transport)
{
    static struct pel_log_limit limit;
    struct session *self = g_new0(struct session, 1);
    struct pel_fault fault;
    pel_fault_set(&fault, PEL_ERR_CONFLICT, "the server stops");
    self->all = all;
    self->transport = transport;
    self->stranger = all->token && transport == PEL_TRANSPORT_TCP;
    bool room = !all->stopped &&
                (self->stranger ? pel_sessions_find_stranger_place(all)
                                : pel_session_find_place(self, &fault));
    if (!room) {
        g_free(self);
        pel_log_limited(&limit, PEL_LOG_WARNING, "NET-011",
                        "%s session refused: %u are open",
                        transport_names[transport],
                        pel_sessions_count(all, transport, false));
        size_t size = 0;
        uint8_t *data = pel_fault_reply(false, 0, &fault, &size);
        ssize_t sent = send(fd, data, size, MSG_NOSIGNAL | MSG_DONTWAIT);
        (void)sent; /* a courtesy */
        free(data);
        return false;
    }
    if (transport == PEL_TRANSPORT_TCP) {
        tune_tcp(fd);
    }
    self->fd = fd;
    self->jobs = g_ptr_array_new();
    self->active_ns = pel_now_ns();
    self->who.rank = self->stranger ? PEL_RANK_NOBODY : PEL_RANK_INSTRUCT;
    self->unread.end = pel_session_end_soon;
    self->unread.user = self;
    pel_outbox_init(&self->out);
    self->source = pel_fdsource_create(fd, G_IO_IN, session_run, self);
    if (self->stranger) {
        pel_fdsource_wake_at(self->source, stranger_time(self) + 1000000);
    }
    g_ptr_array_add(all->list, self);
    all->accepted[transport]++;
    return true;
}

void pel_sessions_stop(struct pel_sessions *all)
{
    all->stopped = true;
}

unsigned pel_sessions_in_flight(const struct pel_sessions *all)
{
    unsigned count = 0;
    for (guint i = 0; i < all->list->len; i++) {
        const struct session *each = g_ptr_array_index(all->list, i);
        count += each->jobs->len + (each->out.bytes > 0);
    }
    return count;
}

void pel_sessions_changed(struct pel_sessions *all)
{
    for (guint i = 0; i < all->list->len; i++) {
        struct session *each = g_ptr_array_index(all->list, i);
        if (each->watching && !each->watch_due) {
            each->watch_due = true;
            pel_fdsource_wake_at(each->source, 0);
        }
    }
}

static void collect_transport(const struct pel_sessions *all, int transport,
                              struct pel_metrics_page *page)
{
    char label[32];
    g_snprintf(label, sizeof label, "input=\"%s\"", transport_names[transport]);
    double open = 0;
    for (guint i = 0; i < all->list->len; i++) {
        const struct session *each = g_ptr_array_index(all->list, i);
        open += (int)each->transport == transport;
    }
    pel_metric(page, "pelagos_sessions", PEL_METRIC_GAUGE,
               "Protobuf sessions open.", label, open);
    pel_metric(page, "pelagos_sessions_accepted_total", PEL_METRIC_COUNTER,
               "Protobuf sessions accepted.", label,
               (double)all->accepted[transport]);
    pel_metric(page, "pelagos_refused_total", PEL_METRIC_COUNTER,
               "Clients turned away at a limit.", label,
               (double)all->refused[transport]);
    pel_metric(page, "pelagos_malformed_total", PEL_METRIC_COUNTER,
               "Messages that could not be read.", label,
               (double)all->malformed[transport]);
    pel_metric(page, "pelagos_timeouts_total", PEL_METRIC_COUNTER,
               "Clients closed for being too slow.", label,
               (double)all->timeouts[transport]);
}

void pel_sessions_collect(const struct pel_sessions *all,
                          struct pel_metrics_page *page)
{
    for (int i = 0; i < PEL_TRANSPORT_COUNT; i++) {
        collect_transport(all, i, page);
    }
    for (int i = 0; i < PEL_SESSION_COMMANDS; i++) {
        char label[32];
        g_snprintf(label, sizeof label, "command=\"%s\"",
                   command_names[i] ? command_names[i] : "unknown");
        if (command_names[i]) {
            pel_metric(page, "pelagos_session_requests_total",
                       PEL_METRIC_COUNTER, "Requests of protobuf sessions.",
                       label, (double)all->requests[i]);
        }
    }
    pel_metric(page, "pelagos_session_errors_total", PEL_METRIC_COUNTER,
               "Error replies to protobuf sessions.", NULL,
               (double)all->errors);
    pel_metric(page, "pelagos_session_unauthorized_total", PEL_METRIC_COUNTER,
               "Requests over TCP without the token.", NULL,
               (double)all->unauthorized);
    pel_metric(page, "pelagos_session_evicted_total", PEL_METRIC_COUNTER,
               "Idle sessions closed to make room.", NULL,
               (double)all->evicted);
    pel_metric(page, "pelagos_session_received_bytes_total", PEL_METRIC_COUNTER,
               "Bytes read from protobuf sessions.", NULL,
               (double)all->in_bytes);
    pel_metric(page, "pelagos_session_sent_bytes_total", PEL_METRIC_COUNTER,
               "Bytes sent to protobuf sessions.", NULL,
               (double)all->out_bytes);
}
