/* Spotter's JSON, as Sofar's API gives it: objects with frequency [Hz],
 * varianceDensity [m²/Hz] and the moments a1, b1, a2, b2 of directions that
 * waves go to, from east, counterclockwise; direction [deg, they come from] and
 * directionalSpread [deg]; timestamp, latitude, longitude, the buoy's
 * spotterId in an object around them. */
#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/vec.h"
#include "ocean/reader/buoy.h"

#define MOST_RECORDS 4000
#define MOST_DEPTH 16
#define APART_DEG 20.0 /* between the moments and the direction */

enum { FREQUENCY, DENSITY, A1, B1, A2, B2, DIRECTION, SPREAD, SERIES };
static const char *const series[SERIES] = { "frequency", "varianceDensity",
                                            "a1",        "b1",
                                            "a2",        "b2",
                                            "direction", "directionalSpread" };

struct record {
    double values[SERIES][PEL_MEASURED_MOST];
    int counts[SERIES]; /* 0: not there */
    double unix_s, latitude, longitude;
    char name[64];
};

struct json {
    const char *p;
    struct record *records;
    int count;
    const char *wrong; /* what, or NULL */
};

static void blanks(struct json *j)
{
    j->p += strspn(j->p, " \t\r\n");
}

static bool take(struct json *j, char c)
{
    blanks(j);
    bool is = *j->p == c;
    j->p += is;
    return is;
}

static bool wrong(struct json *j, const char *what)
{
    j->wrong = j->wrong ? j->wrong : what;
    return false;
}

/* Into `out`, cut to its size, escapes as they are. */
static bool text(struct json *j, char *out, size_t size)
{
    size_t n = 0;
    if (!take(j, '"')) {
        return wrong(j, "a text is missing");
    }
    for (; *j->p && *j->p != '"'; j->p++) {
        if (*j->p == '\\' && j->p[1]) {
            j->p++;
        }
        if (n + 1 < size) {
            out[n++] = *j->p;
        }
    }
    if (size > 0) {
        out[n] = '\0';
    }
    return *j->p++ == '"' || (j->p--, wrong(j, "a text has no end"));
}

static bool number(struct json *j, double *out)
{
    char *end;
    blanks(j);
    *out = NAN;
    if (strncmp(j->p, "null", 4) == 0) {
        j->p += 4;
        return true;
    }
    bool quoted = *j->p == '"';
    double v = strtod(j->p + quoted, &end);
    if (end == j->p + quoted || (quoted && *end != '"')) {
        return wrong(j, "a number is missing");
    }
    *out = v;
    j->p = end + quoted;
    return true;
}

static bool numbers(struct json *j, double *out, int *count)
{
    *count = 0;
    if (!take(j, '[')) {
        return wrong(j, "a list is missing");
    }
    if (take(j, ']')) {
        return true;
    }
    do {
        if (*count == PEL_MEASURED_MOST) {
            return wrong(j, "a list is too long");
        }
        if (!number(j, &out[(*count)++])) {
            return false;
        }
    } while (take(j, ','));
    return take(j, ']') || wrong(j, "a list has no end");
}

/* "2026-06-21T12:00:00.000Z"; NAN: no such time. */
static double time_of(const char *s)
{
    int y, m, d, hour, minute, used = 0, h = 0, mm = 0;
    double second = 0;
    if (sscanf(s, "%4d-%2d-%2d%*[T ]%2d:%2d%n", &y, &m, &d, &hour, &minute,
               &used) != 5) {
        return NAN;
    }
    s += used;
    if (*s == ':') {
        char *end;
        second = strtod(s + 1, &end);
        s = end;
    }
    int sign = *s == '-' ? -1 : 1;
    if (*s == '+' || *s == '-') {
        (void)sscanf(s + 1, "%2d%*[:]%2d", &h, &mm);
    } else if (*s && strcmp(s, "Z") != 0) {
        return NAN;
    }
    return pel_shelf_unix(y, m, d, 3600.0 * hour + 60.0 * minute + second) -
           sign * (3600.0 * h + 60.0 * mm);
}

static bool value(struct json *j, int depth);

/* One member of an object that may be a record. */
static bool member(struct json *j, const char *key, struct record *r, int depth)
{
    char when[40];
    for (int i = 0; i < SERIES; i++) {
        blanks(j);
        if (strcmp(key, series[i]) == 0 && *j->p == '[') {
            return numbers(j, r->values[i], &r->counts[i]);
        }
    }
    if (strcmp(key, "timestamp") == 0 && *j->p == '"') {
        bool good = text(j, when, sizeof when);
        r->unix_s = time_of(when);
        return good;
    }
    if (strcmp(key, "latitude") == 0) {
        return number(j, &r->latitude);
    }
    if (strcmp(key, "longitude") == 0) {
        return number(j, &r->longitude);
    }
    if (strcmp(key, "spotterId") == 0 && *j->p == '"') {
        return text(j, r->name, sizeof r->name);
    }
    return value(j, depth);
}

static bool object(struct json *j, int depth)
{
    struct record *r = calloc(1, sizeof *r);
    int first = j->count;
    char key[40];
    if (!r) {
        return wrong(j, "no memory is left");
    }
    r->unix_s = r->latitude = r->longitude = NAN;
    bool good = true;
    while (good && !take(j, '}')) {
        good = text(j, key, sizeof key) &&
               (take(j, ':') || wrong(j, "a : is missing")) &&
               member(j, key, r, depth);
        blanks(j);
        if (good && *j->p != '}') {
            good = take(j, ',') || wrong(j, "an object has no end");
        }
    }
    for (int i = first; good && *r->name && i < j->count; i++) {
        if (!*j->records[i].name) {
            memcpy(j->records[i].name, r->name, sizeof r->name);
        }
    }
    if (good && r->counts[FREQUENCY] > 0 && r->counts[DENSITY] > 0) {
        if (j->count == MOST_RECORDS) {
            good = wrong(j, "it has more than 4000 records");
        } else {
            j->records[j->count++] = *r;
        }
    }
    free(r);
    return good;
}

static bool value(struct json *j, int depth)
{
    blanks(j);
    if (depth == 0) {
        return wrong(j, "it is nested too deeply");
    }
    if (take(j, '{')) {
        return object(j, depth - 1);
    }
    if (take(j, '[')) {
        if (take(j, ']')) {
            return true;
        }
        do {
            if (!value(j, depth - 1)) {
                return false;
            }
        } while (take(j, ','));
        return take(j, ']') || wrong(j, "a list has no end");
    }
    if (*j->p == '"') {
        return text(j, NULL, 0);
    }
    size_t length = strcspn(j->p, ",]} \t\r\n");
    j->p += length;
    return length > 0 || wrong(j, "a value is missing");
}

static enum pel_err take_bands(const struct record *r, struct pel_bands *b,
                               struct pel_fault *fault)
{
    int n = r->counts[FREQUENCY];
    double x = 0, y = 0, u = 0, v = 0;
    pel_bands_init(b, n);
    for (int s = 0; s < SERIES; s++) {
        if (r->counts[s] != 0 && r->counts[s] != n) {
            return pel_fault_set(fault, PEL_ERR_MALFORMED,
                                 "%s has %d values for %d frequencies",
                                 series[s], r->counts[s], n);
        }
    }
    bool moments = r->counts[A1] && r->counts[B1];
    bool way = r->counts[DIRECTION] && r->counts[SPREAD];
    for (int i = 0; i < n; i++) {
        b->frequency_hz[i] = r->values[FREQUENCY][i];
        b->density[i] = r->values[DENSITY][i];
        double to = pel_goes_to_rad(r->values[DIRECTION][i]);
        if (moments) {
            bool both = r->counts[A2] && r->counts[B2];
            const double ab[] = { r->values[A1][i], r->values[B1][i],
                                  both ? r->values[A2][i] : NAN,
                                  both ? r->values[B2][i] : NAN };
            pel_bands_fourier(b, i, ab);
            if (r->counts[DIRECTION] && b->density[i] > 0 && isfinite(to)) {
                x += b->density[i] * ab[0];
                y += b->density[i] * ab[1];
                u += b->density[i] * b->r1[i] * cos(to);
                v += b->density[i] * b->r1[i] * sin(to);
            }
        } else if (way) {
            b->alpha1_rad[i] = to;
            b->r1[i] = pel_r1_of_spread(r->values[SPREAD][i] * PEL_DEG);
        }
    }
    double apart = fabs(remainder(atan2(y, x) - atan2(v, u), 2 * PEL_PI));
    return hypot(u, v) > 0 && apart > APART_DEG * PEL_DEG
               ? pel_fault_set(fault, PEL_ERR_MALFORMED,
                               "its direction and the direction of a1, b1 "
                               "differ by %.0f degrees; a1 and b1 must be of "
                               "the way that waves go to, from east, "
                               "counterclockwise",
                               apart / PEL_DEG)
               : PEL_OK;
}

/* The buoys, each once. */
static int list_places(const struct json *j, struct pel_place *places)
{
    int count = 0;
    for (int i = 0; i < j->count; i++) {
        const struct record *r = &j->records[i];
        int k = 0;
        while (k < count && strcmp(places[k].name, r->name) != 0) {
            k++;
        }
        if (k == count) {
            places[count].latitude = r->latitude;
            places[count].longitude = r->longitude;
            memcpy(places[count].name, r->name, sizeof r->name);
            count++;
        }
    }
    return count;
}

enum pel_err pel_read_spotter(const char *path, const struct pel_want *want,
                              struct pel_measured *out, double *unix_s,
                              struct pel_fault *fault)
{
    static struct pel_place places[MOST_RECORDS];
    static double times[MOST_RECORDS];
    static struct pel_bands bands;
    static struct record records[MOST_RECORDS];
    struct json j = { .p = pel_shelf_text(path), .records = records };
    if (!j.p || !value(&j, MOST_DEPTH)) {
        return pel_fault_set(fault, PEL_ERR_MALFORMED, "no JSON: %s",
                             j.wrong ? j.wrong : "it cannot be read");
    }
    if (j.count == 0) {
        return pel_fault_set(fault, PEL_ERR_NOT_FOUND,
                             "no object has frequency and varianceDensity: "
                             "ask Spotter's API for frequency data, as by "
                             "includeFrequencyData=true");
    }
    int place =
        pel_shelf_place(want, places, (size_t)list_places(&j, places), fault);
    if (place < 0) {
        return PEL_ERR_NOT_FOUND;
    }
    for (int i = 0; i < j.count; i++) {
        bool same = strcmp(j.records[i].name, places[place].name) == 0;
        times[i] = same ? j.records[i].unix_s : NAN;
    }
    int at = pel_shelf_time(want, times, (size_t)j.count, fault);
    if (at < 0) {
        return PEL_ERR_NOT_FOUND;
    }
    *unix_s = times[at];
    enum pel_err err = take_bands(&j.records[at], &bands, fault);
    return err ? err : pel_bands_take(&bands, out, fault);
}
