/* The socket of the CIGI bridge and its clock. */
#include <errno.h>
#include <glib-unix.h>
#include <string.h>
#include <sys/timerfd.h>
#include <unistd.h>

#include "base/clock.h"
#include "base/log.h"
#include "base/watch.h"
#include "bridges/cigi_parts.h"
#include "bridges/target.h"

static void receive(struct pel_cigi *cigi)
{
    int64_t end_ns = pel_now_ns() + TURN_NS;
    while (pel_now_ns() < end_ns) {
        struct sockaddr_storage peer = { 0 };
        socklen_t size = sizeof peer;
        if (cigi->batch_count == BATCH ||
            cigi->in_used > sizeof cigi->in - MAX_DATAGRAM) {
            pel_cigi_apply(cigi);
        }
        uint8_t *at = cigi->in + cigi->in_used;
        ssize_t got = recvfrom(cigi->fd, at, MAX_DATAGRAM, MSG_TRUNC,
                               (struct sockaddr *)&peer, &size);
        if (got < 0) {
            break;
        }
        /* While a host leads, only it is listened to. */
        if (!pel_allow_has(&cigi->allow, (struct sockaddr *)&peer) ||
            (size_t)got > MAX_DATAGRAM ||
            (cigi->led && memcmp(&peer, &cigi->speaker, sizeof peer) != 0)) {
            cigi->counters.refused_datagrams++;
            continue;
        }
        if (!pel_cigi_take(cigi, at, (size_t)got)) {
            continue;
        }
        if (cigi->batch_count > 0) {
            cigi->in_used += (size_t)got;
        }
        cigi->speaker = peer;
        if (!cigi->host_target) {
            cigi->host = peer;
            cigi->host_size = size;
        }
    }
    pel_cigi_apply(cigi);
}

static gboolean on_readable(gint fd, GIOCondition condition, gpointer user)
{
    PEL_WATCH("cigi");
    (void)fd;
    (void)condition;
    receive(user);
    return G_SOURCE_CONTINUE;
}

static gboolean on_timer(gint fd, GIOCondition condition, gpointer user)
{
    PEL_WATCH("cigi");
    struct pel_cigi *cigi = user;
    const uint8_t *bytes;
    uint64_t beats;
    (void)condition;
    if (read(fd, &beats, sizeof beats) != sizeof beats) {
        return G_SOURCE_CONTINUE;
    }
    if (cigi->host_target) {
        const struct sockaddr *to =
            pel_target_address(cigi->host_target, &cigi->host_size);
        if (to) {
            memcpy(&cigi->host, to, cigi->host_size);
        }
    }
    if (cigi->host_size == 0) {
        return G_SOURCE_CONTINUE;
    }
    if (beats > 1) {
        receive(cigi); /* it may have spoken while this thread was held up */
    }
    cigi->counters.skipped_frames += beats - 1;
    size_t size = pel_cigi_frame(cigi, &bytes);
    if (cigi->host_size > 0 &&
        sendto(cigi->fd, bytes, size, MSG_NOSIGNAL,
               (struct sockaddr *)&cigi->host, cigi->host_size) < 0) {
        static struct pel_log_limit limit;
        pel_log_limited(&limit, PEL_LOG_DEBUG, "CIG-009",
                        "Start of Frame not sent: %s", strerror(errno));
        pel_cigi_not_sent(cigi);
        if (cigi->host_target) {
            pel_target_failed(cigi->host_target);
        }
    }
    return G_SOURCE_CONTINUE;
}

enum pel_err pel_cigi_open_sockets(struct pel_cigi *cigi,
                                   struct pel_fault *fault)
{
    const struct pel_cigi_options *o = &cigi->options;
    enum pel_err err = pel_endpoint_open(
        "cigi", o->listen, o->allow, SOCK_DGRAM, &cigi->fd, &cigi->port, fault);
    if (err) {
        return err;
    }
    struct sockaddr_storage own = { 0 };
    socklen_t size = sizeof own;
    if (o->host) {
        if (getsockname(cigi->fd, (struct sockaddr *)&own, &size) != 0) {
            return pel_fault_set(fault, PEL_ERR_IO, "--cigi: %s",
                                 strerror(errno));
        }
        const struct pel_target_options host = { "cigi-host", o->host,
                                                 own.ss_family, o->metrics };
        err = pel_target_create(&host, &cigi->host_target, fault);
        if (err) {
            return err;
        }
    }
    int bytes = RECEIVE_BUFFER;
    setsockopt(cigi->fd, SOL_SOCKET, SO_RCVBUF, &bytes, sizeof bytes);
    cigi->timer_fd =
        timerfd_create(CLOCK_MONOTONIC, TFD_NONBLOCK | TFD_CLOEXEC);
    long period_ns = (long)(1e9 / o->rate_hz);
    struct itimerspec beat = { 0 };
    beat.it_interval.tv_sec = period_ns / 1000000000;
    beat.it_interval.tv_nsec = period_ns % 1000000000;
    beat.it_value = beat.it_interval;
    if (cigi->timer_fd < 0 ||
        timerfd_settime(cigi->timer_fd, 0, &beat, NULL) != 0) {
        return pel_fault_set(fault, PEL_ERR_IO, "cigi: no timer: %s",
                             strerror(errno));
    }
    cigi->fd_source = g_unix_fd_add(cigi->fd, G_IO_IN, on_readable, cigi);
    cigi->timer_source = g_unix_fd_add(cigi->timer_fd, G_IO_IN, on_timer, cigi);
    pel_info("CIG-001", "CIGI 3.3 on UDP %s, port %u, %g frames/s", o->listen,
             cigi->port, o->rate_hz);
    return PEL_OK;
}

void pel_cigi_close_sockets(struct pel_cigi *cigi)
{
    pel_target_destroy(cigi->host_target);
    if (cigi->fd_source) {
        g_source_remove(cigi->fd_source);
    }
    if (cigi->timer_source) {
        g_source_remove(cigi->timer_source);
    }
    if (cigi->fd >= 0) {
        close(cigi->fd);
    }
    if (cigi->timer_fd >= 0) {
        close(cigi->timer_fd);
    }
}
