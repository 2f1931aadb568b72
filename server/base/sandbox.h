/* The sandbox of a process that reads files from people: what a file makes a
 * library do, it does behind these walls. Whoever reads such files closes it
 * around itself before it looks at the first byte.
 *
 * Files (Landlock): a list of places may be read, nothing may be written,
 * nothing started, no TCP port used. Calls (seccomp): a list of system calls
 * that reading and computing take; no sockets, no programs, no processes, no
 * opening for writing, no executable memory, no signals to others. Each holds
 * without the other. Also: no new privileges, no descriptors from before, an
 * end to processor time and memory, files of no bytes. */
#pragma once

#include <stddef.h>

#include "base/err.h"

#define PEL_SANDBOX_FILES 1u
#define PEL_SANDBOX_CALLS 2u
#define PEL_SANDBOX_ALL (PEL_SANDBOX_FILES | PEL_SANDBOX_CALLS)

struct pel_sandbox {
    /* What may be read: files, or directories with all below them; those that
     * do not exist are left out. NULL ends the list. */
    const char *const *readable;
    /* Those with relative names lie below it, by links that stay in it, as
     * pel_file_find_in says; NULL: what links lead to is readable. */
    const char *within;
    unsigned cpu_s;      /* processor time; ten times as much by the clock */
    size_t memory_bytes; /* of address space */
    unsigned walls;      /* those wanted: PEL_SANDBOX_ALL but in tests */
};

/* The walls that this system permits a process: the kernel has them, and no
 * supervisor forbids them. */
unsigned pel_sandbox_walls(void);

/* What is lost without the other walls, for the log; NULL: nothing. */
const char *pel_sandbox_lack(unsigned walls);

/* Closes it about the calling process, which must have one thread; for ever.
 * Closes descriptors from 3 on. Walls that the system does not have are left
 * out; one that it has and that cannot be built is IO. */
PEL_CHECK enum pel_err pel_sandbox_close(const struct pel_sandbox *sandbox,
                                         struct pel_fault *fault);
