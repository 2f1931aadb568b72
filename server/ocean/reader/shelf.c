#include "ocean/reader/shelf.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <time.h>

#include "base/vec.h"
#include "ocean/spectrumfile.h"

#define MOST_UNIX_S 1e11 /* a date as text has four digits of a year */

double pel_shelf_unix(int year, int month, int day, double seconds)
{
    if (year < 1800 || year > 2200 || month < 1 || month > 12 || day < 1 ||
        day > 31 || !(seconds >= 0 && seconds <= 86400)) {
        return NAN;
    }
    struct tm tm = { .tm_year = year - 1900,
                     .tm_mon = month - 1,
                     .tm_mday = day };
    time_t midnight = timegm(&tm);
    /* 30 February would be one of March. */
    return tm.tm_mday == day ? (double)midnight + seconds : NAN;
}

static void utc_text(double unix_s, char out[32])
{
    struct tm tm;
    time_t t = fabs(unix_s) < MOST_UNIX_S ? (time_t)unix_s : 0;
    if (!(fabs(unix_s) < MOST_UNIX_S) || !gmtime_r(&t, &tm)) {
        snprintf(out, 32, "?");
        return;
    }
    strftime(out, 32, "%Y-%m-%dT%H:%MZ", &tm);
}

int pel_shelf_time(const struct pel_want *want, const double *unix_s,
                   size_t count, struct pel_fault *fault)
{
    int best = -1;
    double first = INFINITY, last = -INFINITY;
    for (size_t i = 0; i < count; i++) {
        if (!isfinite(unix_s[i])) {
            continue;
        }
        first = fmin(first, unix_s[i]);
        last = fmax(last, unix_s[i]);
        bool better = best < 0 || (isnan(want->unix_s)
                                       ? unix_s[i] > unix_s[best]
                                       : fabs(unix_s[i] - want->unix_s) <
                                             fabs(unix_s[best] - want->unix_s));
        best = better ? (int)i : best;
    }
    if (best < 0) {
        pel_fault_set(fault, PEL_ERR_MALFORMED, "no record has a time");
        return -1;
    }
    if (fabs(unix_s[best] - want->unix_s) > PEL_SPECTRUM_FILE_NEAR_S) {
        char a[32], b[32], c[32];
        utc_text(first, a);
        utc_text(last, b);
        utc_text(unix_s[best], c);
        pel_fault_set(fault, PEL_ERR_NOT_FOUND,
                      "no record within 90 minutes of measuredTime; there are "
                      "%zu from %s to %s, the nearest at %s",
                      count, a, b, c);
        return -1;
    }
    return best;
}

/* Some of them, for people. */
static int refuse_place(const struct pel_want *want,
                        const struct pel_place *places, size_t count,
                        struct pel_fault *fault)
{
    char list[140] = "";
    size_t used = 0;
    for (size_t i = 0; i < count && i < 5 && used < 100; i++) {
        used += (size_t)snprintf(list + used, sizeof list - used, "%s",
                                 i ? ", " : "");
        used += (size_t)snprintf(list + used, sizeof list - used,
                                 "%zu %.12s (%.4g,%.4g)", i + 1, places[i].name,
                                 places[i].latitude, places[i].longitude);
    }
    pel_fault_set(fault, PEL_ERR_NOT_FOUND,
                  "%s%.24s: write FILE#STATION, of %zu: %s%s",
                  *want->station ? "no station " : "which station",
                  want->station, count, list, count > 5 ? ", …" : "");
    return -1;
}

static double apart_deg(const struct pel_place *p, double latitude,
                        double longitude)
{
    double a = p->latitude * PEL_DEG, b = latitude * PEL_DEG;
    double l = (p->longitude - longitude) * PEL_DEG;
    double c = sin(a) * sin(b) + cos(a) * cos(b) * cos(l);
    return acos(pel_clamp(c, -1, 1)) / PEL_DEG;
}

int pel_shelf_place(const struct pel_want *want, const struct pel_place *places,
                    size_t count, struct pel_fault *fault)
{
    double latitude, longitude;
    unsigned number;
    char end;
    if (count == 1 && !*want->station) {
        return 0;
    }
    for (size_t i = 0; i < count && *want->station; i++) {
        if (strcmp(places[i].name, want->station) == 0) {
            return (int)i;
        }
    }
    for (size_t i = 0; i < count && *want->station; i++) {
        if (strcasecmp(places[i].name, want->station) == 0) {
            return (int)i;
        }
    }
    if (sscanf(want->station, "%7u%c", &number, &end) == 1 && number >= 1 &&
        number <= count) {
        return (int)number - 1;
    }
    if (sscanf(want->station, "%lf,%lf%c", &latitude, &longitude, &end) == 2) {
        int best = -1;
        double least = 3.0;
        for (size_t i = 0; i < count; i++) {
            double apart = apart_deg(&places[i], latitude, longitude);
            if (apart <= least) { /* false for NAN */
                least = apart;
                best = (int)i;
            }
        }
        if (best >= 0) {
            return best;
        }
    }
    return refuse_place(want, places, count, fault);
}

char *pel_shelf_letter(char *path)
{
    char *name = strrchr(path, '/');
    char *small = strrchr(name ? name : path, 'w');
    char *large = strrchr(name ? name : path, 'W');
    return !small || (large && large > small) ? large : small;
}

#define MOST_BYTES ((size_t)256 << 20)

char *pel_shelf_text(const char *path)
{
    FILE *f = fopen(path, "rb");
    long size = 0;
    char *bytes = NULL;
    if (f && fseek(f, 0, SEEK_END) == 0 && (size = ftell(f)) >= 0 &&
        (size_t)size <= MOST_BYTES && fseek(f, 0, SEEK_SET) == 0) {
        bytes = calloc((size_t)size + 1, 1);
        if (bytes && (fread(bytes, 1, (size_t)size, f) != (size_t)size ||
                      memchr(bytes, 0, (size_t)size))) {
            free(bytes);
            bytes = NULL;
        }
    }
    if (f) {
        fclose(f);
    }
    return bytes;
}

enum pel_err pel_shelf_frequencies(const double *frequency_hz, int nf,
                                   struct pel_fault *fault)
{
    bool ok = nf >= 3 && nf <= PEL_MEASURED_MOST;
    for (int i = 0; ok && i < nf; i++) {
        ok = frequency_hz[i] >= 0.005 && frequency_hz[i] <= 2 &&
             (i == 0 || frequency_hz[i] > frequency_hz[i - 1]);
    }
    return ok ? PEL_OK
              : pel_fault_set(fault, PEL_ERR_OUT_OF_RANGE,
                              "%d frequencies; needs 3 to %d, rising, 0.005 to "
                              "2 Hz",
                              nf, PEL_MEASURED_MOST);
}

/* Half the way to each neighbour on the circle. */
static void shares(const double *to_rad, int nd, double *share)
{
    for (int k = 0; k < nd; k++) {
        double before = 2 * PEL_PI, after = 2 * PEL_PI;
        for (int j = 0; j < nd; j++) {
            if (j != k) {
                double d = fmod(to_rad[j] - to_rad[k] + 8 * PEL_PI, 2 * PEL_PI);
                after = d > 1e-6 && d < after ? d : after;
                d = 2 * PEL_PI - d;
                before = d > 1e-6 && d < 2 * PEL_PI - 1e-6 && d < before
                             ? d
                             : before;
            }
        }
        share[k] = 0.5 * (before + after);
    }
}

enum pel_err pel_shelf_collapse(const double *frequency_hz, int nf,
                                const double *to_rad, int nd, const double *e,
                                struct pel_measured *out,
                                struct pel_fault *fault)
{
    static double share[PEL_SHELF_DIRECTIONS];
    enum pel_err err = pel_shelf_frequencies(frequency_hz, nf, fault);
    if (err) {
        return err;
    }
    if (nd < 3 || nd > PEL_SHELF_DIRECTIONS) {
        return pel_fault_set(fault, PEL_ERR_OUT_OF_RANGE,
                             "%d directions; needs 3 to %d", nd,
                             PEL_SHELF_DIRECTIONS);
    }
    for (int k = 0; k < nd; k++) {
        if (!isfinite(to_rad[k])) {
            return pel_fault_set(fault, PEL_ERR_MALFORMED,
                                 "direction %d of %d is no number", k + 1, nd);
        }
    }
    shares(to_rad, nd, share);
    out->count = nf;
    for (int i = 0; i < nf; i++) {
        double sum = 0, m[4] = { 0 };
        for (int k = 0; k < nd; k++) {
            double v = e[(size_t)i * (size_t)nd + (size_t)k] * share[k];
            if (!(v > 0) || !isfinite(v)) {
                continue;
            }
            sum += v;
            m[0] += v * cos(to_rad[k]);
            m[1] += v * sin(to_rad[k]);
            m[2] += v * cos(2 * to_rad[k]);
            m[3] += v * sin(2 * to_rad[k]);
        }
        if (!isfinite(sum)) {
            return pel_fault_set(fault, PEL_ERR_OUT_OF_RANGE,
                                 "the density at %g Hz has no end",
                                 frequency_hz[i]);
        }
        out->frequency_hz[i] = frequency_hz[i];
        out->density[i] = sum;
        out->r1[i] = sum > 0 ? fmin(hypot(m[0], m[1]) / sum, 1) : 0;
        out->r2[i] = sum > 0 ? fmin(hypot(m[2], m[3]) / sum, 1) : 0;
        out->alpha1_rad[i] = atan2(m[1], m[0]);
        out->alpha2_rad[i] = 0.5 * atan2(m[3], m[2]);
    }
    return PEL_OK;
}
