/* Files: reading those that others name or write, and writing whole. Only
 * regular files are opened, and without blocking: a FIFO, a device or a
 * directory in a file's place is a fault in words, never a thread that hangs.
 * Any thread. */
#pragma once

#include <stdbool.h>
#include <stddef.h>

#include "base/err.h"

/* Opens a regular file for reading; close(*out) is the caller's. NOT_FOUND,
 * INVALID (no regular file), IO: *fault (NULL allowed) says what and where. */
PEL_CHECK enum pel_err pel_file_open(const char *path, int *out,
                                     struct pel_fault *fault);

/* The whole of a regular file of at most `most` bytes, which stops growing
 * while it is read, with a NUL behind it; free(*out). Faults as of
 * pel_file_open, OUT_OF_RANGE (larger), NO_MEMORY. */
PEL_CHECK enum pel_err pel_file_read(const char *path, size_t most, char **out,
                                     size_t *size, struct pel_fault *fault);

/* What is at `name`, a path below a directory of ours: a descriptor for
 * fstat() and openat(), which reads nothing (O_PATH). Links that stay in the
 * directory are followed; INVALID: one leads out. Whoever may change the
 * directory meanwhile brings nothing in from outside: what was opened is
 * judged, not its name. NOT_FOUND, IO. */
PEL_CHECK enum pel_err pel_file_find_in(const char *directory, const char *name,
                                        int *out, struct pel_fault *fault);

/* As pel_file_open and pel_file_read, of what pel_file_find_in finds. */
PEL_CHECK enum pel_err pel_file_open_in(const char *directory, const char *name,
                                        int *out, struct pel_fault *fault);
PEL_CHECK enum pel_err pel_file_read_in(const char *directory, const char *name,
                                        size_t most, char **out, size_t *size,
                                        struct pel_fault *fault);

/* Writes all of it, however often the system takes part of it; false: errno.
 * What was written till then is in the file. */
PEL_CHECK bool pel_file_write(int fd, const void *data, size_t size);
