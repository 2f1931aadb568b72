/* How a process begins and ends that reads a file from people (base/helper.h
 * starts it): behind the sandbox's walls, with a sentence on standard error
 * where it refuses. One thread. */
#pragma once

#include <stdbool.h>
#include <stddef.h>

struct pel_reader {
    const char *directory; /* becomes the working directory; NULL: stays */
    const char *const *readable; /* in it, or whole paths; ends with NULL */
    unsigned cpu_s;
    size_t memory_bytes; /* of address space */
};

/* Into the directory, and all walls of base/sandbox.h closed behind us. Ends
 * the process where that cannot be. */
void pel_reader_begin(const struct pel_reader *reader);

/* Ends with status 1. */
_Noreturn void pel_reader_refuse(const char *why);

/* Ends with status 0 if all was `written` to standard output, without tidying
 * up, which the system does faster; else refuses with errno's words. */
_Noreturn void pel_reader_end(bool written);
