#include "base/reader.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/sandbox.h"

void pel_reader_begin(const struct pel_reader *reader)
{
    const struct pel_sandbox sandbox = { .readable = reader->readable,
                                         .within =
                                             reader->directory ? "." : NULL,
                                         .cpu_s = reader->cpu_s,
                                         .memory_bytes = reader->memory_bytes,
                                         .walls = PEL_SANDBOX_ALL };
    struct pel_fault fault = { 0 };
    if (reader->directory && chdir(reader->directory)) {
        pel_fault_set(&fault, PEL_ERR_IO, "%.160s: %s", reader->directory,
                      strerror(errno));
        pel_reader_refuse(fault.message);
    }
    if (pel_sandbox_close(&sandbox, &fault)) {
        pel_reader_refuse(fault.message);
    }
}

void pel_reader_refuse(const char *why)
{
    fprintf(stderr, "%s\n", why);
    fflush(stderr);
    _Exit(1);
}

void pel_reader_end(bool written)
{
    if (!written || fflush(stdout)) {
        pel_reader_refuse(strerror(errno));
    }
    fflush(stderr);
    _Exit(0);
}
