/* Command logs: what `pelagosd --record` and its journal write, and `pelagosctl
 * replay` plays. The form is in proto/pelog.md. Any thread. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/err.h"
#include "pelagos.pb-c.h"

/* The first bytes of every log, and of those without checksums. */
#define PEL_LOG_MAGIC "PELOG2\r\n"
#define PEL_LOG_MAGIC_BEFORE "PELOG1\r\n"
#define PEL_LOG_MAGIC_SIZE 8
#define PEL_LOG_FORM 2
#define PEL_LOG_BEGIN_SIZE 32        /* bytes before the first entry */
#define PEL_LOG_FRAME_SIZE 16        /* bytes before each entry */
#define PEL_LOG_COUNT_AT 16          /* where pel_log_count goes */
#define PEL_LOG_COUNT_SIZE 16        /* and how long it is */
#define PEL_LOG_VERSION 1            /* of what a daemon by itself writes */
#define PEL_LOG_VERSION_STATES 2     /* whole states may follow the head */
#define PEL_LOG_MAX_ENTRY (4u << 20) /* bytes of one entry */

/* Whether these are the first bytes of a command log. */
bool pel_log_is(const void *data, size_t size);

/* How many bytes of a log its head takes, by the first 64 of them or as many as
 * it has; 0: it is no log. */
size_t pel_log_head_bytes(const void *data, size_t size);

/* --- reading -------------------------------------------------------------- */

/* The parts that a mending reader passed over. */
struct pel_log_damage {
    unsigned places; /* where bytes are no entry; 0: no damage */
    size_t at;       /* the first of them */
    size_t bytes;    /* in all places */
    unsigned lost;   /* entries, by the numbers of those behind them and by
                      * the count that a journal keeps */
    unsigned twice;  /* entries that are there again */
    bool more;       /* and perhaps others, behind the last one */
    char reason[80]; /* of the first place */
};

/* The place of a reader in a log that is in memory and outlives it. */
struct pel_log_reader {
    const uint8_t *data;
    size_t size, at;
    uint64_t base;    /* of a file's part: its bytes before `data` */
    unsigned form;    /* 1: without checksums */
    uint8_t tag[4];   /* of this file's entries */
    uint32_t number;  /* of the next entry, of one that mends */
    uint32_t counted; /* entries that a journal says it has; 0: unknown */
    size_t entries;   /* read so far */
    double time_s;    /* of the last one */
    bool torn;        /* the file ends inside an entry, which is left out */
    bool mends;       /* passes over what is damaged: pel_log_mend */
    struct pel_log_damage damage;
};

/* MALFORMED: not a command log. CONFLICT: one of a newer version. */
PEL_CHECK enum pel_err pel_log_open(struct pel_log_reader *reader,
                                    const void *data, size_t size,
                                    struct pel_fault *fault);

/* The same, to read what can be read: a damaged entry is passed over, and what
 * follows it is found by its tag and its checksum. Without checksums the rest
 * is lost. */
PEL_CHECK enum pel_err pel_log_mend(struct pel_log_reader *reader,
                                    const void *data, size_t size,
                                    struct pel_fault *fault);

/* The next entry into *out, NULL at the end; pelagos__log_entry__free_unpacked.
 * The first is the head, the only one, with version 1 or 2 and a whole state;
 * every entry has a command and a finite time within 0..1e9, not before the
 * last one's unless a patch of clock.time led back, or it is a whole state
 * after frames that are missing. MALFORMED, with the number of the entry and
 * its place, otherwise: nothing after it can be trusted. CONFLICT: the head is
 * of a newer version. One that mends gives every entry that is whole, the head
 * or none first, and has no MALFORMED. */
PEL_CHECK enum pel_err pel_log_next(struct pel_log_reader *reader,
                                    Pelagos__LogEntry **out,
                                    struct pel_fault *fault);

/* Passes over one entry, whose bytes are *data; false: the end, or damage. */
bool pel_log_skip(struct pel_log_reader *reader, const uint8_t **data,
                  size_t *size);

/* How many bytes the next entry has, with what is before it, by what of it is
 * there; 0: it is none, or too little of it is there to tell. */
size_t pel_log_entry_bytes(const struct pel_log_reader *reader);

/* The last whole entry that begins within the first `within` bytes, found by
 * the tag of a log with checksums; false: there is none. */
bool pel_log_last(const struct pel_log_reader *reader, size_t within,
                  const uint8_t **data, size_t *size);

/* --- writing -------------------------------------------------------------- */

struct pel_log_writer {
    uint8_t tag[4]; /* random, so that no value of a client looks like an
                     * entry of this file */
    uint32_t count; /* entries so far */
};

/* Begins a log: the bytes before its first entry. */
void pel_log_begin(struct pel_log_writer *writer,
                   uint8_t out[PEL_LOG_BEGIN_SIZE]);

/* Entries as the log has them, from messages that each have their length before
 * them as a varint (scene/logentry.h); free(). */
uint8_t *pel_log_frame(struct pel_log_writer *writer, const uint8_t *messages,
                       size_t size, size_t *out_size);

/* How many entries there are, at PEL_LOG_COUNT_AT of the file: by it a log
 * that was cut between two entries is known. */
void pel_log_count(const struct pel_log_writer *writer,
                   uint8_t out[PEL_LOG_COUNT_SIZE]);
