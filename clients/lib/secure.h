/* TLS on a connected socket, as a client. Private to libpelagos; one thread at
 * a time. */
#pragma once

#include <stddef.h>
#include <stdint.h>

#include "stream.h"

/* The variable that names a file of certificates to trust instead of the
 * system's: a self-made one. */
#define SECURE_CA_VARIABLE "PELAGOS_CA"

struct secure;

/* Shakes hands on fd (non-blocking, the caller's) and checks that the
 * certificate is for `host`, a name or an address. OK, or TIMEOUT or CLOSED
 * with the reason in `why`. */
enum stream_result secure_open(int fd, const char *host, int64_t deadline_ns,
                               struct secure **out, char *why, size_t why_size);
void secure_close(struct secure *secure); /* NULL allowed; the fd stays open */

/* All of the bytes. */
enum stream_result secure_send(struct secure *secure, const void *data,
                               size_t size, int64_t deadline_ns);

/* At least one byte; *got counts them. */
enum stream_result secure_receive(struct secure *secure, void *data,
                                  size_t size, int64_t deadline_ns,
                                  size_t *got);
