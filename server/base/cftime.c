/* Times as CF writes them: "hours since 1900-01-01", by calendars of weather
 * and of models. Days are counted as Julian day numbers are (Fliegel and Van
 * Flandern 1968; Richards 2013). */
#include "base/cf.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <time.h>

#define DAY_S 86400.0
#define UNIX_DAY 2440588 /* Julian day of 1 January 1970 */
#define REFORM 2299161   /* of 15 October 1582, after 4 October */

enum calendar { MIXED, GREGORIAN, JULIAN, NO_LEAP, ALL_LEAP, OF_360 };

static bool calendar_of(const char *name, enum calendar *out)
{
    static const struct {
        const char *name;
        enum calendar is;
    } names[] = {
        { "standard", MIXED },    { "gregorian", MIXED },
        { "mixed", MIXED },       { "proleptic_gregorian", GREGORIAN },
        { "julian", JULIAN },     { "noleap", NO_LEAP },
        { "365_day", NO_LEAP },   { "no_leap", NO_LEAP },
        { "all_leap", ALL_LEAP }, { "366_day", ALL_LEAP },
        { "360_day", OF_360 },
    };
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        if (strcasecmp(name, names[i].name) == 0) {
            *out = names[i].is;
            return true;
        }
    }
    return false;
}

static long floor_div(long a, long b)
{
    return a / b - (a % b < 0);
}

static long julian_day(long y, long m, long d, bool gregorian)
{
    long a = (14 - m) / 12, years = y + 4800 - a, month = m + 12 * a - 3;
    long n = d + (153 * month + 2) / 5 + 365 * years + floor_div(years, 4);
    return gregorian ? n - floor_div(years, 100) + floor_div(years, 400) - 32045
                     : n - 32083;
}

static const int month_days[] = {
    31, 28, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31
};

static bool is_leap(long y, bool gregorian)
{
    return y % 4 == 0 && (!gregorian || y % 100 != 0 || y % 400 == 0);
}

static int days_in(enum calendar c, long y, long m)
{
    bool leap = c == ALL_LEAP || (c == GREGORIAN && is_leap(y, true)) ||
                (c == JULIAN && is_leap(y, false)) ||
                (c == MIXED && is_leap(y, y > 1582));
    return c == OF_360 ? 30 : month_days[m - 1] + (m == 2 && leap);
}

/* Days of a model's calendar before the month of a year 0. */
static long model_day(enum calendar c, long y, long m, long d)
{
    long days = d - 1;
    for (long k = 1; k < m; k++) {
        days += days_in(c, y, k);
    }
    return y * (c == OF_360 ? 360 : c == ALL_LEAP ? 366 : 365) + days;
}

static long number_of(enum calendar c, long y, long m, long d)
{
    long by_julian = julian_day(y, m, d, false);
    switch (c) {
    case GREGORIAN:
        return julian_day(y, m, d, true);
    case JULIAN:
        return by_julian;
    case MIXED:
        return by_julian < REFORM ? by_julian : julian_day(y, m, d, true);
    default:
        return model_day(c, y, m, d);
    }
}

double pel_cf_day_s(long year, long month, long day)
{
    return (double)(julian_day(year, month, day, true) - UNIX_DAY) * DAY_S;
}

const char *pel_cf_when(double unix_s, char out[32])
{
    time_t t = (time_t)unix_s;
    struct tm at;
    if (!gmtime_r(&t, &at) || !strftime(out, 32, "%Y-%m-%dT%H:%M:%SZ", &at)) {
        snprintf(out, 32, "%.0f s", unix_s);
    }
    return out;
}

/* A reference: "1900-01-01 00:00:0.0 +01:00". */
struct reference {
    long year, month, day;
    double second; /* of the day, in universal time */
};

/* A zone: "", Z, UTC, GMT, +1, +01:30, +0130, 0:00. */
static bool zone_s(const char *text, double *out)
{
    int hours = 0, minutes = 0, end = 0;
    const char *at = text + (*text == '+' || *text == '-');
    *out = 0;
    if (!*text || strcasecmp(text, "Z") == 0 || strcasecmp(text, "UTC") == 0 ||
        strcasecmp(text, "GMT") == 0) {
        return true;
    }
    bool fine = *at >= '0' && *at <= '9';
    if (fine && strlen(at) == 4 && !strchr(at, ':')) {
        fine = sscanf(at, "%2d%2d%n", &hours, &minutes, &end) == 2;
    } else if (fine) {
        fine = sscanf(at, "%2d:%2d%n", &hours, &minutes, &end) == 2 ||
               sscanf(at, "%2d%n", &hours, &end) == 1;
    }
    *out = (*text == '-' ? -1 : 1) * (hours * 3600.0 + minutes * 60.0);
    return fine && at[end] == '\0' && hours <= 18 && minutes >= 0 &&
           minutes < 60;
}

static bool reference_of(const char *text, struct reference *out)
{
    int hour = 0, minute = 0, end = 0;
    double second = 0, zone;
    struct reference r = { 0 };
    if (sscanf(text, "%ld-%ld-%ld%n", &r.year, &r.month, &r.day, &end) != 3 ||
        r.year < 0 || r.year > 9999 || r.month < 1 || r.month > 12 ||
        r.day < 1 || r.day > 31) {
        return false;
    }
    const char *at = text + end;
    at += *at == 'T' || *at == 't';
    at += strspn(at, " ");
    if (*at >= '0' && *at <= '9') {
        end = 0;
        (void)(sscanf(at, "%d:%d:%lf%n", &hour, &minute, &second, &end) == 3 ||
               sscanf(at, "%d:%d%n", &hour, &minute, &end) == 2 ||
               sscanf(at, "%d%n", &hour, &end) == 1);
        at += end;
    }
    at += strspn(at, " ");
    char word[16];
    size_t length = strcspn(at, " ");
    snprintf(word, sizeof word, "%.*s", length < sizeof word ? (int)length : 0,
             at);
    at += length + strspn(at + length, " ");
    if (*at || length >= sizeof word || hour < 0 || hour > 24 || minute < 0 ||
        minute > 59 || !(second >= 0 && second < 61) || !zone_s(word, &zone)) {
        return false;
    }
    r.second = hour * 3600.0 + minute * 60.0 + second - zone;
    *out = r;
    return true;
}

/* The Gregorian day of that name. */
static bool named_day(enum calendar c, long number, long *unix_day)
{
    long of_year = c == OF_360 ? 360 : c == ALL_LEAP ? 366 : 365;
    long y = floor_div(number, of_year), rest = number - y * of_year, m = 1;
    while (m < 12 && rest >= days_in(c, y, m)) {
        rest -= days_in(c, y, m);
        m++;
    }
    *unix_day = julian_day(y, m, rest + 1, true) - UNIX_DAY;
    return rest < days_in(GREGORIAN, y, m);
}

static enum pel_err cannot(const char *units, struct pel_fault *fault)
{
    return pel_fault_set(fault, PEL_ERR_INVALID,
                         "its fields have no time that can be read: \"%.80s\" "
                         "is not \"hours since 1970-01-01\" or the like",
                         units);
}

enum pel_err pel_cf_time(const char *units, const char *calendar, double value,
                         double *unix_s, struct pel_fault *fault)
{
    enum calendar c = MIXED;
    struct reference r;
    size_t length = strcspn(units, " ");
    const char *since = units + length + strspn(units + length, " ");
    double unit = pel_cf_unit_s(units, length);
    if (calendar && *calendar && !calendar_of(calendar, &c)) {
        return pel_fault_set(fault, PEL_ERR_INVALID,
                             "its calendar is \"%.40s\"; CF's standard, "
                             "proleptic_gregorian, julian, noleap, all_leap "
                             "and 360_day are read",
                             calendar);
    }
    if (!(unit > 0) || strncasecmp(since, "since ", 6) != 0 ||
        !reference_of(since + 6 + strspn(since + 6, " "), &r) ||
        r.day > days_in(c, r.year, r.month) || (c == MIXED && r.year == 0)) {
        return cannot(units, fault);
    }
    double seconds = value * unit + r.second;
    if (!(fabs(seconds) < 9e11)) {
        return pel_fault_set(
            fault, PEL_ERR_INVALID,
            "its fields have no time that can be read: %g %.80s", value, units);
    }
    double days = floor(seconds / DAY_S);
    long day = number_of(c, r.year, r.month, r.day) + (long)days - UNIX_DAY;
    if (c >= NO_LEAP && !named_day(c, day + UNIX_DAY, &day)) {
        return pel_fault_set(fault, PEL_ERR_INVALID,
                             "by its calendar \"%.40s\" a time is of a day "
                             "that there is not, as 30 February: give it "
                             "another, as by cdo setcalendar,standard IN OUT",
                             calendar);
    }
    *unix_s =
        (double)day * DAY_S + rint((seconds - days * DAY_S) * 1000) / 1000;
    return fabs(*unix_s) < PEL_CF_MOST_UNIX_S ? PEL_OK : cannot(units, fault);
}
