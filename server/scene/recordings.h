/* Command logs in a directory, by what their heads say. They wait for the
 * disk: any thread but the control thread. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/err.h"
#include "scene/logfile.h"

/* Of a log, and of all of a recording, to be played. */
#define PEL_RECORDING_SEGMENT_BYTES ((size_t)256 << 20)
#define PEL_RECORDING_BYTES ((uint64_t)1 << 30)
#define PEL_RECORDING_SUFFIX ".pelog" /* of the file of one begun by name */
#define PEL_RECORDINGS_LISTED 1000

struct pel_recording_segment {
    char *path;                                 /* in the directory */
    char *recording, *began, *program, *device; /* of its head; NULL: none */
    uint32_t number, waves;
    uint64_t bytes;
    double from_s; /* simulated, of its head */
};

/* Segments without a gap, as they follow each other. */
struct pel_recording {
    size_t count;
    struct pel_recording_segment *segments;
    uint64_t bytes;
    double to_s; /* simulated, of the last entry; of its head where that is
                  * not known, see `why` */
    char *why;   /* it cannot be played; NULL: nothing known against it */
};

struct pel_recordings {
    size_t count;
    struct pel_recording *items; /* the newest first */
    bool more; /* than PEL_RECORDINGS_LISTED files: the rest is left out */
};

/* What lies there; files that are no logs are passed over. NOT_FOUND, IO: the
 * directory. pel_recordings_finish. */
PEL_CHECK enum pel_err pel_recordings_list(const char *directory,
                                           struct pel_recordings *out,
                                           struct pel_fault *fault);
void pel_recordings_finish(struct pel_recordings *recordings);

/* The recording that `name` is of: a file of the directory without its path,
 * with its suffix or without, or what its segments have in common,
 * LogHead.recording. NOT_FOUND; INVALID: no name of a file; OUT_OF_RANGE:
 * longer than PEL_RECORDING_BYTES. pel_recording_finish. */
PEL_CHECK enum pel_err pel_recording_find(const char *directory,
                                          const char *name,
                                          struct pel_recording *out,
                                          struct pel_fault *fault);
void pel_recording_finish(struct pel_recording *recording);

/* The log of a segment; OUT_OF_RANGE: it is longer than
 * PEL_RECORDING_SEGMENT_BYTES; else as pel_logfile_open. */
PEL_CHECK enum pel_err
pel_recording_open(const struct pel_recording_segment *segment,
                   struct pel_logfile **out, struct pel_fault *fault);
