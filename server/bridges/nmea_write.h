/* Sentences of NMEA 0183, written one after the other. Pure functions on the
 * caller's memory. */
#pragma once

#include <stddef.h>

/* Room for `size` bytes at `out`. */
struct pel_nmea_writer {
    char *out;
    size_t size, used, count; /* bytes, sentences */
};

/* Appends `start` ('$' or '!'), the body, its sum and the line's end; a
 * sentence of more than 82 characters, or that does not fit, is left out. */
void pel_nmea_say(struct pel_nmea_writer *w, char start, const char *format,
                  ...) __attribute__((format(printf, 3, 4)));

/* deg: 0 to less than 360, also after it is rounded to a tenth. */
double pel_nmea_bearing(double degrees);
