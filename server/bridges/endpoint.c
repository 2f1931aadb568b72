#include "bridges/endpoint.h"

#include <arpa/inet.h>
#include <errno.h>
#include <netinet/in.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/trial.h"

static const uint8_t mapped_prefix[12] = { [10] = 0xff, [11] = 0xff };

/* Reads a decimal number of 0..limit that is the whole text. */
static bool read_number(const char *text, long limit, long *out)
{
    char *end;
    if (*text < '0' || *text > '9') {
        return false;
    }
    errno = 0;
    *out = strtol(text, &end, 10);
    return errno == 0 && *end == 0 && *out <= limit;
}

static bool read_rule(char *text, uint8_t address[16], int *bits)
{
    char *slash = strchr(text, '/');
    long width = -1;
    if (slash) {
        *slash = 0;
        if (!read_number(slash + 1, 128, &width)) {
            return false;
        }
    }
    if (inet_pton(AF_INET, text, address + 12) == 1) {
        memcpy(address, mapped_prefix, sizeof mapped_prefix);
        *bits = (int)(width < 0 ? 128 : width + 96);
        return width <= 32;
    }
    *bits = (int)(width < 0 ? 128 : width);
    return inet_pton(AF_INET6, text, address) == 1;
}

enum pel_err pel_allow_parse(const char *text, struct pel_allow *out,
                             struct pel_fault *fault)
{
    *out = (struct pel_allow){ 0 };
    if (!text || !*text) {
        text = "127.0.0.0/8,::1";
    }
    while (*text) {
        size_t length = strcspn(text, ", ");
        char entry[64];
        if (length >= sizeof entry || out->count == PEL_MAX_ALLOWED) {
            return pel_fault_set(fault, PEL_ERR_INVALID,
                                 "the list of allowed addresses takes at most "
                                 "%d of at most %zu characters",
                                 PEL_MAX_ALLOWED, sizeof entry - 1);
        }
        memcpy(entry, text, length);
        entry[length] = 0;
        if (length > 0) {
            if (!read_rule(entry, out->rules[out->count].address,
                           &out->rules[out->count].bits)) {
                return pel_fault_set(fault, PEL_ERR_INVALID,
                                     "%.*s is no address or network; write "
                                     "10.0.0.7 or 192.168.1.0/24",
                                     (int)length, text);
            }
            out->count++;
        }
        text += length + (text[length] != 0);
    }
    return PEL_OK;
}

static bool to_bytes(const struct sockaddr *peer, uint8_t out[16])
{
    if (peer->sa_family == AF_INET) {
        const struct sockaddr_in *v4 = (const struct sockaddr_in *)peer;
        memcpy(out, mapped_prefix, sizeof mapped_prefix);
        memcpy(out + 12, &v4->sin_addr, 4);
        return true;
    }
    if (peer->sa_family == AF_INET6) {
        const struct sockaddr_in6 *v6 = (const struct sockaddr_in6 *)peer;
        memcpy(out, &v6->sin6_addr, 16);
        return true;
    }
    return false;
}

bool pel_allow_has(const struct pel_allow *allow, const struct sockaddr *peer)
{
    uint8_t address[16];
    if (!to_bytes(peer, address)) {
        return false;
    }
    for (size_t i = 0; i < allow->count; i++) {
        int bits = allow->rules[i].bits;
        const uint8_t *rule = allow->rules[i].address;
        size_t whole = (size_t)bits / 8;
        uint8_t mask = (uint8_t)(0xff00 >> bits % 8);
        if (memcmp(address, rule, whole) == 0 &&
            (whole == 16 || ((address[whole] ^ rule[whole]) & mask) == 0)) {
            return true;
        }
    }
    return false;
}

/* "HOST:PORT" or "[HOST]:PORT" to a socket address. */
bool pel_endpoint_read(const char *text, struct sockaddr_storage *out,
                       socklen_t *size)
{
    const char *colon = strrchr(text, ':');
    char host[64];
    long port;
    if (!colon || (size_t)(colon - text) >= sizeof host ||
        !read_number(colon + 1, 65535, &port)) {
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
