/* replay: a log of NMEA sentences over UDP, at its own pace, or a command log
 * (ctl_replay_log.c). */
#include "pelagosctl/ctl.h"

#include <errno.h>
#include <netdb.h>
#include <string.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#include <glib.h>

#include "base/clock.h"
#include "base/file.h"
#include "pelagosctl/log_run.h"
#include "pelagosctl/nmea_log.h"

#define DEFAULT_TARGET "127.0.0.1:10110"
#define MAX_LINE 1024
#define MOST_LOG (1u << 30) /* bytes */

struct replay {
    int fd;
    const char *target;
    double speed;
    bool loop, terminal, quiet;
    size_t sent;
    int64_t start_ns, shown_ns;
};

static enum ctl_exit open_target(struct replay *replay)
{
    const char *colon = strrchr(replay->target, ':');
    if (!colon || colon == replay->target) {
        return ctl_say(CTL_USAGE, "--to %s is not HOST:PORT", replay->target);
    }
    g_autofree char *host =
        g_strndup(replay->target, (size_t)(colon - replay->target));
    struct addrinfo hints = { .ai_socktype = SOCK_DGRAM }, *list = NULL;
    int failure = getaddrinfo(host, colon + 1, &hints, &list);
    if (failure != 0) {
        return ctl_say(CTL_USAGE, "--to %s: %s", replay->target,
                       gai_strerror(failure));
    }
    replay->fd = socket(list->ai_family, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    if (replay->fd >= 0 &&
        connect(replay->fd, list->ai_addr, list->ai_addrlen) != 0) {
        close(replay->fd);
        replay->fd = -1;
    }
    freeaddrinfo(list);
    return replay->fd >= 0 ? CTL_DONE
                           : ctl_say(CTL_FAILED, "--to %s: %s", replay->target,
                                     strerror(errno));
}

static enum ctl_exit send_line(struct replay *replay,
                               const struct nmea_line *line)
{
    char datagram[MAX_LINE + 2];
    if (line->length > MAX_LINE) {
        return CTL_DONE; /* no sentence is that long */
    }
    memcpy(datagram, line->text, line->length);
    memcpy(datagram + line->length, "\r\n", 2);
    for (int tries = 0; tries < 3; tries++) {
        if (send(replay->fd, datagram, line->length + 2, 0) >= 0) {
            replay->sent++;
            return CTL_DONE;
        }
    }
    if (errno == ECONNREFUSED) {
        return ctl_say(CTL_UNREACHABLE,
                       "nothing listens for NMEA at %s: is pelagosd running, "
                       "with --nmea?",
                       replay->target);
    }
    return ctl_say(CTL_FAILED, "%s: %s", replay->target, strerror(errno));
}

static void show_progress(struct replay *replay, const struct nmea_log *log,
                          double time_s)
{
    int64_t now_ns = pel_now_ns();
    if (!replay->terminal || replay->quiet ||
        now_ns - replay->shown_ns < 200000000) {
        return;
    }
    replay->shown_ns = now_ns;
    fprintf(stderr, "\r%6.1f of %.1f s at %g x, %zu sentences ", time_s,
            log->duration_s, replay->speed, replay->sent);
}

/* Waits until `time_s` of the log; in slices, to show progress. */
static void wait_until(struct replay *replay, const struct nmea_log *log,
                       double time_s)
{
    int64_t due_ns = replay->start_ns + (int64_t)(time_s / replay->speed * 1e9);
    for (;;) {
        int64_t now_ns = pel_now_ns();
        if (ctl_interrupted || now_ns >= due_ns) {
            return;
        }
        int64_t wake_ns =
            due_ns - now_ns > 200000000 ? now_ns + 200000000 : due_ns;
        struct timespec wake = { .tv_sec = wake_ns / 1000000000,
                                 .tv_nsec = wake_ns % 1000000000 };
        clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &wake, NULL);
        double shown_s =
            (double)(pel_now_ns() - replay->start_ns) * 1e-9 * replay->speed;
        show_progress(replay, log, shown_s < time_s ? shown_s : time_s);
    }
}

static enum ctl_exit play(struct replay *replay, const struct nmea_log *log)
{
    enum ctl_exit status = CTL_DONE;
    do {
        replay->start_ns = pel_now_ns();
        for (size_t i = 0; i < log->count && status == CTL_DONE; i++) {
            wait_until(replay, log, log->lines[i].time_s);
            if (ctl_interrupted) {
                return CTL_DONE;
            }
            status = send_line(replay, &log->lines[i]);
        }
        if (replay->loop && status == CTL_DONE) {
            wait_until(replay, log, log->duration_s);
        }
    } while (replay->loop && status == CTL_DONE && !ctl_interrupted);
    return status;
}

/* Simulated time must run as fast as the log, or the ship would be reckoned on
 * too slowly between two fixes. */
static enum ctl_exit set_clock(struct ctl *ctl, Pelagos__ClockMode mode,
                               double rate)
{
    Pelagos__Clock clock = PELAGOS__CLOCK__INIT;
    clock.has_mode = clock.has_rate = 1;
    clock.mode = mode;
    clock.rate = rate;
    Pelagos__State state = PELAGOS__STATE__INIT;
    state.clock = &clock;
    Pelagos__Patch patch = PELAGOS__PATCH__INIT;
    patch.state = &state;
    return ctl_patch(ctl, &patch, NULL);
}

/* play, with the clock at the log's speed and as it was afterwards. */
static enum ctl_exit play_with_clock(struct ctl *ctl, struct replay *replay,
                                     const struct nmea_log *log)
{
    Pelagos__State *before = NULL;
    enum ctl_exit status = ctl_fetch(ctl, &before);
    if (status != CTL_DONE) {
        fputs("  --no-clock replays without touching its clock\n", stderr);
        return status;
    }
    Pelagos__ClockMode mode = before->clock->mode;
    double rate = before->clock->rate;
    pelagos__state__free_unpacked(before, NULL);
    status = set_clock(ctl, PELAGOS__CLOCK_MODE__FREE, replay->speed);
    if (status != CTL_DONE) {
        return status;
    }
    status = play(replay, log);
    /* The connection may have been closed for its silence. */
    pel_client_close(ctl->client);
    ctl->client = NULL;
    enum ctl_exit restored = ctl_connect(ctl);
    if (restored == CTL_DONE) {
        restored = set_clock(ctl, mode, rate);
    }
    return status != CTL_DONE ? status : restored;
}

static enum ctl_exit run(struct ctl *ctl, struct replay *replay,
                         const struct nmea_log *log)
{
    enum ctl_exit status = open_target(replay);
    if (status != CTL_DONE) {
        return status;
    }
    ctl_catch_signals();
    int64_t start_ns = pel_now_ns();
    status = ctl_flag(ctl, "no-clock") ? play(replay, log)
                                       : play_with_clock(ctl, replay, log);
    close(replay->fd);
    if (replay->terminal && !replay->quiet) {
        fputs("\r\033[K", stderr);
    }
    double seconds = (double)(pel_now_ns() - start_ns) * 1e-9;
    if (status == CTL_DONE && ctl_flag(ctl, "json")) {
        printf("{\"sentences\":%zu,\"seconds\":%.3f,\"logSeconds\":%.3f,"
               "\"interrupted\":%s}\n",
               replay->sent, seconds, log->duration_s,
               ctl_interrupted ? "true" : "false");
    } else if (status == CTL_DONE && !replay->quiet) {
        printf("%zu sentences in %.1f s to %s%s\n", replay->sent, seconds,
               replay->target, ctl_interrupted ? ", interrupted" : "");
    }
    return status == CTL_DONE && ctl_interrupted ? CTL_FAILED : status;
}

enum ctl_exit ctl_replay(struct ctl *ctl)
{
    struct replay replay = {
        .fd = -1,
        .target = ctl_value(ctl, "to"),
        .speed = 1.0,
        .loop = ctl_flag(ctl, "loop"),
        .terminal = isatty(STDERR_FILENO) != 0,
        .quiet = ctl_flag(ctl, "quiet"),
    };
    replay.target = replay.target ? replay.target : DEFAULT_TARGET;
    g_autofree char *text = NULL;
    size_t size = 0;
    struct pel_fault fault;
    if (log_run_is(ctl->args[0])) {
        return ctl_replay_log(ctl);
    }
    if (ctl->arg_count > 1) {
        return ctl_say(CTL_USAGE,
                       "%s is no command log: several files are the segments "
                       "of one",
                       ctl->args[0]);
    }
    if (pel_file_read(ctl->args[0], MOST_LOG, &text, &size, &fault)) {
        return ctl_say(CTL_FAILED, "%s", fault.message);
    }
    if (ctl_value(ctl, "frames") || ctl_value(ctl, "at") ||
        ctl_value(ctl, "every") || ctl_value(ctl, "view")) {
        return ctl_say(CTL_USAGE, "%s is no command log: it has no frames",
                       ctl->args[0]);
    }
    if (ctl_number(ctl, "speed", 0.01, 100, &replay.speed)) {
        return CTL_USAGE;
    }
    struct nmea_log log;
    nmea_log_read(text, size, &log);
    enum ctl_exit status = CTL_FAILED;
    if (log.count == 0) {
        ctl_say(CTL_FAILED, "%s holds no NMEA sentence", ctl->args[0]);
    } else {
        status = run(ctl, &replay, &log);
    }
    nmea_log_finish(&log);
    return status;
}
