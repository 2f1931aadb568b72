/* Helpers: programs of our own, one process a task, that read what comes from
 * people (server/base/sandbox.h) and answer in bytes. The daemon starts one
 * for a file and throws it away: what the file makes a library do, crash or
 * take, it does there. Any thread; waits. */
#pragma once

#include <stddef.h>

#include "base/err.h"

struct pel_helper_task {
    const char *program; /* beside ours, or in ../libexec/pelagos */
    char *const *argv;   /* NULL-terminated, with its name first */
    const char *subject; /* what it reads, for the words of faults */
    const void *input;   /* on its standard input; NULL: nothing */
    size_t input_size;
    size_t most_bytes; /* of its answer */
    int within_ms;
};

/* Runs it to its end; free(*out), NULL on failure. It gets no descriptors but
 * the null device or its input, the pipes, and of the environment only what
 * libraries look for their own files by. IO: it cannot be started. INVALID: it
 * refuses, and *fault has its words; it crashed, or took too long or too many
 * bytes. */
PEL_CHECK enum pel_err pel_helper_run(const struct pel_helper_task *task,
                                      unsigned char **out, size_t *size,
                                      struct pel_fault *fault);

/* Whether there is a file that a user calls `file` in a directory of ours:
 * names joined by single /, none with a dot or a dash before it. INVALID
 * (another form; a link out of the directory), NOT_FOUND (no regular file). It
 * may be another one by the time a helper opens it: see base/reader.h. */
PEL_CHECK enum pel_err pel_helper_find(const char *directory, const char *file,
                                       struct pel_fault *fault);
