/* Where a bridge listens, and to whom: ADDRESS:PORT and lists of allowed
 * peers. Modbus and NMEA know neither passwords nor TLS, so the list is all
 * they have. Any thread. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <sys/socket.h>

#include "base/allow.h"
#include "base/err.h"

/* Opens a non-blocking, close-on-exec socket of `type` (SOCK_STREAM is put to
 * listen) on `address` ("127.0.0.1:1502", "[::1]:1502", "localhost:0"); its
 * port goes to *port. INVALID: unreadable, or not loopback while `list` is
 * NULL or empty; IO: the system refused. `what` names the option in faults. */
PEL_CHECK enum pel_err pel_endpoint_open(const char *what, const char *address,
                                         const char *list, int type, int *fd,
                                         uint16_t *port,
                                         struct pel_fault *fault);
