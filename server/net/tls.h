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
