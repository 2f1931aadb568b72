/* Units as NetCDF files write them. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "weather/reader/forecast.h"

/* Powers of a metre and a second. */
struct power {
    int metres, seconds;
    double factor;
};

static const struct base {
    const char *names; /* between spaces */
    struct power power;
} bases[] = {
    { " m meter meters metre metres ", { 1, 0, 1 } },
    { " km kilometer kilometers kilometre kilometres ", { 1, 0, 1e3 } },
    { " dm decimeter decimeters decimetre decimetres ", { 1, 0, 0.1 } },
    { " cm centimeter centimeters centimetre centimetres ", { 1, 0, 0.01 } },
    { " mm millimeter millimeters millimetre millimetres ", { 1, 0, 1e-3 } },
    { " ft foot feet international_foot international_feet ",
      { 1, 0, 0.3048 } },
    { " us_survey_foot us_survey_feet ", { 1, 0, 1200.0 / 3937 } },
    { " in inch inches ", { 1, 0, 0.0254 } },
    { " yd yard yards ", { 1, 0, 0.9144 } },
    { " fathom fathoms fath ftm ", { 1, 0, 1.8288 } },
    { " mi mile miles ", { 1, 0, 1609.344 } },
    { " nmi nautical_mile nautical_miles nauticalmile nauticalmiles ",
      { 1, 0, 1852 } },
    { " kt kts kn knot knots knot_international international_knot "
      "international_knots ",
      { 1, -1, 1852.0 / 3600 } },
    { " mps ", { 1, -1, 1 } },
    { " kmh kph kmph ", { 1, -1, 1 / 3.6 } },
    { " mph ", { 1, -1, 0.44704 } },
    { " hz hertz ", { 0, -1, 1 } },
    { " mhz millihertz ", { 0, -1, 1e-3 } },
};

static const struct {
    const char *names;
    double seconds;
} times[] = {
    { " s sec secs second seconds ", 1 },
    { " ms msec msecs millisecond milliseconds ", 1e-3 },
    { " us usec microsecond microseconds ", 1e-6 },
    { " ns nanosecond nanoseconds ", 1e-9 },
    { " min mins minute minutes ", 60 },
    { " h hr hrs hour hours ", 3600 },
    { " d day days ", 86400 },
    { " week weeks ", 604800 },
};

static bool among(const char *list, const char *word, size_t length)
{
    for (const char *at = list; length > 0 && *at; at++) {
        if (*at == ' ' && strncasecmp(at + 1, word, length) == 0 &&
            at[1 + length] == ' ') {
            return true;
        }
    }
    return false;
}

double pel_forecast_unit_s(const char *unit, size_t length)
{
    for (size_t i = 0; i < sizeof times / sizeof *times; i++) {
        if (among(times[i].names, unit, length)) {
            return times[i].seconds;
        }
    }
    return 0;
}

static bool base_of(const char *word, size_t length, struct power *out)
{
    double s = pel_forecast_unit_s(word, length);
    if (s > 0) {
        *out = (struct power){ 0, 1, s };
        return true;
    }
    /* Mm and MHz are none that a sea has, so letters may be of any case. */
    for (size_t i = 0; i < sizeof bases / sizeof *bases; i++) {
        if (among(bases[i].names, word, length)) {
            *out = bases[i].power;
            return true;
        }
    }
    return false;
}

/* "-1", "**-1", "^-1", "2"; none: 1. */
static int exponent(const char **at)
{
    const char *p = *at;
    char *end;
    p += *p == '^' ? 1 : strncmp(p, "**", 2) == 0 ? 2 : 0;
    long n = strtol(p, &end, 10);
    bool digits = end > p && *p != ' ';
    *at = digits ? end : *at;
    return digits && n >= -4 && n <= 4 ? (int)n : digits ? 99 : 1;
}

/* "m s-1", "km/h", "metres per second", "0.01 m". */
static bool product(const char *unit, struct power *out)
{
    int sign = 1;
    bool any = false;
    *out = (struct power){ 0, 0, 1 };
    for (const char *at = unit; *at;) {
        struct power one;
        char *end;
        size_t length = strspn(at, "abcdefghijklmnopqrstuvwxyz_"
                                   "ABCDEFGHIJKLMNOPQRSTUVWXYZ");
        if (length == 0 && strchr(" .*", *at)) {
            at++;
        } else if (*at == '/' || (length == 3 && !strncasecmp(at, "per", 3))) {
            sign = -1;
            at += length ? length : 1;
        } else if (length == 0) {
            double n = strtod(at, &end);
            if (end == at || !(n > 0) || !isfinite(n)) {
                return false;
            }
            out->factor *= sign > 0 ? n : 1 / n;
            at = end;
        } else {
            if (!base_of(at, length, &one)) {
                return false;
            }
            at += length;
            int n = sign * exponent(&at);
            out->metres += n * one.metres;
            out->seconds += n * one.seconds;
            out->factor *= pow(one.factor, n);
            any = true;
        }
    }
    return any;
}

/* "degrees_true", "degree (clockwise from north)", "radians". */
static bool angle(const char *unit, double *factor)
{
    static const char first[] = " deg degs degree degrees \u00b0 degt ";
    static const char radians[] = " rad rads radian radians ";
    static const char rest[] = " true t north clockwise cw from compass "
                               "nautical meteorological ";
    bool named = false;
    for (const char *at = unit; *at;) {
        size_t length = strcspn(at, " _(),");
        bool is_radian = !named && among(radians, at, length);
        if (length > 0 && !named) {
            if (!is_radian && !among(first, at, length)) {
                return false;
            }
            *factor = is_radian ? 180 / M_PI : 1;
            named = true;
        } else if (length > 0 && !among(rest, at, length)) {
            return false;
        }
        at += length + (at[length] != '\0');
    }
    return named;
}

bool pel_forecast_unit(const char *unit, enum pel_forecast_quantity quantity,
                       double *factor)
{
    static const struct power wanted[] = {
        [PEL_FORECAST_MPS] = { 1, -1, 0 },
        [PEL_FORECAST_M] = { 1, 0, 0 },
        [PEL_FORECAST_S] = { 0, 1, 0 },
        [PEL_FORECAST_HZ] = { 0, -1, 0 },
    };
    struct power has;
    if (quantity == PEL_FORECAST_DEG) {
        return angle(unit, factor);
    }
    if (!product(unit, &has) || has.metres != wanted[quantity].metres ||
        has.seconds != wanted[quantity].seconds) {
        return false;
    }
    *factor = has.factor;
    return true;
}
