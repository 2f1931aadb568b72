/* What a variable says that it is beside its name: of which height, by which
 * method, of which run; and which way its directions go. */
#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "weather/reader/netcdffile.h"

/* The height that a name or title has in it ("u100", "100 metre U wind"); 0:
 * none. */
static double height_in(const char *text)
{
    for (const char *at = text; *at; at++) {
        if (isdigit((unsigned char)*at)) {
            char *end;
            double v = strtod(at, &end);
            end += *end == ' ' || *end == '-' || *end == '_';
            bool unit = (*end == 'm' && (!isalpha((unsigned char)end[1]) ||
                                         strncmp(end, "met", 3) == 0 ||
                                         strncmp(end, "mabove", 6) == 0)) ||
                        (at == text && isalpha((unsigned char)*end)) ||
                        (at == text + 1 && *end == '\0');
            if (unit && v > 0) {
                return v;
            }
            at = end - 1;
        }
    }
    return 0;
}

static const char *const heights_told[] = { "long_name", "level", "title" };
#define HEIGHTS_TOLD (sizeof heights_told / sizeof *heights_told)

/* Its name's height, or that of the `i`th text above. */
static double height_of(int id, int variable, size_t i)
{
    char text[256] = "", name[NC_MAX_NAME + 1] = "";
    if (i == 0) {
        (void)nc_inq_varname(id, variable, name);
        return height_in(name);
    }
    pel_netcdf_text(id, variable, heights_told[i - 1], text, sizeof text);
    return height_in(text);
}

double pel_netcdf_height_told(int id, int variable)
{
    double height = 0;
    for (size_t i = 0; i <= HEIGHTS_TOLD && height <= 0; i++) {
        height = height_of(id, variable, i);
    }
    return height;
}

static const char *has_one_of(const char *text, const char *const *words,
                              size_t count)
{
    for (size_t i = 0; i < count; i++) {
        if (strcasestr(text, words[i])) {
            return words[i];
        }
    }
    return NULL;
}

/* --- by which method --------------------------------------------------------
 */

/* A word of cell_methods, which ends behind a colon too, without what stands
 * in brackets; its length, 0: there is none. */
static size_t next_word(const char **at)
{
    while (**at == ' ' || **at == '(') {
        *at += **at == '(' ? strcspn(*at, ")") : 1;
        *at += **at == ')';
    }
    size_t length = strcspn(*at, " (:");
    return length + ((*at)[length] == ':');
}

/* Whether a dimension is one of place, over which a mean is as good. */
static bool is_of_place(int id, const char *name, size_t length)
{
    static const char places[] = " area lat lon latitude longitude x y rlat "
                                 "rlon nav_lat nav_lon grid_latitude "
                                 "grid_longitude ";
    char word[64];
    int v = -1;
    snprintf(word, sizeof word, " %.*s ", (int)(length < 60 ? length : 60),
             name);
    if (strcasestr(places, word)) {
        return true;
    }
    snprintf(word, sizeof word, "%.*s", (int)(length < 60 ? length : 60), name);
    enum pel_netcdf_role role = nc_inq_varid(id, word, &v)
                                    ? PEL_NETCDF_UNKNOWN
                                    : pel_netcdf_role_of(id, v);
    return role == PEL_NETCDF_LATITUDE || role == PEL_NETCDF_LONGITUDE;
}

/* CF's cell_methods: "area: mean time: point". NULL: all of one instant, else
 * where that begins which is not. */
static const char *other_method(int id, const char *text)
{
    const char *from = text;
    bool names = false, places = true, done = false;
    for (const char *at = text;;) {
        size_t length = next_word(&at);
        if (length == 0) {
            return done ? NULL : text; /* a method without a dimension */
        }
        if (at[length - 1] == ':') {
            from = names ? from : at;
            places = (names ? places : true) && is_of_place(id, at, length - 1);
            names = true;
        } else if (names || !done) {
            bool point = strncasecmp(at, "point", 5) == 0 ||
                         strncasecmp(at, "inst", 4) == 0;
            bool mean = length == 4 && strncasecmp(at, "mean", 4) == 0;
            if (!point && !(mean && names && places)) {
                return from;
            }
            names = false;
            done = true;
        } /* else "where sea", "over years" */
        at += length;
    }
}

/* --- which product ---------------------------------------------------------
 */

/* Of the ECMWF's data types those that are no run's own. */
static bool other_type(int id, int variable, char text[96])
{
    static const char none[] = " em es ep taem taes cl me fcm fcs eme ses ef "
                               "fp efi sot cd pb ";
    char type[16], word[20];
    bool told =
        pel_netcdf_text(id, variable, "GRIB_dataType", type, sizeof type);
    snprintf(word, sizeof word, " %s ", type);
    snprintf(text, 96, "dataType %s", type);
    if (told && strcmp(type, "pf") == 0) { /* else its number says which */
        int count = 0;
        (void)nc_inq_nvars(id, &count);
        while (count > 0 &&
               pel_netcdf_role_of(id, count - 1) != PEL_NETCDF_MEMBER) {
            count--;
        }
        return count == 0;
    }
    return told && strcasestr(none, word);
}

/* By its title: of statistics, and of what only looks like it. */
static bool other_title(int id, int variable, bool wind, char text[96])
{
    static const char *const all[] = {
        "precipitation", /* "tp", as a peak's period is */
        "standard deviation", "ensemble mean", "spread",      "anomal",
        "percentile",         "quantile",      "probability", " error",
        "climatolog",         "hourly mean",   "hour mean",   "daily mean",
        "monthly mean",       "time mean",     "time-mean",
    };
    static const char *const winds[] = { "gust", "maximum", "minimum", "stress",
                                         "current" };
    char title[256];
    pel_netcdf_text(id, variable, "long_name", title, sizeof title);
    snprintf(text, 96, "%.60s", title);
    return has_one_of(title, all, sizeof all / sizeof *all) ||
           (wind && has_one_of(title, winds, sizeof winds / sizeof *winds));
}

const char *pel_netcdf_other_product(int id, int variable,
                                     const struct pel_forecast_kind *kind,
                                     char out[96])
{
    char text[512];
    bool wind = kind->height == PEL_FORECAST_AT_10_M;
    if (pel_netcdf_text(id, variable, "GRIB_stepType", text, sizeof text) &&
        strcmp(text, "instant") != 0) {
        snprintf(out, 96, "stepType %.40s", text);
        return out;
    }
    const char *method =
        pel_netcdf_text(id, variable, "cell_methods", text, sizeof text)
            ? other_method(id, text)
            : NULL;
    if (method) {
        snprintf(out, 96, "cell_methods %.40s", method);
        return out;
    }
    if (other_type(id, variable, out) || other_title(id, variable, wind, out)) {
        return out;
    }
    for (size_t i = 0; wind && i <= HEIGHTS_TOLD; i++) {
        double height = height_of(id, variable, i);
        if (height > 0 && fabs(height - 10) > 1e-6) {
            snprintf(out, 96, "at %g m", height);
            return out;
        }
    }
    double level = 0;
    bool told = pel_netcdf_numbers(id, variable, "GRIB_level", 1, &level) == 1;
    pel_netcdf_text(id, variable, "GRIB_typeOfLevel", text, sizeof text);
    bool high = strcmp(text, "heightAboveSea") == 0 ||
                strcmp(text, "heightAboveGround") == 0;
    if (wind && *text && strcmp(text, "surface") != 0 &&
        !(high && (!told || fabs(level - 10) < 1e-6))) {
        snprintf(out, 96, "%.40s %g", text, level);
        return out;
    }
    return NULL;
}

/* --- which way -------------------------------------------------------------
 */

/* Whether "to" stands in it as a word that is of a way: not "relative to". */
static bool goes_to(const char *text)
{
    static const char *const before[] = { "relative ",  "respect ", "compared ",
                                          "according ", "due ",     "up ",
                                          "referred ",  "0 ",       "equal " };
    for (const char *at = strcasestr(text, "to"); at;
         at = strcasestr(at + 1, "to")) {
        bool word = (at == text || !isalnum((unsigned char)at[-1])) &&
                    !isalnum((unsigned char)at[2]);
        for (size_t i = 0; word && i < sizeof before / sizeof *before; i++) {
            size_t length = strlen(before[i]);
            word = at < text + length ||
                   strncasecmp(at - length, before[i], length) != 0;
        }
        if (word) {
            return true;
        }
    }
    return false;
}

enum pel_err pel_netcdf_check_way(int id, int variable,
                                  const struct pel_forecast_kind *kind,
                                  struct pel_fault *fault)
{
    static const char *const texts[] = {
        "long_name",  "comment",     "convention", "direction_convention",
        "definition", "description", "title",      "direction_reference",
        "note",       "reference",   "notes",      "conventions",
    };
    static const char *const to[] = { "toward",   "oceanographic", "propagat",
                                      "heading",  "travel",        "bound for",
                                      "flow dir", "moving" };
    static const char *const turned[] = { "cartesian",  "counter",
                                          "anticlock",  "anti-clock",
                                          "mathematic", "trigonometric",
                                          "from east" };
    char text[256], name[NC_MAX_NAME + 1] = "";
    bool named =
        pel_netcdf_text(id, variable, "standard_name", text, sizeof text) &&
        strcmp(text, "unknown") != 0;
    (void)nc_inq_varname(id, variable, name);
    for (size_t i = 0; kind->quantity == PEL_CF_DEG && !named &&
                       i < sizeof texts / sizeof *texts;
         i++) {
        pel_netcdf_text(id, variable, texts[i], text, sizeof text);
        if (has_one_of(text, turned, sizeof turned / sizeof *turned)) {
            return pel_fault_set(
                fault, PEL_ERR_INVALID,
                "%.30s turns against the compass by its %.20s \"%.40s\": "
                "convert it, as by ncap2 -s '%.30s=270-%.30s' IN OUT where it "
                "goes to, and delete the %.20s",
                name, texts[i], text, name, name, texts[i]);
        }
        if (has_one_of(text, to, sizeof to / sizeof *to) || goes_to(text)) {
            return pel_fault_set(
                fault, PEL_ERR_INVALID,
                "%.30s has no standard_name, and its %.20s \"%.50s\" may mean "
                "to or from: ncatted -a standard_name,%.30s,c,c,%s FILE",
                name, texts[i], text, name,
                kind->height == PEL_FORECAST_AT_10_M ? "wind_to_direction"
                : kind->number == PEL_WEATHER_SWELL_DIRECTION
                    ? "sea_surface_swell_wave_to_direction"
                    : "sea_surface_wave_to_direction");
        }
    }
    return PEL_OK;
}
