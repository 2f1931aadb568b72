#include "ocean/ndbc.h"

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/file.h"
#include "base/vec.h"

#define NEAR_S 5400.0
#define MISSING 900.0 /* 999 and 999.00 mean: not reported */

/* --- text ----------------------------------------------------------------- */

static const char *skip_blanks(const char *p)
{
    while (*p == ' ' || *p == '\t' || *p == '\r') {
        p++;
    }
    return p;
}

/* An unsigned decimal number, whatever the locale; NULL: none there. */
static const char *number(const char *p, double *out)
{
    if (p[0] == 'M' && p[1] == 'M') { /* so NDBC writes what is missing */
        *out = 999.0;
        return p + 2;
    }
    double value = 0, scale = 1;
    int digits = 0;
    for (; *p >= '0' && *p <= '9' && digits < 15; p++, digits++) {
        value = 10.0 * value + (*p - '0');
    }
    if (*p == '.') {
        for (p++; *p >= '0' && *p <= '9' && digits < 15; p++, digits++) {
            value = 10.0 * value + (*p - '0');
            scale *= 10.0;
        }
    }
    *out = value / scale;
    return digits > 0 && !(*p >= '0' && *p <= '9') ? p : NULL;
}

/* Days since 1970-01-01 of a Gregorian date (Hinnant's algorithm). */
static double days_of(int year, int month, int day)
{
    year -= month <= 2;
    int era = year / 400, of_era = year - era * 400;
    int of_year = (153 * (month + (month > 2 ? -3 : 9)) + 2) / 5 + day - 1;
    int days = of_era * 365 + of_era / 4 - of_era / 100 + of_year;
    return (double)era * 146097 + days - 719468;
}

static const char *time_stamp(const char *p, double *unix_s)
{
    static const double least[5] = { 1970, 1, 1, 0, 0 };
    static const double most[5] = { 2100, 12, 31, 23, 59 };
    double part[5];
    for (int i = 0; i < 5; i++) {
        p = number(skip_blanks(p), &part[i]);
        if (!p || !(part[i] >= least[i] && part[i] <= most[i]) ||
            part[i] != floor(part[i])) {
            return NULL;
        }
    }
    *unix_s = 86400.0 * days_of((int)part[0], (int)part[1], (int)part[2]) +
              3600.0 * part[3] + 60.0 * part[4];
    return p;
}

/* Do the files of directions lie there? One alone is no reason to do without
 * the others. */
static bool has_directions(const char *directory, const char *station)
{
    static const char *const endings[] = { "swdir", "swdir2", "swr1", "swr2" };
    for (int i = 0; i < 4; i++) {
        char path[512];
        if (snprintf(path, sizeof path, "%s/%s.%s", directory, station,
                     endings[i]) < (int)sizeof path &&
            access(path, F_OK) == 0) {
            return true;
        }
    }
    return false;
}

/* "value (frequency)"; NULL: broken. */
static const char *pair(const char *p, double *value, double *frequency_hz)
{
    const char *at = number(p, value);
    at = at ? skip_blanks(at) : NULL;
    if (!at || *at != '(') {
        return NULL;
    }
    at = number(skip_blanks(at + 1), frequency_hz);
    at = at ? skip_blanks(at) : NULL;
    return at && *at == ')' ? at + 1 : NULL;
}

/* Pairs until the line's end; their number, −1: broken. */
static int pairs(const char *p, double frequency_hz[PEL_MEASURED_MOST],
                 double value[PEL_MEASURED_MOST])
{
    int count = 0;
    p = skip_blanks(p);
    while (*p != '\0' && *p != '\n') {
        const char *next = count < PEL_MEASURED_MOST
                               ? pair(p, &value[count], &frequency_hz[count])
                               : NULL;
        if (!next) {
            return -1;
        }
        p = skip_blanks(next);
        count++;
    }
    return count;
}

int pel_ndbc_parse(const char *text, double unix_s, bool separation,
                   double frequency_hz[PEL_MEASURED_MOST],
                   double value[PEL_MEASURED_MOST], double *record_unix_s)
{
    const char *chosen = NULL;
    int line = 0, chosen_line = 0;
    double nearest = INFINITY, at = 0;
    for (const char *p = text; *p != '\0'; line++) {
        const char *end = strchr(p, '\n');
        const char *start = skip_blanks(p);
        if (*start != '#' && *start != '\n' && *start != '\0') {
            double when;
            const char *rest = time_stamp(start, &when);
            if (!rest) {
                return -1 - line;
            }
            double away = isnan(unix_s) ? -when : fabs(when - unix_s);
            if (!chosen || away < nearest) {
                nearest = away;
                chosen = rest;
                chosen_line = line;
                at = when;
            }
        }
        p = end ? end + 1 : p + strlen(p);
    }
    if (!chosen) {
        return 0;
    }
    double unused;
    if (separation && !(chosen = number(skip_blanks(chosen), &unused))) {
        return -1 - chosen_line;
    }
    int count = pairs(chosen, frequency_hz, value);
    *record_unix_s = at;
    return count < 0 ? -1 - chosen_line : count;
}

/* --- files ---------------------------------------------------------------- */

static enum pel_err read_text(const char *directory, const char *name,
                              char **out, struct pel_fault *fault)
{
    char *text = NULL;
    size_t size = 0;
    enum pel_err err = pel_file_read_in(directory, name, PEL_NDBC_FILE_LIMIT,
                                        &text, &size, fault);
    if (err == PEL_ERR_OUT_OF_RANGE) {
        return pel_fault_set(fault, PEL_ERR_MALFORMED,
                             "%s is longer than %d bytes", name,
                             PEL_NDBC_FILE_LIMIT);
    }
    if (!err && memchr(text, 0, size)) {
        free(text);
        err = pel_fault_set(fault, PEL_ERR_MALFORMED, "%s is not text", name);
    }
    if (err) {
        return err;
    }
    *out = text;
    return PEL_OK;
}

struct series {
    int count;
    double unix_s;
    double frequency_hz[PEL_MEASURED_MOST], value[PEL_MEASURED_MOST];
};

static enum pel_err read_series(const char *directory, const char *station,
                                const char *ending, double unix_s,
                                struct series *out, struct pel_fault *fault)
{
    char name[512];
    char *text = NULL;
    int length = snprintf(name, sizeof name, "%s.%s", station, ending);
    if (length < 0 || length >= (int)sizeof name) {
        return pel_fault_set(fault, PEL_ERR_IO, "the path of %s is too long",
                             station);
    }
    enum pel_err err = read_text(directory, name, &text, fault);
    if (err) {
        return err;
    }
    out->count = pel_ndbc_parse(text, unix_s, strcmp(ending, "data_spec") == 0,
                                out->frequency_hz, out->value, &out->unix_s);
    free(text);
    if (out->count < 0) {
        return pel_fault_set(fault, PEL_ERR_MALFORMED,
                             "%s:%d: not a time and pairs of value "
                             "(frequency)",
                             name, -out->count);
    }
    if (out->count == 0) {
        return pel_fault_set(fault, PEL_ERR_NOT_FOUND, "%s holds no record",
                             name);
    }
    return PEL_OK;
}

static bool name_ok(const char *station)
{
    size_t length = strlen(station);
    return length > 0 && length < PEL_NDBC_STATION_SIZE &&
           strspn(station, "ABCDEFGHIJKLMNOPQRSTUVWXYZ"
                           "abcdefghijklmnopqrstuvwxyz0123456789_-") == length;
}

/* Of a direction it comes from, degrees from north, the mathematical one it
 * goes to. */
static double goes_to(double from_deg)
{
    return remainder(270.0 - from_deg, 360.0) * PEL_DEG;
}

/* alpha1, alpha2, r1, r2 beside the densities. */
static enum pel_err take(const struct series four[4], const char *station,
                         struct pel_measured *out, struct pel_fault *fault)
{
    for (int i = 0; i < out->count; i++) {
        bool known = true;
        for (int j = 0; j < 4; j++) {
            if (four[j].count != out->count ||
                fabs(four[j].frequency_hz[i] - out->frequency_hz[i]) > 1e-6) {
                return pel_fault_set(fault, PEL_ERR_MALFORMED,
                                     "%s: the files do not have the same "
                                     "frequencies",
                                     station);
            }
            known = known && four[j].value[i] < MISSING;
        }
        if (known && !(four[0].value[i] <= 360 && four[1].value[i] <= 360 &&
                       four[2].value[i] <= 1 && four[3].value[i] <= 1)) {
            return pel_fault_set(fault, PEL_ERR_MALFORMED,
                                 "%s: at %g Hz a direction is over 360 or an "
                                 "r over 1",
                                 station, out->frequency_hz[i]);
        }
        out->alpha1_rad[i] = known ? goes_to(four[0].value[i]) : 0;
        out->alpha2_rad[i] = known ? goes_to(four[1].value[i]) : 0;
        out->r1[i] = known ? four[2].value[i] : 0;
        out->r2[i] = known ? four[3].value[i] : 0;
    }
    return PEL_OK;
}

static enum pel_err densities(const struct series *s, const char *station,
                              struct pel_measured *out, struct pel_fault *fault)
{
    bool ok = s->count >= 3;
    out->count = s->count;
    for (int i = 0; ok && i < s->count; i++) {
        ok = s->frequency_hz[i] >= 0.005 && s->frequency_hz[i] <= 2 &&
             (i == 0 || s->frequency_hz[i] > s->frequency_hz[i - 1]);
        out->frequency_hz[i] = s->frequency_hz[i];
        out->density[i] = s->value[i] < MISSING ? s->value[i] : NAN;
    }
    return ok ? PEL_OK
              : pel_fault_set(fault, PEL_ERR_MALFORMED,
                              "%s: needs at least 3 frequencies, rising, 0.005 "
                              "to 2 Hz",
                              station);
}

/* Without the bands that are missing; all of them are no calm sea. */
static enum pel_err leave_out(struct pel_measured *m, const char *station,
                              struct pel_fault *fault)
{
    int n = 0, all = m->count;
    for (int i = 0; i < all; i++) {
        if (!isnan(m->density[i])) {
            m->frequency_hz[n] = m->frequency_hz[i];
            m->density[n] = m->density[i];
            m->alpha1_rad[n] = m->alpha1_rad[i];
            m->alpha2_rad[n] = m->alpha2_rad[i];
            m->r1[n] = m->r1[i];
            m->r2[n] = m->r2[i];
            n++;
        }
    }
    m->count = n;
    return n >= 3 ? PEL_OK
                  : pel_fault_set(fault, PEL_ERR_NOT_FOUND,
                                  "%s: of the record's %d bands %d have a "
                                  "density, at least 3 must: choose another "
                                  "measuredTime",
                                  station, all, n);
}

enum pel_err pel_ndbc_read(const char *directory, const char *station,
                           double unix_s, struct pel_measured *out,
                           double *record_unix_s, struct pel_fault *fault)
{
    static const char *const endings[] = { "swdir", "swdir2", "swr1", "swr2" };
    if (!name_ok(station)) {
        return pel_fault_set(fault, PEL_ERR_INVALID,
                             "a station is named by 1 to 32 of A-Z a-z 0-9 _ "
                             "-, without ending");
    }
    struct pel_measured found = { 0 };
    struct series energy = { 0 }, four[4] = { { 0 } };
    enum pel_err err =
        read_series(directory, station, "data_spec", unix_s, &energy, fault);
    if (!err && fabs(energy.unix_s - unix_s) > NEAR_S) { /* false for NAN */
        err = pel_fault_set(fault, PEL_ERR_NOT_FOUND,
                            "%s has no record within 90 minutes; the nearest "
                            "is %.1f hours away",
                            station, fabs(energy.unix_s - unix_s) / 3600.0);
    }
    if (!err) {
        err = densities(&energy, station, &found, fault);
    }
    bool directions = !err && has_directions(directory, station);
    for (int i = 0; !err && directions && i < 4; i++) {
        err = read_series(directory, station, endings[i], energy.unix_s,
                          &four[i], fault);
        if (!err && four[i].unix_s != energy.unix_s) {
            err = pel_fault_set(fault, PEL_ERR_NOT_FOUND,
                                "%s.%s lacks the record of %s.data_spec",
                                station, endings[i], station);
        }
    }
    if (!err && directions) {
        err = take(four, station, &found, fault);
    }
    if (!err) {
        err = leave_out(&found, station, fault);
    }
    if (!err) {
        *out = found;
        if (record_unix_s) {
            *record_unix_s = energy.unix_s;
        }
    }
    return err;
}
