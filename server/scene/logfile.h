/* A command log read from its file by a window, however long it is: 256 KiB, or
 * twice the longest entry that came by, 8 MiB with PEL_LOG_MAX_ENTRY. It waits
 * for the disk: any thread but the control thread, one at a time. */
#pragma once

#include <stdint.h>

#include "base/err.h"
#include "pelog.h"

struct pel_logfile;

/* Reads a log as long as it is now: what is written later is not read. Faults
 * as of pel_file_open and pel_log_open. */
PEL_CHECK enum pel_err pel_logfile_open(const char *path,
                                        struct pel_logfile **out,
                                        struct pel_fault *fault);
/* The same of a descriptor, which it closes, also where it fails. */
PEL_CHECK enum pel_err pel_logfile_take(int fd, struct pel_logfile **out,
                                        struct pel_fault *fault);
void pel_logfile_close(struct pel_logfile *file); /* NULL allowed */

/* As pel_log_next. IO; NO_MEMORY. */
PEL_CHECK enum pel_err pel_logfile_next(struct pel_logfile *file,
                                        Pelagos__LogEntry **out,
                                        struct pel_fault *fault);

/* Where a log goes on. */
struct pel_logfile_place {
    uint64_t at;    /* byte of the next entry */
    size_t entries; /* before it */
    double time_s;  /* after the last one */
};

struct pel_logfile_place pel_logfile_place(const struct pel_logfile *file);
/* To a place that this log gave. */
void pel_logfile_go(struct pel_logfile *file, struct pel_logfile_place place);

/* Simulated time of the last entry that is whole, from the file's end where the
 * log has checksums. MALFORMED: there is none. */
PEL_CHECK enum pel_err pel_logfile_last(struct pel_logfile *file, double *out,
                                        struct pel_fault *fault);
