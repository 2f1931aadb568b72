#include "net/listener.h"

#include <arpa/inet.h>
#include <errno.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <glib.h>

#include "base/clock.h"
#include "base/log.h"
#include "base/trial.h"
#include "base/watch.h"
#include "net/fdsource.h"

#define BACKLOG 512
#define ACCEPTS_A_TURN 16 /* then those that came are heard */
#define MOST_A_TURN_NS 300000
#define STARVED_PAUSE_NS 20000000

struct pel_listener {
    int fd;
    int spare; /* given up for a moment to refuse with */
    struct pel_fdsource *source;
    pel_listener_accept accept;
    bool (*make_room)(void *user); /* NULL: there is nobody */
    void *user;
    uint16_t port;
    uint64_t starved;
    char *path; /* of a Unix socket: removed at the end if still ours */
    dev_t device;
    ino_t inode;
};

bool pel_address_is_loopback(const struct sockaddr *address)
{
    if (address->sa_family == AF_INET) {
        const struct sockaddr_in *in = (const void *)address;
        return ntohl(in->sin_addr.s_addr) >> 24 == 127;
    }
    if (address->sa_family == AF_INET6) {
        const struct in6_addr *in6 =
            &((const struct sockaddr_in6 *)(const void *)address)->sin6_addr;
        return IN6_IS_ADDR_LOOPBACK(in6) ||
               (IN6_IS_ADDR_V4MAPPED(in6) && in6->s6_addr[12] == 127);
    }
    return true;
}

static int open_spare(void)
{
    return open("/dev/null", O_RDONLY | O_CLOEXEC);
}

void pel_listener_on_starved(struct pel_listener *self,
                             bool (*make_room)(void *user))
{
    self->make_room = make_room;
}

/* Out of descriptors: with the spare one a client is taken. Another makes room
 * for it, or it is closed, so that it knows, and the backlog does not keep the
 * loop spinning. */
static void refuse_starved(struct pel_listener *self)
{
    static struct pel_log_limit limit;
    pel_log_limited(&limit, PEL_LOG_WARNING, "NET-001",
                    "no file descriptor left, a client is turned away "
                    "(raise LimitNOFILE or ulimit -n)");
    if (self->spare >= 0) {
        close(self->spare);
        struct sockaddr_storage address = { .ss_family = AF_UNIX };
        socklen_t size = sizeof address;
        int fd = accept4(self->fd, (struct sockaddr *)&address, &size,
                         SOCK_CLOEXEC | SOCK_NONBLOCK);
        bool taken =
            fd >= 0 && self->make_room && self->make_room(self->user) &&
            self->accept(self->user, fd, (struct sockaddr *)&address, size);
        self->starved += fd >= 0; /* this one, or who makes room for it */
        if (fd >= 0 && !taken) {
            close(fd);
        }
    }
    self->spare = open_spare();
    if (self->spare < 0) {
        /* It is in use, or another thread took it: look a little later. */
        pel_fdsource_want(self->source, 0);
        pel_fdsource_wake_at(self->source, pel_now_ns() + STARVED_PAUSE_NS);
    }
}

static void on_ready(void *user, GIOCondition ready)
{
    (void)ready;
    struct pel_listener *self = user;
    pel_fdsource_want(self->source, G_IO_IN);
    for (int i = 0; i < ACCEPTS_A_TURN; i++) {
        struct sockaddr_storage address = { .ss_family = AF_UNIX };
        socklen_t size = sizeof address;
        int fd = accept4(self->fd, (struct sockaddr *)&address, &size,
                         SOCK_CLOEXEC | SOCK_NONBLOCK);
        if (fd < 0 && (errno == EMFILE || errno == ENFILE)) {
            refuse_starved(self);
            return;
        }
        if (fd < 0 && (errno == ECONNABORTED || errno == EINTR)) {
            continue;
        }
        if (fd < 0) {
            return;
        }
        if (!self->accept(self->user, fd, (struct sockaddr *)&address, size)) {
            close(fd);
        }
        if (pel_watch_spent_ns() > MOST_A_TURN_NS) {
            return; /* the rest in the next turn: the source is ready still */
        }
    }
}

static struct pel_listener *start(int fd, pel_listener_accept accept,
                                  void *user)
{
    struct pel_listener *self = g_new0(struct pel_listener, 1);
    self->fd = fd;
    self->spare = open_spare();
    self->accept = accept;
    self->user = user;
    self->source = pel_fdsource_create(fd, G_IO_IN, on_ready, self);
    return self;
}

static bool parse_address(const char *text, uint16_t port,
                          struct sockaddr_storage *out, socklen_t *size)
{
    memset(out, 0, sizeof *out);
    struct sockaddr_in *in = (struct sockaddr_in *)out;
    if (inet_pton(AF_INET, text, &in->sin_addr) == 1) {
        in->sin_family = AF_INET;
        in->sin_port = htons(port);
        *size = sizeof *in;
        return true;
    }
    struct sockaddr_in6 *in6 = (struct sockaddr_in6 *)out;
    if (inet_pton(AF_INET6, text, &in6->sin6_addr) == 1) {
        in6->sin6_family = AF_INET6;
        in6->sin6_port = htons(port);
        *size = sizeof *in6;
        return true;
    }
    return false;
}

static uint16_t bound_port(int fd)
{
    struct sockaddr_storage address = { 0 };
    socklen_t size = sizeof address;
    if (getsockname(fd, (struct sockaddr *)&address, &size) != 0) {
        return 0;
    }
    in_port_t port = 0;
    if (address.ss_family == AF_INET6) {
        struct sockaddr_in6 in6;
        memcpy(&in6, &address, sizeof in6);
        port = in6.sin6_port;
    } else {
        struct sockaddr_in in;
        memcpy(&in, &address, sizeof in);
        port = in.sin_port;
    }
    return ntohs(port);
}

enum pel_err pel_listener_tcp(const char *option, const char *address,
                              uint16_t port, bool allow_remote,
                              pel_listener_accept accept, void *user,
                              struct pel_listener **out,
                              struct pel_fault *fault)
{
    struct sockaddr_storage where;
    socklen_t size = 0;
    if (!parse_address(address, port, &where, &size)) {
        return pel_fault_set(fault, PEL_ERR_INVALID,
                             "%s: '%s' is not a numeric IPv4 or IPv6 address",
                             option, address);
    }
    if (!allow_remote && !pel_address_is_loopback((struct sockaddr *)&where)) {
        return pel_fault_set(
            fault, PEL_ERR_CONFLICT,
            "%s: %s would serve other machines without a password; bind "
            "127.0.0.1, or give a token",
            option, address);
    }
    if (pel_trial()) {
        *out = NULL;
        return pel_trial_listen(option + strlen("--"), SOCK_STREAM,
                                (struct sockaddr *)&where, size, fault);
    }
    int fd =
        socket(where.ss_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    int on = 1;
    if (fd < 0 ||
        setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on) != 0 ||
        bind(fd, (struct sockaddr *)&where, size) != 0 ||
        listen(fd, BACKLOG) != 0) {
        int why = errno;
        if (fd >= 0) {
            close(fd);
        }
        return pel_fault_set(
            fault, PEL_ERR_IO, "%s: cannot listen on %s port %u: %s%s", option,
            address, port, strerror(why),
            why == EADDRINUSE ? "; end what uses it, or name another port (0: "
                                "any that is free)"
                              : "");
    }
    *out = start(fd, accept, user);
    (*out)->port = bound_port(fd);
    return PEL_OK;
}

/* Whether a socket file is left over from a process that is gone. */
static bool socket_is_dead(const struct sockaddr_un *where)
{
    struct stat info;
    if (lstat(where->sun_path, &info) != 0 || !S_ISSOCK(info.st_mode)) {
        return false;
    }
    int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    if (fd < 0) {
        return false;
    }
    bool dead = connect(fd, (const struct sockaddr *)where, sizeof *where) &&
                errno == ECONNREFUSED;
    close(fd);
    return dead;
}

static int bind_unix(int fd, const struct sockaddr_un *where)
{
    const struct sockaddr *address = (const struct sockaddr *)where;
    int rc = bind(fd, address, sizeof *where);
    if (rc != 0 && errno == EADDRINUSE && socket_is_dead(where)) {
        unlink(where->sun_path);
        rc = bind(fd, address, sizeof *where);
    }
    return rc;
}

/* As a start would find it, but for a server that is there now: it may be the
 * one that is to be started again. */
static enum pel_err try_unix(const struct sockaddr_un *where,
                             struct pel_fault *fault)
{
    struct stat info;
    bool there = lstat(where->sun_path, &info) == 0;
    if (there && !S_ISSOCK(info.st_mode)) {
        return pel_fault_set(fault, PEL_ERR_CONFLICT,
                             "--unix: %s is no socket; name another path",
                             where->sun_path);
    }
    if (there && !socket_is_dead(where)) {
        pel_trial_note("--unix: %s is in use now; a daemon starts when it is "
                       "free",
                       where->sun_path);
    }
    return pel_trial_write("unix", where->sun_path, fault);
}

enum pel_err pel_listener_unix(const char *path, pel_listener_accept accept,
                               void *user, struct pel_listener **out,
                               struct pel_fault *fault)
{
    struct sockaddr_un where = { .sun_family = AF_UNIX };
    if (strlen(path) >= sizeof where.sun_path) {
        return pel_fault_set(fault, PEL_ERR_INVALID,
                             "--unix: the path is longer than %zu bytes: %s",
                             sizeof where.sun_path - 1, path);
    }
    memcpy(where.sun_path, path, strlen(path) + 1);
    if (pel_trial()) {
        *out = NULL;
        return try_unix(&where, fault);
    }
    int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    struct stat info;
    /* Nobody can connect before listen(), so the mode is set in time. */
    if (fd < 0 || bind_unix(fd, &where) != 0 || chmod(path, 0600) != 0 ||
        lstat(path, &info) != 0 || listen(fd, BACKLOG) != 0) {
        int why = errno;
        if (fd >= 0) {
            close(fd);
        }
        return pel_fault_set(
            fault, why == EADDRINUSE ? PEL_ERR_CONFLICT : PEL_ERR_IO,
            "--unix: cannot listen on %s: %s", path,
            why == EADDRINUSE ? "another server uses it, or it is no "
                                "socket; name another path"
                              : strerror(why));
    }
    *out = start(fd, accept, user);
    (*out)->path = g_strdup(path);
    (*out)->device = info.st_dev;
    (*out)->inode = info.st_ino;
    return PEL_OK;
}

void pel_listener_destroy(struct pel_listener *self)
{
    if (!self) {
        return;
    }
    pel_fdsource_destroy(self->source);
    close(self->fd);
    if (self->spare >= 0) {
        close(self->spare);
    }
    struct stat info;
    if (self->path && lstat(self->path, &info) == 0 &&
        info.st_dev == self->device && info.st_ino == self->inode) {
        unlink(self->path);
    }
    g_free(self->path);
    g_free(self);
}

uint16_t pel_listener_port(const struct pel_listener *self)
{
    return self ? self->port : 0;
}

uint64_t pel_listener_starved(const struct pel_listener *self)
{
    return self ? self->starved : 0;
}
