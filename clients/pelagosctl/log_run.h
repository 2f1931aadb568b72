/* The segments of a command log, found fit to be replayed one after the
 * other. */
#pragma once

#include <glib.h>

#include "pelagosctl/ctl.h"

struct log_segment {
    const char *name;
    GMappedFile *map;
    const char *data;
    size_t size;
    char *recording; /* NULL: of a program that did not write it */
    uint32_t segment;
};

struct log_run {
    size_t count;
    struct log_segment *segments; /* in order */
};

/* Whether the file at `name` begins as a command log does. */
bool log_run_is(const char *name);

/* Reads every file once without playing: what cannot be read to its end, what
 * is not of one recording, and what has a gap is refused, in words, before
 * anything is changed. The order of the names does not matter. */
enum ctl_exit log_run_open(const char *const *names, size_t count,
                           struct log_run *out);
void log_run_finish(struct log_run *run);
