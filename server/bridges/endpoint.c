#include "bridges/endpoint.h"

#include <arpa/inet.h>
#include <errno.h>
#include <glib.h>
#include <netinet/in.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "base/trial.h"

/* "HOST:PORT" or "[HOST]:PORT" to a socket address. */
bool pel_endpoint_read(const char *text, struct sockaddr_storage *out,
                       socklen_t *size)
{
    const char *colon = strrchr(text, ':');
    char host[64];
    guint64 port;
    if (!colon || (size_t)(colon - text) >= sizeof host ||
        !g_ascii_string_to_unsigned(colon + 1, 10, 0, 65535, &port, NULL)) {
        return false;
    }
    size_t length = (size_t)(colon - text);
    bool bracket = length > 2 && text[0] == '[' && colon[-1] == ']';
    memcpy(host, text + bracket, length - 2 * bracket);
    host[length - 2 * bracket] = 0;
    if (strcmp(host, "localhost") == 0 || length == 0) {
        strcpy(host, "127.0.0.1");
    }
    *out = (struct sockaddr_storage){ 0 };
    struct sockaddr_in *v4 = (struct sockaddr_in *)out;
    struct sockaddr_in6 *v6 = (struct sockaddr_in6 *)out;
    if (!bracket && inet_pton(AF_INET, host, &v4->sin_addr) == 1) {
        v4->sin_family = AF_INET;
        v4->sin_port = htons((uint16_t)port);
        *size = sizeof *v4;
        return true;
    }
    v6->sin6_family = AF_INET6;
    v6->sin6_port = htons((uint16_t)port);
    *size = sizeof *v6;
    return bracket && inet_pton(AF_INET6, host, &v6->sin6_addr) == 1;
}

static uint16_t port_of(int fd)
{
    union {
        struct sockaddr any;
        struct sockaddr_in v4;
        struct sockaddr_in6 v6;
    } name = { .v6 = { 0 } };
    socklen_t size = sizeof name;
    if (getsockname(fd, &name.any, &size) != 0) {
        return 0;
    }
    return ntohs(name.any.sa_family == AF_INET ? name.v4.sin_port
                                               : name.v6.sin6_port);
}

enum pel_err pel_endpoint_open(const char *what, const char *address,
                               const char *list, int type, int *fd,
                               uint16_t *port, struct pel_fault *fault)
{
    struct sockaddr_storage name;
    socklen_t size;
    if (!pel_endpoint_read(address, &name, &size)) {
        return pel_fault_set(
            fault, PEL_ERR_INVALID,
            "--%s: %s is no ADDRESS:PORT; write 127.0.0.1:1502 "
            "or [::1]:1502",
            what, address);
    }
    struct pel_allow loopback;
    enum pel_err err = pel_allow_parse(NULL, &loopback, fault);
    if (err) {
        return err;
    }
    if (!pel_allow_has(&loopback, (struct sockaddr *)&name) &&
        (!list || !*list)) {
        return pel_fault_set(
            fault, PEL_ERR_INVALID,
            "--%s: %s can be reached from other machines, and "
            "this protocol has no password: set --%.*s-allow to "
            "the addresses that may send",
            what, address, (int)strcspn(what, "-"), what);
    }
    bool trial = pel_trial();
    if (trial) {
        err =
            pel_trial_listen(what, type, (struct sockaddr *)&name, size, fault);
        if (err) {
            return err;
        }
    }
    int s = socket(name.ss_family, type | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    int yes = 1;
    if (s < 0 ||
        (type == SOCK_STREAM &&
         setsockopt(s, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes) != 0) ||
        (!trial && (bind(s, (struct sockaddr *)&name, size) != 0 ||
                    (type == SOCK_STREAM && listen(s, 64) != 0)))) {
        err = pel_fault_set(
            fault, PEL_ERR_IO, "--%s: cannot listen on %s: %s%s", what, address,
            strerror(errno),
            errno == EADDRINUSE ? "; end what uses it, or name another port"
                                : "");
        if (s >= 0) {
            close(s);
        }
        return err;
    }
    *fd = s;
    *port = port_of(s);
    return PEL_OK;
}
