/* Listening sockets: bind to loopback unless remote clients are allowed, and
 * accept without busy waiting, even when descriptors run out. */
#pragma once

#include <stdbool.h>
#include <stdint.h>
#include <sys/socket.h>

#include "base/err.h"

/* Why a client was turned away. */
enum pel_refusal {
    PEL_REFUSAL_LIMIT,       /* the owner refused */
    PEL_REFUSAL_DESCRIPTORS, /* the process has no descriptor left */
};

/* A client arrived: non-blocking, close-on-exec. Return false to have it
 * closed (the owner may have written a few bytes to it first). */
typedef bool (*pel_listener_accept)(void *user, int fd,
                                    const struct sockaddr *address,
                                    socklen_t size);

struct pel_listener;

/* TCP on a numeric address. Errors: INVALID (not an address), CONFLICT (not
 * loopback and allow_remote false; `option` names the option in the message),
 * IO (bind). */
PEL_CHECK enum pel_err pel_listener_tcp(const char *option, const char *address,
                                        uint16_t port, bool allow_remote,
                                        pel_listener_accept accept, void *user,
                                        struct pel_listener **out,
                                        struct pel_fault *fault);

/* Unix stream socket with mode 0600. A socket without a listener is replaced;
 * CONFLICT if one does, or if the path is something else. */
PEL_CHECK enum pel_err pel_listener_unix(const char *path,
                                         pel_listener_accept accept, void *user,
                                         struct pel_listener **out,
                                         struct pel_fault *fault);

/* Where descriptors run out: ends a client of the owner's that may do less than
 * others, soon; false: there is none. Without it newcomers are closed. */
void pel_listener_on_starved(struct pel_listener *listener,
                             bool (*make_room)(void *user));

void pel_listener_destroy(struct pel_listener *listener); /* NULL allowed */

/* Port bound; 0 for a Unix socket. */
uint16_t pel_listener_port(const struct pel_listener *listener);

/* Clients refused for lack of descriptors, since the start. */
uint64_t pel_listener_starved(const struct pel_listener *listener);

/* True for 127.0.0.0/8, ::1, IPv4-mapped loopback and Unix sockets. */
bool pel_address_is_loopback(const struct sockaddr *address);
