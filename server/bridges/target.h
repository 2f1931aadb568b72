/* Where a bridge sends to or connects to: HOST:PORT by number or by name. Names
 * are looked up by threads of GLib's, again while there is no answer (after 1
 * s, then twice as long each time, at most 30 s), each minute after that, and
 * soon after something could not be sent. Control thread. */
#pragma once

#include <stdbool.h>
#include <stdint.h>
#include <sys/socket.h>

#include "base/err.h"
#include "base/metrics.h"

struct pel_target;

struct pel_target_options {
    const char *option;          /* "cigi-host", in faults, log and metrics */
    const char *text;            /* HOST:PORT */
    int family;                  /* AF_INET or AF_INET6 alone; AF_UNSPEC */
    struct pel_metrics *metrics; /* may be NULL */
};

/* INVALID: no HOST:PORT, or a number of another family. A name that nobody
 * knows is no error (TGT-001). */
PEL_CHECK enum pel_err
pel_target_create(const struct pel_target_options *options,
                  struct pel_target **out, struct pel_fault *fault);
void pel_target_destroy(struct pel_target *target); /* NULL allowed */

/* NULL: the name is not resolved. Changes where the name moves; until the next
 * turn of the loop. */
const struct sockaddr *pel_target_address(const struct pel_target *target,
                                          socklen_t *size);

/* Nothing is there: its name is looked up again, once in 5 s. */
void pel_target_failed(struct pel_target *target);

/* As it was given. */
const char *pel_target_text(const struct pel_target *target);
