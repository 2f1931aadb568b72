#include "bridges/endpoint.h"

#include <errno.h>
#include <netinet/in.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "base/hostport.h"
#include "base/trial.h"

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
    char host[PEL_HOST_SIZE];
    socklen_t size;
    if (pel_hostport_split(address, host, port) != PEL_HOST_NUMBER ||
        !pel_hostport_address(host, *port, AF_UNSPEC, &name, &size)) {
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
