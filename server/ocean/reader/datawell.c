/* Datawell's .spt: a head of numbers, a line each (transmission, Hs [cm], Tz
 * [s], Smax [m²/Hz], temperatures, battery, offsets …), before it at times a
 * line with a word, then a line a band: frequency [Hz], density relative to
 * Smax, direction that waves come from [deg], spread [deg], skewness and
 * kurtosis (Datawell, W@ves21; Kuik, van Vledder and Holthuijsen 1988). Heights
 * are Hs's, which the head gives whatever it calls the greatest density. */
#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/vec.h"
#include "ocean/reader/buoy.h"

#define MOST_HEAD 20

struct head {
    double values[MOST_HEAD]; /* from the transmission's number on */
    int count;
};

/* A number alone in its line, were a degree sign behind it. */
static bool lone_number(const char *p, const char *end, double *out)
{
    char *after;
    *out = strtod(p, &after);
    return after > p && after <= end && !memchr(p, ',', (size_t)(end - p));
}

/* NULL: it is no such head; else where the bands begin. */
static const char *take_head(const char *p, struct head *out)
{
    out->count = 0;
    for (int line = 0; line < MOST_HEAD && *p; line++) {
        const char *end = p + strcspn(p, "\n");
        double v;
        if (memchr(p, ',', (size_t)(end - p))) {
            return out->count >= 4 ? p : NULL;
        }
        if (lone_number(p, end, &v)) {
            out->values[out->count++] = v;
        } else if (line > 0) {
            return NULL;
        }
        p = end + (*end == '\n');
    }
    return NULL;
}

/* The second moment's share along and across the mean direction, of the first
 * and of skewness and kurtosis (Kuik et al. 1988, eq. 35, 36). */
static void second_moment(double m1, double skewness, double kurtosis,
                          double *m2, double *n2)
{
    double square = 2 * (1 - m1);
    *m2 = 0.5 * (kurtosis * square * square - 6 + 8 * m1);
    *n2 = -skewness * pow(fmax(0.5 * (1 - *m2), 0), 1.5);
}

static void take_direction(struct pel_bands *b, int i, const double v[6])
{
    double m2, n2, r1 = pel_r1_of_spread(v[3] * PEL_DEG);
    if (!(v[2] >= 0 && v[2] <= 360 && v[3] > 0 && r1 >= 0)) {
        return;
    }
    b->r1[i] = r1;
    b->alpha1_rad[i] = pel_goes_to_rad(v[2]);
    second_moment(r1, v[4], v[5], &m2, &n2);
    if (hypot(m2, n2) <= 1) {
        b->r2[i] = hypot(m2, n2);
        b->alpha2_rad[i] =
            pel_goes_to_rad(v[2] + 0.5 * atan2(n2, m2) / PEL_DEG);
    }
}

static enum pel_err take_bands(const char *p, struct pel_bands *b,
                               struct pel_fault *fault)
{
    pel_bands_init(b, PEL_MEASURED_MOST);
    b->count = 0;
    while (p += strspn(p, " \t\r\n"), *p) {
        double v[6] = { NAN, NAN, NAN, NAN, NAN, NAN };
        if (b->count == PEL_MEASURED_MOST) {
            return pel_fault_set(fault, PEL_ERR_OUT_OF_RANGE,
                                 "more than %d bands", PEL_MEASURED_MOST);
        }
        int i = b->count, n = 0;
        const char *end = p + strcspn(p, "\n");
        for (char *after; n < 6; n++) {
            v[n] = strtod(p, &after);
            if (after == p || after > end) {
                break;
            }
            p = after + strspn(after, " \t");
            p += *p == ',';
        }
        if (n < 4) {
            return pel_fault_set(fault, PEL_ERR_MALFORMED,
                                 "band %d is not frequency, density, "
                                 "direction, spread, skewness, kurtosis",
                                 i + 1);
        }
        p = end;
        b->count = i + 1;
        b->frequency_hz[i] = v[0];
        b->density[i] = v[1] >= 0 ? v[1] : NAN;
        v[4] = n > 4 ? v[4] : NAN;
        v[5] = n > 5 ? v[5] : NAN;
        take_direction(b, i, v);
    }
    return PEL_OK;
}

/* The time in the file's name, as Site}2021-06-20T12h30Z.spt; 0: the name has
 * none. */
static double time_of(const char *path)
{
    int y, m, d, hour, minute;
    for (const char *p = path; *p; p++) {
        if (isdigit((unsigned char)*p) &&
            sscanf(p, "%4d-%2d-%2dT%2d%*[h:]%2d", &y, &m, &d, &hour, &minute) ==
                5) {
            return pel_shelf_unix(y, m, d, 3600.0 * hour + 60.0 * minute);
        }
    }
    return 0;
}

/* By trapezia, as the height is summed up elsewhere. */
static double energy(const struct pel_bands *b)
{
    double sum = 0;
    for (int i = 1; i < b->count; i++) {
        double mean = 0.5 * (b->density[i] + b->density[i - 1]);
        sum += isfinite(mean)
                   ? mean * (b->frequency_hz[i] - b->frequency_hz[i - 1])
                   : 0;
    }
    return sum;
}

enum pel_err pel_read_datawell(const char *path, const struct pel_want *want,
                               struct pel_measured *out, double *unix_s,
                               struct pel_fault *fault)
{
    static struct pel_bands bands;
    struct head head;
    struct pel_place place = { "", NAN, NAN };
    const char *text = pel_shelf_text(path);
    const char *p = text ? take_head(text, &head) : NULL;
    if (!p) {
        return pel_fault_set(fault, PEL_ERR_MALFORMED,
                             "not a head of Datawell's .spt: a number a line, "
                             "the second Hs in cm, the fourth Smax in m²/Hz");
    }
    if (pel_shelf_place(want, &place, 1, fault) < 0) {
        return PEL_ERR_NOT_FOUND;
    }
    enum pel_err err = take_bands(p, &bands, fault);
    if (err) {
        return err;
    }
    double height_m = head.values[1] / 100, m0 = energy(&bands);
    if (!(height_m > 0 && height_m < 40) || !(m0 > 0)) {
        return pel_fault_set(fault, PEL_ERR_NOT_FOUND,
                             "its Hs is %g cm and its bands have %s: no "
                             "spectrum was measured",
                             head.values[1], m0 > 0 ? "energy" : "none");
    }
    for (int i = 0; i < bands.count; i++) {
        bands.density[i] *= height_m * height_m / 16 / m0;
    }
    *unix_s = time_of(path);
    if (*unix_s != 0 && pel_shelf_time(want, unix_s, 1, fault) < 0) {
        return PEL_ERR_NOT_FOUND;
    }
    return pel_bands_take(&bands, out, fault);
}
