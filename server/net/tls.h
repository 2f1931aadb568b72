/* TLS for the ports that have their own, protobuf and RTSP, by OpenSSL: no
 * connection has a thread, so none that is idle or slow in its handshake delays
 * another. Control thread. */
#pragma once

#include <stdbool.h>

#include "base/err.h"

struct pel_tls;

/* Loads a certificate (with its chain) and its key, PEM. Errors: IO or INVALID
 * (the files), CONFLICT (the key's permissions, as pel_token_check_file). */
PEL_CHECK enum pel_err pel_tls_create(const char *cert_path,
                                      const char *key_path,
                                      struct pel_tls **out,
                                      struct pel_fault *fault);

/* Closes what is open. NULL allowed. */
void pel_tls_destroy(struct pel_tls *tls);

/* Reads the files again, for connections to come; on an error the old ones
 * stay. */
PEL_CHECK enum pel_err pel_tls_reload(struct pel_tls *tls,
                                      struct pel_fault *fault);

/* Serves TLS on the TCP socket fd, which it takes over, and returns the plain
 * end: a non-blocking stream socket of the caller's; -1 without descriptors.
 * What the caller wrote before closing it still goes out; the client's end is
 * the plain end's. It is a TCP socket where `inet` is true and one can be
 * had at once, for callers that ask a socket for its IP address, else a Unix
 * one. The handshake may take `handshake_s`, a reader that takes nothing
 * `stall_s` seconds. */
int pel_tls_serve(struct pel_tls *tls, int fd, bool inet, double handshake_s,
                  double stall_s);

/* Told once, in a later turn: the handshake is done and `plain` is the
 * caller's, or (−1) the client has left, or was sent away. */
typedef void (*pel_tls_ready)(void *user, int plain);

/* The same for callers to whom a connection is nothing before its handshake is
 * done. False: without descriptors, and `ready` is not called. */
bool pel_tls_serve_later(struct pel_tls *tls, int fd, bool inet,
                         double handshake_s, double stall_s,
                         pel_tls_ready ready, void *user);
/* How many of them are in their handshake. */
unsigned pel_tls_shaking(const struct pel_tls *tls, pel_tls_ready ready);
/* Sends one of them away: of those who are silent the one that came first, else
 * of all. False: there is none. */
bool pel_tls_make_room(struct pel_tls *tls, pel_tls_ready ready);
