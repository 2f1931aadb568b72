#include "base/cf.h"

#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

static const struct base {
    const char *names; /* between spaces */
    struct pel_cf_power power;
} bases[] = {
    { " m meter meters metre metres ", { 1, 0, 0, 1 } },
    { " km kilometer kilometers kilometre kilometres ", { 1, 0, 0, 1e3 } },
    { " dm decimeter decimeters decimetre decimetres ", { 1, 0, 0, 0.1 } },
    { " cm centimeter centimeters centimetre centimetres ", { 1, 0, 0, 0.01 } },
    { " mm millimeter millimeters millimetre millimetres ", { 1, 0, 0, 1e-3 } },
    { " ft foot feet international_foot international_feet ",
      { 1, 0, 0, 0.3048 } },
    { " us_survey_foot us_survey_feet us_survey_ft us_ft ft_us ftus usft "
      "foot_us feet_us survey_foot survey_feet foot_us_survey "
      "us_foot us_feet ",
      { 1, 0, 0, 1200.0 / 3937 } },
    { " in inch inches ", { 1, 0, 0, 0.0254 } },
    { " yd yard yards ", { 1, 0, 0, 0.9144 } },
    { " fathom fathoms fath ftm fm ", { 1, 0, 0, 1.8288 } },
    { " mi mile miles ", { 1, 0, 0, 1609.344 } },
    { " nmi nautical_mile nautical_miles nauticalmile nauticalmiles ",
      { 1, 0, 0, 1852 } },
    { " kt kts kn knot knots knot_international international_knot "
      "international_knots ",
      { 1, -1, 0, 1852.0 / 3600 } },
    { " mps ", { 1, -1, 0, 1 } },
    { " kmh kph kmph ", { 1, -1, 0, 1 / 3.6 } },
    { " mph ", { 1, -1, 0, 0.44704 } },
    { " hz hertz ", { 0, -1, 0, 1 } },
    { " mhz millihertz ", { 0, -1, 0, 1e-3 } },
    { " rad rads radian radians ", { 0, 0, 1, 1 } },
    { " deg degs degr degree degrees \u00b0 ", { 0, 0, 1, M_PI / 180 } },
};

static const struct {
    const char *names;
    double seconds;
} clocks[] = {
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

double pel_cf_unit_s(const char *unit, size_t length)
{
    for (size_t i = 0; i < sizeof clocks / sizeof *clocks; i++) {
        if (among(clocks[i].names, unit, length)) {
            return clocks[i].seconds;
        }
    }
    return 0;
}

static bool base_of(const char *word, size_t length, struct pel_cf_power *out)
{
    double s = pel_cf_unit_s(word, length);
    if (s > 0) {
        *out = (struct pel_cf_power){ 0, 1, 0, s };
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

/* "-1", "**-1", "^-1", "{-1}", "2"; none: 1. */
static int exponent(const char **at)
{
    const char *p = *at;
    char *end;
    p += *p == '^' ? 1 : strncmp(p, "**", 2) == 0 ? 2 : 0;
    bool braced = *p == '{';
    p += braced;
    long n = strtol(p, &end, 10);
    bool digits = end > p && *p != ' ';
    end += digits && braced && *end == '}';
    *at = digits ? end : *at;
    return digits && n >= -4 && n <= 4 ? (int)n : digits ? 99 : 1;
}

/* Letters, with those of "°" and of names with a low line. */
static size_t letters(const char *at)
{
    size_t n = 0;
    while (isalpha((unsigned char)at[n]) || at[n] == '_' || (at[n] & 0x80)) {
        n++;
    }
    return n;
}

/* Names of several words as one: "US survey foot", "nautical miles". */
static void join_names(const char *unit, char out[96])
{
    static const char *const before[] = { "us", "survey", "nautical",
                                          "international" };
    snprintf(out, 96, "%s", unit);
    for (char *at = out; *at;) {
        size_t n = letters(at);
        bool joins = false;
        for (size_t i = 0; i < sizeof before / sizeof *before; i++) {
            size_t length = strlen(before[i]);
            joins |= n >= length &&
                     strncasecmp(at + n - length, before[i], length) == 0 &&
                     (n == length || at[n - length - 1] == '_');
        }
        if (n > 0 && joins && (at[n] == ' ' || at[n] == '-') &&
            letters(at + n + 1) > 0) {
            at[n] = '_';
            continue; /* with what it has joined */
        }
        at += n > 0 ? n : 1;
    }
}

static void times(struct pel_cf_power *to, const struct pel_cf_power *by, int n)
{
    to->metres += n * by->metres;
    to->seconds += n * by->seconds;
    to->radians += n * by->radians;
    to->factor *= pow(by->factor, n);
}

/* A name, a number, or a product in brackets, with what is behind it. */
static bool factor_of(const char **at, struct pel_cf_power *out, bool *named,
                      int depth);

/* Up to the end, or the bracket that closes it. As UDUNITS has it, / and per
 * are of the next factor alone. */
static bool product(const char **at, struct pel_cf_power *out, bool *named,
                    int depth)
{
    int sign = 1;
    *out = (struct pel_cf_power){ 0, 0, 0, 1 };
    while (**at && **at != ')') {
        struct pel_cf_power one;
        size_t length = letters(*at);
        if (length == 0 && strchr(" .*", **at)) {
            ++*at;
        } else if (**at == '/' ||
                   (length == 3 && !strncasecmp(*at, "per", 3))) {
            if (sign < 0) {
                return false;
            }
            sign = -1;
            *at += length ? length : 1;
        } else {
            if (!factor_of(at, &one, named, depth)) {
                return false;
            }
            times(out, &one, sign);
            sign = 1;
        }
    }
    return sign > 0;
}

static bool factor_of(const char **at, struct pel_cf_power *out, bool *named,
                      int depth)
{
    struct pel_cf_power one;
    char *end;
    size_t length = letters(*at);
    if (length == 0 && **at != '(') {
        double n = strtod(*at, &end);
        bool fine = end != *at && n > 0 && isfinite(n);
        *out = (struct pel_cf_power){ 0, 0, 0, n };
        *at = end;
        return fine;
    }
    if (length == 0) {
        ++*at;
        if (depth == 0 || !product(at, &one, named, depth - 1) || **at != ')') {
            return false;
        }
        ++*at;
    } else if (!base_of(*at, length, &one)) {
        return false;
    }
    *at += length;
    *named = true;
    int n = exponent(at);
    *out = (struct pel_cf_power){ 0, 0, 0, 1 };
    times(out, &one, n);
    return n >= -4 && n <= 4;
}

bool pel_cf_product(const char *unit, struct pel_cf_power *out)
{
    char text[96];
    const char *at = text;
    bool named = false;
    if (strlen(unit) >= sizeof text) {
        return false;
    }
    join_names(unit, text);
    return product(&at, out, &named, 4) && !*at && named;
}

/* "degrees_true", "degree (clockwise from north)", "radians". */
static bool angle(const char *unit, double *factor)
{
    static const char first[] = " deg degs degr degree degrees \u00b0 degt "
                                "degreet degreest ";
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

bool pel_cf_unit(const char *unit, enum pel_cf_quantity quantity,
                 double *factor)
{
    static const int wanted[][2] = {
        [PEL_CF_MPS] = { 1, -1 },
        [PEL_CF_M] = { 1, 0 },
        [PEL_CF_S] = { 0, 1 },
        [PEL_CF_HZ] = { 0, -1 },
    };
    struct pel_cf_power has;
    if (quantity == PEL_CF_DEG) {
        return angle(unit, factor);
    }
    if (!pel_cf_product(unit, &has) || has.metres != wanted[quantity][0] ||
        has.seconds != wanted[quantity][1] || has.radians != 0) {
        return false;
    }
    *factor = has.factor;
    return true;
}
