/* TLS for the ports that have their own: the protobuf port (by OpenSSL, here)
 * and RTSP (by GIO, in gst-rtsp-server). Control thread. */
#pragma once

#include <gio/gio.h>

#include "base/err.h"

struct pel_tls;

/* Loads a certificate (with its chain) and its key, PEM. Errors: NOT_FOUND (GIO
 * has no TLS), IO or INVALID (the files), CONFLICT (the key's permissions, as
 * pel_token_check_file). */
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

/* For GIO; lives until the next reload. */
GTlsCertificate *pel_tls_certificate(const struct pel_tls *tls);

/* Serves TLS on the TCP socket fd, which it takes over, and returns the plain
 * end: a non-blocking stream socket of the caller's; -1 without descriptors.
 * What the caller wrote before closing it still goes out; the client's end is
 * the plain end's. The handshake may take `handshake_s`, a reader that takes
 * nothing `stall_s` seconds. */
int pel_tls_serve(struct pel_tls *tls, int fd, double handshake_s,
                  double stall_s);
