#include "pelagosctl/nmea_log.h"

#include <math.h>
#include <string.h>

#include <glib.h>

#define DAY_S 86400.0
#define MAX_STEP_S 600.0

/* Kinds of sentence with a time, by preference, and the field it is in. */
static const struct {
    const char *kind;
    int field;
} stamps[] = { { "RMC", 1 }, { "GGA", 1 }, { "GLL", 5 }, { "ZDA", 1 } };

/* "$GPRMC,…": the three letters after the talker. */
static bool is_kind(const struct nmea_line *line, const char *kind)
{
    return line->length > 6 && line->text[0] == '$' &&
           memcmp(line->text + 3, kind, 3) == 0;
}

/* hhmmss[.s…] in field `number`, in seconds; NAN: none. */
static double read_time(const struct nmea_line *line, int number)
{
    const char *at = line->text, *end = line->text + line->length;
    for (; number > 0 && at; number--) {
        at = memchr(at, ',', (size_t)(end - at));
        at = at ? at + 1 : NULL;
    }
    if (!at || end - at < 6) {
        return NAN;
    }
    int digits[6];
    for (int i = 0; i < 6; i++) {
        if (!g_ascii_isdigit(at[i])) {
            return NAN;
        }
        digits[i] = at[i] - '0';
    }
    double seconds = digits[0] * 36000 + digits[1] * 3600 + digits[2] * 600 +
                     digits[3] * 60 + digits[4] * 10 + digits[5];
    double place = 0.1;
    if (end - at > 6 && at[6] == '.') {
        for (at += 7; at < end && g_ascii_isdigit(*at); at++, place /= 10) {
            seconds += place * (*at - '0');
        }
    }
    return seconds;
}

/* The kind that sets the pace; -1: none has a time. */
static int find_stamp(const struct nmea_log *log)
{
    for (size_t s = 0; s < G_N_ELEMENTS(stamps); s++) {
        for (size_t i = 0; i < log->count; i++) {
            if (is_kind(&log->lines[i], stamps[s].kind) &&
                !isnan(read_time(&log->lines[i], stamps[s].field))) {
                return (int)s;
            }
        }
    }
    return -1;
}

static double step_between(double before, double after)
{
    double step = after - before;
    if (step < -DAY_S / 2) {
        step += DAY_S;
    }
    return step < 0 || step > MAX_STEP_S ? 1.0 : step;
}

static void pace_by_stamps(struct nmea_log *log, int stamp)
{
    double now = 0.0, last = NAN, step = 1.0;
    for (size_t i = 0; i < log->count; i++) {
        struct nmea_line *line = &log->lines[i];
        if (is_kind(line, stamps[stamp].kind)) {
            double time_s = read_time(line, stamps[stamp].field);
            if (!isnan(time_s) && !isnan(last) && time_s != last) {
                step = step_between(last, time_s);
                now += step;
            }
            last = isnan(time_s) ? last : time_s;
        }
        line->time_s = now;
    }
    log->duration_s = log->count > 0 ? now + step : 0.0;
}

/* Length of the address field, "$GPHDT". */
static size_t address_length(const struct nmea_line *line)
{
    const char *comma = memchr(line->text, ',', line->length);
    return comma ? (size_t)(comma - line->text) : line->length;
}

static void pace_by_repetition(struct nmea_log *log)
{
    double now = 0.0;
    for (size_t i = 0; i < log->count; i++) {
        struct nmea_line *line = &log->lines[i], *first = &log->lines[0];
        size_t length = address_length(first);
        if (i > 0 && address_length(line) == length &&
            memcmp(line->text, first->text, length) == 0) {
            now += 1.0;
        }
        line->time_s = now;
    }
    log->duration_s = log->count > 0 ? now + 1.0 : 0.0;
}

void nmea_log_read(const char *text, size_t size, struct nmea_log *out)
{
    *out = (struct nmea_log){ .bytes = g_malloc(size + 1) };
    memcpy(out->bytes, text, size);
    out->bytes[size] = '\0';
    GArray *lines = g_array_new(FALSE, TRUE, sizeof(struct nmea_line));
    const char *end = out->bytes + size;
    for (const char *at = out->bytes; at < end;) {
        const char *stop = memchr(at, '\n', (size_t)(end - at));
        stop = stop ? stop : end;
        struct nmea_line line = { .text = at, .length = (size_t)(stop - at) };
        while (line.length > 0 && at[line.length - 1] == '\r') {
            line.length--;
        }
        if (line.length > 0 && (*at == '$' || *at == '!')) {
            g_array_append_val(lines, line);
        }
        at = stop + 1;
    }
    out->count = lines->len;
    out->lines = (struct nmea_line *)(void *)g_array_free(lines, FALSE);
    int stamp = find_stamp(out);
    out->stamped = stamp >= 0;
    if (stamp >= 0) {
        pace_by_stamps(out, stamp);
    } else {
        pace_by_repetition(out);
    }
}

void nmea_log_finish(struct nmea_log *log)
{
    g_free(log->bytes);
    g_free(log->lines);
    *log = (struct nmea_log){ 0 };
}
