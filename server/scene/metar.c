#include "scene/metar.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fault.h"

#define KNOT (1852.0 / 3600)
#define MILE 1609.344
#define FEET 0.3048

/* The order of groups; each may be missing but the station. */
enum stage {
    TYPE,
    STATION,
    WHEN,
    HOW,
    WIND,
    VARIABLE,
    VISIBILITY,
    RUNWAY,
    WEATHER,
    CLOUD,
    TEMPERATURE,
    PRESSURE,
    AFTER,
    STAGES
};

static const char *const may_be[STAGES] = {
    [TYPE] = "METAR, SPECI or the station's four letters",
    [STATION] = "the station's four letters",
    [WHEN] = "day and time, as 151350Z",
    [HOW] = "AUTO or COR, or wind, as 24015G25KT or 08007MPS",
    [WIND] = "wind, as 24015G25KT, VRB03KT or 08007MPS",
    [VARIABLE] = "the wind's directions, as 210V270, or visibility, as 0400, "
                 "9999, CAVOK or 1 1/2SM",
    [VISIBILITY] = "visibility, as 0400, 9999, CAVOK or 1 1/2SM",
    [RUNWAY] = "a runway's visual range, as R24/0600U, weather, as -RA, BR or "
               "+TSRA, or clouds, as BKN012, OVC008CB, VV002 or NSC",
    [WEATHER] = "weather, as -RA, BR or +TSRA, or clouds, as BKN012, OVC008CB, "
                "VV002 or NSC",
    [CLOUD] = "clouds, as BKN012, OVC008CB, VV002 or NSC, or temperature and "
              "dew point, as 12/M03",
    [TEMPERATURE] = "temperature and dew point, as 12/M03, or pressure, as "
                    "Q1013 or A2992",
    [PRESSURE] = "pressure, as Q1013 or A2992, or a trend, as NOSIG",
    [AFTER] =
        "recent weather, as RERA, wind shear, a trend, as NOSIG or BECMG, "
        "or RMK",
};

/* Whether `g` is PATTERN: # a digit, @ a capital letter, / as itself; others
 * themselves. */
static bool like(const char *g, const char *pattern)
{
    for (; *pattern; pattern++, g++) {
        bool digit = *g >= '0' && *g <= '9', letter = *g >= 'A' && *g <= 'Z';
        if (*pattern == '#'   ? !digit
            : *pattern == '@' ? !letter
                              : *g != *pattern) {
            return false;
        }
    }
    return !*g;
}

/* The first `count` digits. */
static int number(const char *g, int count)
{
    int n = 0;
    while (count-- > 0) {
        n = 10 * n + (*g++ - '0');
    }
    return n;
}

static int digits(const char *g)
{
    return (int)strspn(g, "0123456789");
}

/* --- groups: true, and what it says --------------------------------------- */

static bool take_station(const char *g)
{
    return strlen(g) == 4 && g[0] >= 'A' && g[0] <= 'Z' &&
           strspn(g, "ABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789") == 4;
}

static bool take_time(const char *g)
{
    return like(g, "######Z") && number(g, 2) >= 1 && number(g, 2) <= 31 &&
           number(g + 2, 2) <= 23 && number(g + 4, 2) <= 59;
}

/* Two or three digits, with P before them where it is more than that. */
static bool take_speed(const char **g, double *out)
{
    *g += **g == 'P';
    int n = digits(*g);
    if (n < 2 || n > 3) {
        return false;
    }
    *out = number(*g, n);
    *g += n;
    return true;
}

static bool take_wind(const char *g, struct pel_metar *m)
{
    bool variable = strncmp(g, "VRB", 3) == 0;
    bool unknown = strncmp(g, "///", 3) == 0;
    if (like(g, "/////KT") || like(g, "/////MPS") || like(g, "/////") ||
        like(g, "###//KT") || like(g, "###//MPS")) {
        return true;
    }
    if (!variable && !unknown && (digits(g) < 3 || number(g, 3) > 360)) {
        return false;
    }
    double direction = variable || unknown ? 0 : number(g, 3);
    double speed, gust = 0;
    g += 3;
    if (!take_speed(&g, &speed)) {
        return false;
    }
    if (strncmp(g, "G//", 3) == 0) {
        g += 3;
    } else if (*g == 'G' && (g++, !take_speed(&g, &gust))) {
        return false;
    }
    double unit = strcmp(g, "KT") == 0    ? KNOT
                  : strcmp(g, "MPS") == 0 ? 1
                  : strcmp(g, "KMH") == 0 ? 1 / 3.6
                                          : 0;
    if (unit == 0 || (gust > 0 && gust < speed)) {
        return false;
    }
    m->has_wind = true;
    m->has_direction = !variable && !unknown && speed > 0;
    m->direction_deg = direction;
    m->wind_mps = unit * speed;
    m->gust_mps = unit * gust;
    return true;
}

static void set_visibility(struct pel_metar *m, double metres, bool more)
{
    /* A second group names the worst direction: the first holds. */
    if (!m->has_visibility) {
        m->has_visibility = true;
        m->visibility_m = metres;
        m->ten_km = more;
    }
}

static bool take_metres(const char *g, struct pel_metar *m)
{
    static const char *const ways[] = { "",  "N",  "NE", "E",  "SE",
                                        "S", "SW", "W",  "NW", "NDV" };
    if (strcmp(g, "CAVOK") == 0) {
        set_visibility(m, 1e4, true);
        m->has_clouds = true;
        return true;
    }
    if (like(g, "////")) {
        return true;
    }
    if (digits(g) != 4) {
        return false;
    }
    for (size_t i = 0; i < sizeof ways / sizeof *ways; i++) {
        if (strcmp(g + 4, ways[i]) == 0) {
            int v = number(g, 4);
            set_visibility(m, v == 9999 ? 1e4 : v, v == 9999);
            return true;
        }
    }
    return false;
}

/* A fraction below 1, before which a whole number may stand without a blank, as
 * automatic stations write it: 1/2, 11/16, 11/2 for 1 1/2, 103/4 for 10 3/4. */
static bool take_fraction(const char **g, double *out)
{
    int n = digits(*g), over = 0, under = 0;
    const char *below = *g + n + 1;
    int places = n > 0 && (*g)[n] == '/' ? digits(below) : 0;
    if (n > 3 || places < 1 || places > 2) {
        return false;
    }
    under = number(below, places);
    *out = 0;
    over = number(*g, n);
    if (over >= under && n > 1) {
        *out = number(*g, n - 1);
        over = number(*g + n - 1, 1);
    }
    if (over < 1 || over >= under) {
        return false;
    }
    *out += (double)over / under;
    *g = below + places;
    return true;
}

/* Statute miles: 10SM, 1/2SM, 11/2SM, M1/4SM, P6SM; `whole` went before, as in
 * 1 1/2SM. Kilometres: 10KM. */
static bool take_miles(const char *g, int whole, struct pel_metar *m)
{
    double far = 0;
    bool more = *g == 'P';
    if (like(g, "////SM")) {
        return true;
    }
    g += *g == 'P' || *g == 'M';
    if (take_fraction(&g, &far)) {
        if (whole && far >= 1) {
            return false;
        }
        far += whole;
    } else {
        int n = digits(g);
        if (n < 1 || n > 2 || whole) {
            return false;
        }
        far = number(g, n);
        g += n;
    }
    if (strcmp(g, "SM") != 0 && strcmp(g, "KM") != 0) {
        return false;
    }
    far *= *g == 'S' ? MILE : 1000;
    set_visibility(m, far, more || far >= 1e4);
    return true;
}

static bool take_runway(const char *g)
{
    const char *slash = strchr(g, '/');
    size_t name = slash ? (size_t)(slash - g) : 0;
    return *g == 'R' && digits(g + 1) == 2 && (name == 3 || name == 4) &&
           (name == 3 || strchr("LCR", g[3])) && strlen(slash) >= 5 &&
           (strspn(slash + 1, "0123456789/MPVFTUDN") == strlen(slash + 1) ||
            strncmp(slash, "/CLRD", 5) == 0 || strcmp(slash, "/SNOCLO") == 0);
}

enum how { LIGHT, MODERATE, HEAVY };

/* By WMO's bounds: light below 2.5, heavy above 10 mm/h (in showers 2, 10 and
 * 50); drizzle 0.1 and 0.5; snow as water 1 and 5 (that it hides by). */
static double falls(const char *kind, bool shower, enum how how)
{
    static const double rain[] = { 1, 5, 16 }, showers[] = { 1.5, 6, 25 },
                        drizzle[] = { 0.05, 0.3, 0.8 }, snow[] = { 0.5, 2, 6 };
    return strcmp(kind, "RA") == 0   ? (shower ? showers : rain)[how]
           : strcmp(kind, "DZ") == 0 ? drizzle[how]
                                     : snow[how];
}

static void take_phenomenon(const char *kind, const char *as, bool near,
                            enum how how, struct pel_metar *m)
{
    static const char *const frozen = "SN SG PL IC";
    bool shower = strstr(as, "SH") || strstr(as, "TS");
    if (strstr(as, "DR") || strstr(as, "BL")) {
        return; /* the wind raises it: nothing falls */
    }
    if (near) {
        m->fog = strcmp(kind, "FG") == 0 ? PEL_METAR_PATCHES : m->fog;
    } else if (strcmp(kind, "RA") == 0 || strcmp(kind, "DZ") == 0 ||
               strcmp(kind, "UP") == 0) {
        m->rain_mm_h +=
            falls(strcmp(kind, "UP") == 0 ? "RA" : kind, shower, how);
    } else if (strstr(frozen, kind)) {
        m->snow_mm_h += falls(kind, shower, how);
    } else if (strcmp(kind, "GR") == 0 || strcmp(kind, "GS") == 0) {
        m->hail = true;
    } else if (strcmp(kind, "FG") == 0) {
        m->fog = strstr(as, "MI")                       ? PEL_METAR_SHALLOW
                 : strstr(as, "BC") || strstr(as, "PR") ? PEL_METAR_PATCHES
                                                        : PEL_METAR_FOG;
    }
}

/* [+-] or VC, then MI PR BC DR BL SH TS FZ, then up to three kinds. */
static bool take_weather(const char *g, struct pel_metar *m)
{
    static const char *const as = "MI PR BC DR BL SH TS FZ";
    static const char *const kinds =
        "DZ RA SN SG IC PL GR GS UP BR FG FU VA DU "
        "SA HZ PO SQ FC SS DS";
    enum how how = *g == '-' ? LIGHT : *g == '+' ? HEAVY : MODERATE;
    g += *g == '-' || *g == '+';
    if (like(g, "//") || strcmp(g, "NSW") == 0) {
        return true;
    }
    bool near = strncmp(g, "VC", 2) == 0;
    g += near ? 2 : 0;
    char described[8] = "";
    struct pel_metar next = *m;
    int count = 0;
    size_t length = strlen(g);
    if (length < 2 || length > 10 || length % 2) {
        return false;
    }
    for (; *g; g += 2) {
        const char two[3] = { g[0], g[1], 0 };
        if (!count && strstr(as, two) && strlen(described) < 4) {
            memcpy(described + strlen(described), two, 3);
        } else if (strstr(kinds, two) && two[0] != ' ' && two[1] != ' ' &&
                   ++count <= 3) {
            take_phenomenon(two, described, near, how, &next);
        } else {
            return false;
        }
    }
    /* TS, and VCSH, stand alone. */
    bool alone =
        strcmp(described, "TS") == 0 || (near && strcmp(described, "SH") == 0);
    if (!count && !alone) {
        return false;
    }
    next.thunder |= strstr(described, "TS") != NULL;
    *m = next;
    return true;
}

static bool is_genus(const char *g)
{
    static const char *const genera[] = { "CB",  "TCU",  "///", "CU", "SC",
                                          "ST",  "NS",   "AS",  "AC", "CI",
                                          "CS",  "CC",   "CF",  "SF", "CUFRA",
                                          "ACC", "STFRA" };
    for (size_t i = 0; i < sizeof genera / sizeof *genera; i++) {
        if (strcmp(g, genera[i]) == 0) {
            return true;
        }
    }
    return false;
}

static bool take_cloud(const char *g, struct pel_metar *m)
{
    static const struct {
        const char *name;
        int octas;
    } covers[] = {
        { "FEW", 2 }, { "SCT", 4 }, { "BKN", 6 }, { "OVC", 8 }, { "///", 0 }
    };
    static const char *const none[] = { "SKC", "CLR", "NSC", "NCD", "NCDCLR" };
    for (size_t i = 0; i < sizeof none / sizeof *none; i++) {
        if (strcmp(g, none[i]) == 0) {
            m->has_clouds = true;
            return true;
        }
    }
    if (like(g, "VV###") || like(g, "VV///")) {
        m->has_clouds = true;
        if (g[2] != '/' && m->octas < 8) {
            m->octas = 8;
            m->base_m = 100 * FEET * number(g + 2, 3);
        }
        return true;
    }
    for (size_t i = 0; i < sizeof covers / sizeof *covers; i++) {
        const char *h = g + 3, *kind;
        if (strncmp(g, covers[i].name, 3) != 0 ||
            (digits(h) != 3 && strncmp(h, "///", 3) != 0)) {
            continue;
        }
        kind = h + 3;
        bool cb = strcmp(kind, "CB") == 0, tcu = strcmp(kind, "TCU") == 0;
        if (*kind && !is_genus(kind)) {
            return false;
        }
        m->has_clouds |= covers[i].octas > 0;
        if (*h != '/' && (covers[i].octas > m->octas ||
                          (covers[i].octas == m->octas &&
                           number(h, 3) * 30.48 < m->base_m))) {
            m->octas = covers[i].octas;
            m->base_m = 100 * FEET * number(h, 3);
        }
        m->thunderclouds |= cb;
        m->towering |= tcu;
        return true;
    }
    return false;
}

/* -99 .. 99; false: no such number. */
static bool take_degrees(const char **g, double *out)
{
    double sign = **g == 'M' ? -1 : 1;
    *g += **g == 'M';
    if (digits(*g) != 2) {
        return false;
    }
    *out = sign * number(*g, 2);
    *g += 2;
    return true;
}

static bool take_temperature(const char *g, struct pel_metar *m)
{
    double t, d;
    if (like(g, "/////")) {
        return true;
    }
    if (!take_degrees(&g, &t) || *g++ != '/') {
        return false;
    }
    bool has = take_degrees(&g, &d);
    if ((!has && *g && strcmp(g, "//") != 0 && strcmp(g, "XX") != 0) ||
        (has && (*g || d > t))) {
        return false;
    }
    m->has_temperature = true;
    m->temperature_c = t;
    m->has_dew_point = has;
    m->dew_point_c = has ? d : 0;
    return true;
}

static bool take_pressure(const char *g, struct pel_metar *m)
{
    if (like(g, "Q////") || like(g, "A////")) {
        return true;
    }
    if (!like(g, "Q####") && !like(g, "A####")) {
        return false;
    }
    double hpa =
        *g == 'Q' ? number(g + 1, 4) : number(g + 1, 4) * 0.01 * 33.8638866667;
    if (hpa < 850 || hpa > 1090) {
        return false;
    }
    m->has_pressure = true;
    m->pressure_hpa = hpa;
    return true;
}

static bool ends_it(const char *g)
{
    static const char *const words[] = { "RMK",   "NOSIG",  "BECMG", "TEMPO",
                                         "INTER", "PROB30", "PROB40" };
    for (size_t i = 0; i < sizeof words / sizeof *words; i++) {
        if (strcmp(g, words[i]) == 0) {
            return true;
        }
    }
    return false;
}

/* The sea as aerodromes on the coast give it: W19/S4, WM01/S3, W///H17. */
static bool take_sea(const char *g)
{
    if (*g++ != 'W') {
        return false;
    }
    g += *g == 'M';
    if (digits(g) != 2 && strncmp(g, "//", 2) != 0) {
        return false;
    }
    g += 2;
    size_t rest = strspn(g, "/SH0123456789");
    return *g == '/' && (g[1] == 'S' || g[1] == 'H') && rest == strlen(g) &&
           rest <= 6;
}

/* The colour code in which airfields of armed forces report their weather. */
static bool take_colour(const char *g)
{
    static const char *const colours[] = { "BLU",  "BLU+", "WHT", "GRN", "YLO",
                                           "YLO1", "YLO2", "AMB", "RED" };
    bool black = strncmp(g, "BLACK", 5) == 0;
    g += black ? 5 : 0;
    for (size_t i = 0; i < sizeof colours / sizeof *colours; i++) {
        if (strcmp(g, colours[i]) == 0) {
            return true;
        }
    }
    return black && !*g;
}

static bool take_after(const char *g)
{
    static const char *const words[] = { "WS",       "ALL",    "RWY",
                                         "TKOF",     "LDG",    "$",
                                         "R/SNOCLO", "SNOCLO", "RVRNO" };
    struct pel_metar aside = { .has_wind = false };
    for (size_t i = 0; i < sizeof words / sizeof *words; i++) {
        if (strcmp(g, words[i]) == 0) {
            return true;
        }
    }
    return (strncmp(g, "RE", 2) == 0 && take_weather(g + 2, &aside)) ||
           like(g, "R##") || like(g, "R##@") || like(g, "RWY##") ||
           like(g, "RWY##@") || like(g, "########") || take_sea(g) ||
           take_colour(g) || take_runway(g);
}

/* --- the report ----------------------------------------------------------- */

static bool take_at(enum stage stage, const char *g, int *whole,
                    struct pel_metar *m)
{
    switch (stage) {
    case TYPE:
        return strcmp(g, "METAR") == 0 || strcmp(g, "SPECI") == 0 ||
               strcmp(g, "COR") == 0;
    case STATION:
        return take_station(g);
    case WHEN:
        return take_time(g);
    case HOW:
        return strcmp(g, "AUTO") == 0 || strcmp(g, "COR") == 0 ||
               strcmp(g, "RTD") == 0 || like(g, "CC@") || like(g, "RR@");
    case WIND:
        return take_wind(g, m);
    case VARIABLE:
        return like(g, "###V###") && number(g, 3) <= 360 &&
               number(g + 4, 3) <= 360;
    case VISIBILITY:
        if (like(g, "#") && !*whole) {
            *whole = number(g, 1);
            return true;
        }
        if (*whole) {
            bool good = take_miles(g, *whole, m);
            *whole = good ? 0 : *whole;
            return good;
        }
        return take_metres(g, m) || take_miles(g, 0, m);
    case RUNWAY:
        m->ignored += take_runway(g);
        return take_runway(g);
    case WEATHER:
        return take_weather(g, m);
    case CLOUD:
        return take_cloud(g, m);
    case TEMPERATURE:
        return take_temperature(g, m);
    case PRESSURE:
        return take_pressure(g, m);
    case AFTER:
        m->ignored += take_after(g);
        return take_after(g);
    case STAGES:
        break;
    }
    return false;
}

/* The kind of a group: in the order of the code, or, as some stations send
 * them, behind groups that should follow it, where none of its kind has been.
 * STAGES: none. */
static enum stage kind_of(enum stage from, unsigned seen, const char *g,
                          int *whole, struct pel_metar *m)
{
    enum stage at = from;
    while (at < STAGES && !take_at(at, g, whole, m)) {
        if (at == STATION || *whole) {
            return STAGES;
        }
        at++;
    }
    for (enum stage s = WIND; at == STAGES && s < from && s <= PRESSURE; s++) {
        if (!(seen & 1u << s) && take_at(s, g, whole, m)) {
            at = s;
        }
    }
    return at;
}

/* Whether groups of this kind come more than once. */
static bool repeats(enum stage s)
{
    return s == TYPE || s == HOW || s == VISIBILITY || s == RUNWAY ||
           s == WEATHER || s == CLOUD || s == PRESSURE || s == AFTER;
}

static enum pel_err refuse(const char *group, const char *what,
                           struct pel_fault *fault)
{
    return pel_fault_refuse(PEL_ERR_INVALID, "sky.metar", group, what, fault);
}

static enum pel_err wrong(enum stage stage, const char *group,
                          struct pel_fault *fault)
{
    char what[320];
    snprintf(what, sizeof what,
             "has %s, which is no group that may stand there: %s", group,
             may_be[stage < STAGES ? stage : AFTER]);
    return refuse(group, what, fault);
}

enum pel_err pel_metar_parse(const char *text, struct pel_metar *out,
                             struct pel_fault *fault)
{
    static const char *const space = " \t\r\n";
    char group[32];
    enum stage stage = TYPE;
    int whole = 0;
    unsigned seen = 0; /* a bit a stage */
    *out = (struct pel_metar){ .has_wind = false };
    if (strlen(text) > PEL_METAR_MOST) {
        return refuse(NULL, "is longer than 512 bytes", fault);
    }
    for (text += strspn(text, space); *text; text += strspn(text, space)) {
        size_t length = strcspn(text, " \t\r\n=");
        snprintf(group, sizeof group, "%.*s", (int)length, text);
        if (length >= sizeof group) {
            return wrong(stage, group, fault);
        }
        text += length;
        bool end = *text == '=';
        text += end;
        if (length && stage > STATION && ends_it(group)) {
            out->ignored++;
            break;
        }
        if (length) {
            enum stage from = whole ? VISIBILITY : stage;
            enum stage at = kind_of(from, seen, group, &whole, out);
            if (at == STAGES) {
                return wrong(from, group, fault);
            }
            seen |= 1u << at;
            at = repeats(at) ? at : at + 1;
            stage = at > stage ? at : stage;
        }
        if (end) {
            break;
        }
    }
    if (!(seen & 1u << STATION)) {
        return refuse(NULL, "has no station, as EHAM", fault);
    }
    if (whole) {
        return wrong(VISIBILITY, group, fault);
    }
    return PEL_OK;
}
