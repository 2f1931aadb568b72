/* Reading command logs: what `pelagosd --record` writes and `pelagosctl
 * replay` plays. The form is in proto/pelog.md. Any thread. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/err.h"
#include "pelagos.pb-c.h"

/* The first bytes of every log. */
#define PEL_LOG_MAGIC "PELOG1\r\n"
#define PEL_LOG_MAGIC_SIZE 8
#define PEL_LOG_VERSION 1            /* of what a daemon by itself writes */
#define PEL_LOG_VERSION_STATES 2     /* whole states may follow the head */
#define PEL_LOG_MAX_ENTRY (4u << 20) /* bytes of one entry */

/* Whether these are the first bytes of a command log. */
bool pel_log_is(const void *data, size_t size);

/* The place of a reader in a log that is in memory and outlives it. */
struct pel_log_reader {
    const uint8_t *data;
    size_t size, at;
    size_t entries; /* read so far */
    double time_s;  /* of the last one */
    bool torn;      /* the file ends inside an entry, which is left out */
};

/* MALFORMED: not a command log. CONFLICT: one of a newer version. */
PEL_CHECK enum pel_err pel_log_open(struct pel_log_reader *reader,
                                    const void *data, size_t size,
                                    struct pel_fault *fault);

/* The next entry into *out, NULL at the end; pelagos__log_entry__free_unpacked.
 * The first is the head, the only one, with version 1 or 2 and a whole state;
 * every entry has a command and a finite time within 0..1e9, not before the
 * last one's unless a patch of clock.time led back, or it is a whole state
 * after frames that are missing. MALFORMED, with the number of the entry,
 * otherwise: nothing after it can be trusted. CONFLICT: the head is of a newer
 * version. */
PEL_CHECK enum pel_err pel_log_next(struct pel_log_reader *reader,
                                    Pelagos__LogEntry **out,
                                    struct pel_fault *fault);
