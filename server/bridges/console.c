#include "bridges/console.h"

#include <errno.h>
#include <glib-unix.h>
#include <glib.h>
#include <math.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include "base/clock.h"
#include "base/file.h"
#include "base/log.h"
#include "base/watch.h"
#include "bridges/target.h"
#include "path.h"

#define MS 1000000LL
#define FIRST_RETRY_NS (250 * MS)
#define LAST_RETRY_NS (8000 * MS)
#define MAX_ANSWER 260

enum step {
    STEP_CLOSED, /* until retry_ns */
    STEP_CONNECTING,
    STEP_IDLE,    /* until poll_ns */
    STEP_WAITING, /* for the answer of a group */
};

struct pel_console {
    struct pel_console_options options;
    struct pel_scene *scene;
    struct pel_console_table table;
    struct pel_target *server;
    const char *name; /* the server's, as it was given */
    enum step step;
    int fd;
    guint fd_source, tick_source;
    int64_t since_ns; /* of this step */
    int64_t retry_ns, poll_ns, backoff_ns;
    size_t group; /* at hand */
    uint16_t transaction;
    uint8_t answer[MAX_ANSWER];
    size_t answer_size;
    bool refused;                      /* an exception in this poll */
    double read[PEL_CONSOLE_MAX_ROWS]; /* of this poll */
    double sent[PEL_CONSOLE_MAX_ROWS]; /* NaN: none yet */
    enum pel_console_state state;
    int64_t heard_ns;
    struct pel_console_counters counters;
};

/* --- into the scene ------------------------------------------------------- */

static bool in_range(const char *path, double value)
{
    struct pel_path_info info;
    return pel_path_find(path, &info, NULL) == PEL_OK && info.info &&
           (!info.info->ranged ||
            (value >= info.info->minimum && value <= info.info->maximum));
}

static void refused(struct pel_console *c, const struct pel_fault *fault)
{
    static struct pel_log_limit limit;
    pel_log_limited(&limit, PEL_LOG_WARNING, "CON-004",
                    "an edit by the console was refused: %s %s", fault->path,
                    fault->message);
    c->counters.refused_edits++;
}

static void on_edited(void *user, enum pel_err err,
                      const struct pel_fault *fault)
{
    struct pel_console *c = user;
    if (err) {
        refused(c, fault);
    } else {
        c->counters.edits++;
    }
}

/* One edit of all rows whose new value is not NaN. */
static void apply(struct pel_console *c, const double *values)
{
    struct pel_fault fault;
    Pelagos__Patch *patch = pel_patch_new();
    const struct pel_scene_wish wish = { .patch = patch, .source = c };
    enum pel_err err = PEL_OK;
    size_t count = 0;
    for (size_t i = 0; i < c->table.row_count && !err; i++) {
        if (!isnan(values[i])) {
            err = pel_path_set_number(patch, pel_scene_state(c->scene),
                                      c->table.rows[i].path, values[i], &fault);
            count++;
        }
    }
    if (err) {
        refused(c, &fault);
    } else if (count > 0) {
        pel_scene_submit(c->scene, &wish, on_edited, c);
    }
    pelagos__patch__free_unpacked(patch, NULL);
}

/* What is new of a whole poll. */
static void take_poll(struct pel_console *c)
{
    double fresh[PEL_CONSOLE_MAX_ROWS];
    for (size_t i = 0; i < c->table.row_count; i++) {
        const struct pel_console_row *row = &c->table.rows[i];
        double value = c->read[i];
        bool legal = !isnan(value) && in_range(row->path, value);
        bool moved =
            isnan(c->sent[i]) || fabs(value - c->sent[i]) > row->deadband;
        c->counters.out_of_range += !legal;
        fresh[i] = legal && moved ? value : NAN;
        if (legal && moved) {
            c->sent[i] = value;
        }
    }
    apply(c, fresh);
}

static void become_live(struct pel_console *c, int64_t now_ns)
{
    c->heard_ns = now_ns;
    c->backoff_ns = 0;
    c->counters.polls++;
    if (c->state != PEL_CONSOLE_LIVE) {
        pel_info("CON-002", "the console at %s is polled", c->name);
        c->state = PEL_CONSOLE_LIVE;
        pel_scene_set_stale(c->scene, PEL_STALE_CONSOLE, false);
    }
}

/* Rows that say so go to their value; everything is news again afterwards. */
static void become_stale(struct pel_console *c)
{
    double safe[PEL_CONSOLE_MAX_ROWS];
    pel_warn("CON-003", "the console at %s is stale: no whole poll for %d ms",
             c->name, c->options.stale_ms);
    c->state = PEL_CONSOLE_STALE;
    c->counters.stale++;
    pel_scene_set_stale(c->scene, PEL_STALE_CONSOLE, true);
    for (size_t i = 0; i < c->table.row_count; i++) {
        const struct pel_console_row *row = &c->table.rows[i];
        safe[i] = row->has_stale ? row->stale : NAN;
        c->sent[i] = NAN;
    }
    apply(c, safe);
}

/* --- the connection ------------------------------------------------------- */

static gboolean on_socket(gint fd, GIOCondition condition, gpointer user);

static void hang_up(struct pel_console *c, const char *why)
{
    static struct pel_log_limit limit;
    if (c->fd_source) {
        g_source_remove(c->fd_source);
        c->fd_source = 0;
    }
    if (c->fd >= 0) {
        close(c->fd);
        c->fd = -1;
    }
    c->backoff_ns = c->backoff_ns > 0 ? MIN(2 * c->backoff_ns, LAST_RETRY_NS)
                                      : FIRST_RETRY_NS;
    c->retry_ns = pel_now_ns() + c->backoff_ns;
    c->step = STEP_CLOSED;
    c->counters.failures++;
    pel_target_failed(c->server);
    pel_log_limited(&limit, PEL_LOG_WARNING, "CON-005",
                    "the console at %s: %s; tried again in %.2f s", c->name,
                    why, (double)c->backoff_ns * 1e-9);
}

static void go_on(struct pel_console *c, enum step step)
{
    c->step = step;
    c->since_ns = pel_now_ns();
}

static void watch_for(struct pel_console *c, GIOCondition condition)
{
    if (c->fd_source) {
        g_source_remove(c->fd_source);
    }
    c->fd_source = g_unix_fd_add(c->fd, condition, on_socket, c);
}

static void dial(struct pel_console *c)
{
    int yes = 1;
    socklen_t size;
    const struct sockaddr *to = pel_target_address(c->server, &size);
    if (!to) {
        hang_up(c, "its name is not resolved");
        return;
    }
    c->fd =
        socket(to->sa_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    if (c->fd < 0) {
        hang_up(c, strerror(errno));
        return;
    }
    setsockopt(c->fd, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
    if (connect(c->fd, to, size) != 0 && errno != EINPROGRESS) {
        hang_up(c, strerror(errno));
        return;
    }
    go_on(c, STEP_CONNECTING);
    watch_for(c, G_IO_OUT);
}

static void connected(struct pel_console *c)
{
    int error = 0;
    socklen_t size = sizeof error;
    getsockopt(c->fd, SOL_SOCKET, SO_ERROR, &error, &size);
    if (error != 0) {
        hang_up(c, strerror(error));
        return;
    }
    c->counters.connections++;
    c->poll_ns = 0;
    go_on(c, STEP_IDLE);
    watch_for(c, G_IO_IN);
}

/* The unit that is asked now. */
static uint8_t unit_of(const struct pel_console *c)
{
    int unit = c->table.groups[c->group].unit;
    return (uint8_t)(unit < 0 ? c->options.unit : unit);
}

/* Twelve bytes into an empty socket buffer go at once or never. */
static void ask(struct pel_console *c)
{
    uint8_t adu[12];
    size_t size = pel_console_request(&c->table.groups[c->group],
                                      ++c->transaction, unit_of(c), adu);
    c->answer_size = 0;
    if (send(c->fd, adu, size, MSG_NOSIGNAL) != (ssize_t)size) {
        hang_up(c, strerror(errno));
        return;
    }
    go_on(c, STEP_WAITING);
}

static void begin_poll(struct pel_console *c, int64_t now_ns)
{
    int64_t period_ns = (int64_t)(1e9 / c->options.rate_hz);
    c->poll_ns = now_ns - c->poll_ns > 2 * period_ns ? now_ns + period_ns
                                                     : c->poll_ns + period_ns;
    c->group = 0;
    c->refused = false;
    ask(c);
}

static void end_group(struct pel_console *c)
{
    c->counters.requests++;
    if (++c->group < c->table.group_count) {
        ask(c);
        return;
    }
    go_on(c, STEP_IDLE);
    if (!c->refused) {
        become_live(c, c->since_ns);
        take_poll(c);
    }
}

static void take_values(struct pel_console *c, const uint16_t *words)
{
    const struct pel_console_group *group = &c->table.groups[c->group];
    for (size_t i = group->first; i < group->first + group->count; i++) {
        const struct pel_console_row *row = &c->table.rows[i];
        c->read[i] =
            pel_console_value(row, words + (row->address - group->address));
    }
}

static void take_bytes(struct pel_console *c)
{
    static struct pel_log_limit limit;
    uint16_t words[PEL_CONSOLE_MAX_BITS];
    unsigned code = 0;
    const struct pel_console_group *group = &c->table.groups[c->group];
    switch (pel_console_answer(group, c->transaction, unit_of(c), c->answer,
                               c->answer_size, words, &code)) {
    case PEL_CONSOLE_MORE:
        return;
    case PEL_CONSOLE_WRONG:
        c->counters.malformed++;
        hang_up(c, "not the answer to what was asked");
        return;
    case PEL_CONSOLE_EXCEPTION:
        c->counters.exceptions++;
        c->refused = true;
        pel_log_limited(&limit, PEL_LOG_WARNING, "CON-006",
                        "the console refuses addresses %u .. %u: exception %u",
                        group->address, group->address + group->words - 1,
                        code);
        break;
    case PEL_CONSOLE_VALUES:
        take_values(c, words);
        break;
    }
    end_group(c);
}

static gboolean on_socket(gint fd, GIOCondition condition, gpointer user)
{
    PEL_WATCH("console");
    struct pel_console *c = user;
    guint source = c->fd_source;
    (void)condition;
    if (c->step == STEP_CONNECTING) {
        connected(c);
        return c->fd_source == source;
    }
    ssize_t n = recv(fd, c->answer + c->answer_size,
                     sizeof c->answer - c->answer_size, 0);
    if (n < 0 && (errno == EAGAIN || errno == EINTR)) {
        return G_SOURCE_CONTINUE;
    }
    if (n <= 0) {
        hang_up(c, n == 0 ? "it closed the connection" : strerror(errno));
    } else if (c->step != STEP_WAITING) {
        c->counters.malformed++;
        hang_up(c, "an answer that nobody asked for");
    } else {
        c->answer_size += (size_t)n;
        take_bytes(c);
    }
    return c->fd_source == source;
}

static gboolean on_tick(gpointer user)
{
    PEL_WATCH("console");
    struct pel_console *c = user;
    int64_t now_ns = pel_now_ns();
    bool late = now_ns - c->since_ns > c->options.timeout_ms * MS;
    if (c->step == STEP_CLOSED && now_ns >= c->retry_ns) {
        dial(c);
    } else if (c->step == STEP_CONNECTING && late) {
        c->counters.timeouts++;
        hang_up(c, "no connection in time");
    } else if (c->step == STEP_WAITING && late) {
        c->counters.timeouts++;
        hang_up(c, "no answer in time");
    } else if (c->step == STEP_IDLE && now_ns >= c->poll_ns) {
        begin_poll(c, now_ns);
    }
    if (c->state == PEL_CONSOLE_LIVE &&
        now_ns - c->heard_ns > c->options.stale_ms * MS) {
        become_stale(c);
    }
    return G_SOURCE_CONTINUE;
}

/* --- metrics -------------------------------------------------------------- */

static void collect(void *user, struct pel_metrics_page *page)
{
    const struct pel_console *c = user;
    const struct pel_console_counters *n = &c->counters;
    const struct {
        const char *name, *help;
        uint64_t value;
    } counters[] = {
        { "pelagos_console_connections_total",
          "Connections made to the console.", n->connections },
        { "pelagos_console_failures_total",
          "Connections to the console lost or not made.", n->failures },
        { "pelagos_console_polls_total", "Whole polls of the console.",
          n->polls },
        { "pelagos_console_requests_total", "Answers of the console.",
          n->requests },
        { "pelagos_console_exceptions_total",
          "Requests that the console refused.", n->exceptions },
        { "pelagos_console_timeouts_total",
          "Connections or answers of the console not there in time.",
          n->timeouts },
        { "pelagos_console_malformed_total",
          "Answers of the console that were none.", n->malformed },
        { "pelagos_console_edits_total", "Changes of the scene by the console.",
          n->edits },
        { "pelagos_console_refused_edits_total",
          "Changes by the console that the scene refused.", n->refused_edits },
        { "pelagos_console_out_of_range_total",
          "Values of the console outside the schema's range, or no number.",
          n->out_of_range },
        { "pelagos_console_stale_total", "Times the console became stale.",
          n->stale },
    };
    for (size_t i = 0; i < G_N_ELEMENTS(counters); i++) {
        pel_metric(page, counters[i].name, PEL_METRIC_COUNTER, counters[i].help,
                   NULL, (double)counters[i].value);
    }
    pel_metric(page, "pelagos_console_state", PEL_METRIC_GAUGE,
               "The console: 0 never polled, 1 live, 2 stale.", NULL, c->state);
}

/* --- life ----------------------------------------------------------------- */

struct pel_console_options pel_console_default_options(void)
{
    return (struct pel_console_options){
        .order = PEL_MODBUS_ABCD,
        .rate_hz = 10,
        .unit = 1,
        .timeout_ms = 500,
        .stale_ms = 2000,
    };
}

static enum pel_err check_options(const struct pel_console_options *o,
                                  struct pel_fault *fault)
{
    bool good = o->rate_hz >= 0.1 && o->rate_hz <= 100 && o->unit >= 0 &&
                o->unit <= 255 && o->timeout_ms >= 10 &&
                o->timeout_ms <= 10000 && o->stale_ms >= 100 &&
                o->stale_ms <= 60000;
    return good ? PEL_OK
                : pel_fault_set(fault, PEL_ERR_INVALID,
                                "console: rate, unit, time-out or stale time "
                                "is out of range");
}

static enum pel_err read_table(struct pel_console *c, struct pel_fault *fault)
{
    const struct pel_console_options *o = &c->options;
    char *text = NULL;
    size_t size;
    struct pel_fault why;
    if (!o->table_path) {
        return pel_console_table_read(o->table, strlen(o->table), o->order,
                                      &c->table, fault);
    }
    enum pel_err err =
        pel_file_read(o->table_path, PEL_CONSOLE_MAX_FILE, &text, &size, &why);
    if (err) {
        return pel_fault_set(fault, err, "--console-table: %s", why.message);
    }
    err = pel_console_table_read(text, size, o->order, &c->table, &why);
    free(text);
    if (err) {
        pel_fault_set(fault, err, "--console-table: %s: %s", o->table_path,
                      why.message);
    }
    return err;
}

enum pel_err pel_console_create(const struct pel_console_options *options,
                                struct pel_scene *scene,
                                struct pel_console **out,
                                struct pel_fault *fault)
{
    *out = NULL;
    enum pel_err err = check_options(options, fault);
    if (err) {
        return err;
    }
    struct pel_console *c = g_new0(struct pel_console, 1);
    c->options = *options;
    c->scene = scene;
    c->fd = -1;
    err = read_table(c, fault);
    if (!err) {
        const struct pel_target_options server = { "console", options->server,
                                                   AF_UNSPEC,
                                                   options->metrics };
        err = pel_target_create(&server, &c->server, fault);
    }
    if (err) {
        g_free(c);
        return err;
    }
    for (size_t i = 0; i < PEL_CONSOLE_MAX_ROWS; i++) {
        c->sent[i] = NAN;
    }
    c->name = pel_target_text(c->server);
    c->options.server = c->options.table = c->options.table_path = NULL;
    guint tick_ms = (guint)fmin(fmax(500 / options->rate_hz, 5), 50);
    c->tick_source = g_timeout_add(tick_ms, on_tick, c);
    if (options->metrics) {
        pel_metrics_add(options->metrics, collect, c);
    }
    pel_info("CON-001", "console at %s: %zu fields in %zu requests, %g Hz",
             c->name, c->table.row_count, c->table.group_count,
             options->rate_hz);
    *out = c;
    return PEL_OK;
}

void pel_console_destroy(struct pel_console *c)
{
    if (!c) {
        return;
    }
    if (c->options.metrics) {
        pel_metrics_remove(c->options.metrics, collect, c);
    }
    pel_scene_forget(c->scene, c);
    g_source_remove(c->tick_source);
    pel_target_destroy(c->server);
    if (c->fd_source) {
        g_source_remove(c->fd_source);
    }
    if (c->fd >= 0) {
        close(c->fd);
    }
    g_free(c);
}

enum pel_console_state pel_console_state(const struct pel_console *console)
{
    return console->state;
}

const struct pel_console_counters *
pel_console_counters(const struct pel_console *console)
{
    return &console->counters;
}
