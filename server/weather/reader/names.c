/* What weather services call the numbers that are read. */
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>
#include <time.h>

#include "weather/reader/forecast.h"

/* Of a JONSWAP spectrum the peak's period is 1.11, of Pierson and Moskowitz's
 * 1.17 times the energy period (m−1/m0) that the ECMWF's mean periods are. */
#define PEAK_OVER_ENERGY_PERIOD 1.1

enum from { AS_IS, COMES_FROM, GOES_TO };

static const struct row {
    enum pel_weather_number number;
    int rank;
    enum from from; /* of directions, in compass degrees */
    double factor;
    int parameter[3];      /* GRIB2: discipline, category, number */
    const char *names;     /* of variables, between spaces */
    const char *standards; /* CF's, likewise */
} rows[] = {
    { PEL_WEATHER_WIND_EAST,
      0,
      AS_IS,
      1,
      { 0, 2, 2 },
      " u10 10u ugrd uwnd u10m ugrd_10maboveground ",
      " eastward_wind " },
    { PEL_WEATHER_WIND_NORTH,
      0,
      AS_IS,
      1,
      { 0, 2, 3 },
      " v10 10v vgrd vwnd v10m vgrd_10maboveground ",
      " northward_wind " },
    { PEL_WEATHER_HEIGHT,
      0,
      AS_IS,
      1,
      { 10, 0, 3 },
      " swh hs htsgw vhm0 htsgw_surface ",
      " sea_surface_wave_significant_height " },
    { PEL_WEATHER_PERIOD,
      0,
      AS_IS,
      1,
      { 10, 0, 34 },
      " pp1d tp vtpk pwper ",
      " sea_surface_wave_period_at_variance_spectral_density_maximum " },
    { PEL_WEATHER_PERIOD,
      1,
      AS_IS,
      1,
      { 10, 0, 11 },
      " perpw perpw_surface ",
      "" },
    { PEL_WEATHER_PERIOD,
      2,
      AS_IS,
      PEAK_OVER_ENERGY_PERIOD,
      { 10, 0, 15 },
      " mwp mwsper vtm10 ",
      " sea_surface_wave_mean_period_from_variance_spectral_density_inverse_"
      "frequency_moment " },
    { PEL_WEATHER_DIRECTION,
      0,
      COMES_FROM,
      1,
      { 10, 0, 14 },
      " mwd wwsdir vmdr ",
      " sea_surface_wave_from_direction " },
    { PEL_WEATHER_DIRECTION,
      1,
      COMES_FROM,
      1,
      { 10, 0, 10 },
      " dirpw dirpw_surface ",
      "" },
    { PEL_WEATHER_DIRECTION,
      2,
      GOES_TO,
      1,
      { -1, 0, 0 },
      "",
      " sea_surface_wave_to_direction " },
    { PEL_WEATHER_WIND_HEIGHT,
      0,
      AS_IS,
      1,
      { 10, 0, 5 },
      " shww wvhgt vhm0_ww wvhgt_surface ",
      " sea_surface_wind_wave_significant_height " },
    { PEL_WEATHER_SWELL_PERIOD,
      0,
      AS_IS,
      1,
      { 10, 0, 36 },
      " pperts ",
      " sea_surface_swell_wave_period_at_variance_spectral_density_maximum " },
    { PEL_WEATHER_SWELL_PERIOD,
      1,
      AS_IS,
      1,
      { 10, 0, 9 },
      " mpts mpps swper vtm01_sw1 swper_1insequence ",
      " sea_surface_swell_wave_period sea_surface_primary_swell_wave_mean_"
      "period " },
    { PEL_WEATHER_SWELL_PERIOD, 2, AS_IS, 1, { 192, 140, 239 }, "", "" },
    { PEL_WEATHER_SWELL_DIRECTION,
      0,
      COMES_FROM,
      1,
      { 10, 0, 7 },
      " mdts mdps swdir vmdr_sw1 swdir_1insequence ",
      " sea_surface_swell_wave_from_direction sea_surface_primary_swell_wave_"
      "from_direction " },
    { PEL_WEATHER_SWELL_DIRECTION,
      1,
      COMES_FROM,
      1,
      { 192, 140, 238 },
      "",
      "" },
};

static bool among(const char *list, const char *word)
{
    size_t length = word ? strlen(word) : 0;
    for (const char *at = list; length > 0 && *at; at++) {
        if (*at == ' ' && strncasecmp(at + 1, word, length) == 0 &&
            at[1 + length] == ' ') {
            return true;
        }
    }
    return false;
}

/* Whether it is of the surface, or 10 m above it. */
static bool at_surface(const char *level)
{
    static const char *const others[] = { "ISBL", "SIGL", "HYBL", "GPML",
                                          "PVL",  "TRO",  "MWSL" };
    if (!level) {
        return true;
    }
    const char *dash = strchr(level, '-');
    for (size_t i = 0; dash && i < sizeof others / sizeof *others; i++) {
        if (strcmp(dash + 1, others[i]) == 0) {
            return false;
        }
    }
    return !dash || strcmp(dash + 1, "HTGL") != 0 ||
           strncmp(level, "10-", 3) == 0;
}

bool pel_forecast_kind_of(const struct pel_forecast_name *name,
                          struct pel_forecast_kind *out)
{
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        const struct row *r = &rows[i];
        bool numbered = name->parameter[0] >= 0;
        bool same = numbered ? memcmp(name->parameter, r->parameter,
                                      sizeof r->parameter) == 0
                             : among(r->names, name->element) ||
                                   among(r->standards, name->standard);
        if (same && at_surface(name->level)) {
            *out =
                (struct pel_forecast_kind){ r->number, r->rank, r->factor, 0 };
            if (r->from != AS_IS) {
                /* From the compass to the angle from east, counterclockwise. */
                out->factor = -1;
                out->offset = r->from == COMES_FROM ? 270 : 90;
            }
            return true;
        }
    }
    return false;
}

bool pel_forecast_time(const char *units, double value, double *unix_s)
{
    static const struct {
        const char *name;
        double seconds;
    } steps[] = { { "second", 1 },  { "sec", 1 },  { "s", 1 },
                  { "minute", 60 }, { "min", 60 }, { "hour", 3600 },
                  { "hr", 3600 },   { "h", 3600 }, { "day", 86400 },
                  { "d", 86400 } };
    char unit[16] = "", zone[8] = "";
    int year, month, day, hour = 0, minute = 0;
    double second = 0;
    int read = sscanf(units, "%15[a-z] since %d-%d-%d%*1[ T]%d:%d:%lf %7s",
                      unit, &year, &month, &day, &hour, &minute, &second, zone);
    size_t length = strlen(unit);
    if (read < 4 || year < 0 || year > 9999 || month < 1 || month > 12 ||
        day < 1 || day > 31 || hour < 0 || hour > 24 || minute < 0 ||
        minute > 60 ||
        (*zone && strcmp(zone, "Z") != 0 && strcmp(zone, "UTC") != 0 &&
         strcmp(zone, "+00:00") != 0 && strcmp(zone, "0:00") != 0)) {
        return false;
    }
    if (length > 1 && unit[length - 1] == 's') {
        unit[length - 1] = '\0';
    }
    struct tm at = { .tm_year = year - 1900,
                     .tm_mon = month - 1,
                     .tm_mday = day,
                     .tm_hour = hour,
                     .tm_min = minute };
    for (size_t i = 0; i < sizeof steps / sizeof *steps; i++) {
        if (strcmp(unit, steps[i].name) == 0) {
            *unix_s = (double)timegm(&at) + second + value * steps[i].seconds;
            return fabs(*unix_s) < PEL_FORECAST_MOST_UNIX_S;
        }
    }
    return false;
}
