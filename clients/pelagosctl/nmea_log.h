/* A log of NMEA 0183 sentences with the pace they came at. */
#pragma once

#include <stdbool.h>
#include <stddef.h>

struct nmea_line {
    const char *text; /* without its line end */
    size_t length;
    double time_s; /* since the start of the log */
};

struct nmea_log {
    char *bytes;
    struct nmea_line *lines;
    size_t count;
    bool stamped;      /* paced by time stamps, else by repetition */
    double duration_s; /* with a step after the last group */
};

/* Reads the sentences ($… and !…) of a text of `size` bytes. One kind of
 * sentence sets the pace: the first of RMC, GGA, GLL, ZDA that is there with
 * times. Each new time starts a group; a step back or of more than ten minutes
 * (a gap, midnight aside) counts as one second. Without any time a group ends
 * where the first kind of sentence comes again, and lasts one second. */
void nmea_log_read(const char *text, size_t size, struct nmea_log *out);
void nmea_log_finish(struct nmea_log *log);
