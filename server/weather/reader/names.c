/* What weather services call the numbers that are read. */
#include <stdio.h>
#include <string.h>
#include <strings.h>

#include "weather/reader/forecast.h"

/* Of a JONSWAP spectrum the peak's period is 1.11, of Pierson and Moskowitz's
 * 1.17 times the energy period (m−1/m0) that the ECMWF's mean periods are. */
#define PEAK_OVER_ENERGY_PERIOD 1.1
#define MEAN_REMARK                                                            \
    "there is no peak period: 1.1 times the mean period (m-1/m0) is taken"

enum from { AS_IS, COMES_FROM, GOES_TO };

#define MPS PEL_CF_MPS
#define METRES PEL_CF_M
#define SECONDS PEL_CF_S
#define DEGREES PEL_CF_DEG
#define WIND PEL_FORECAST_AT_10_M
#define SEA PEL_FORECAST_AT_SEA
#define SWELL PEL_FORECAST_IN_SEQUENCE

static const struct row {
    int number, rank;
    enum pel_cf_quantity quantity;
    enum pel_forecast_height height;
    enum from from; /* of directions, in compass degrees */
    double factor;
    long parameter[3];     /* GRIB2: discipline, category, number */
    const char *ids;       /* ecCodes' paramId, which GRIB1 is named by */
    const char *names;     /* of variables, between spaces */
    const char *standards; /* CF's, likewise */
    const char *remark;
} rows[] = {
    { PEL_WEATHER_WIND_EAST,
      0,
      MPS,
      WIND,
      AS_IS,
      1,
      { 0, 2, 2 },
      " 165 131 ",
      " u10 10u u10m ugrd uwnd uas ugrd_10maboveground ugrd_surface ",
      " eastward_wind ",
      NULL },
    { PEL_WEATHER_WIND_NORTH,
      0,
      MPS,
      WIND,
      AS_IS,
      1,
      { 0, 2, 3 },
      " 166 132 ",
      " v10 10v v10m vgrd vwnd vas vgrd_10maboveground vgrd_surface ",
      " northward_wind ",
      NULL },
    { PEL_FORECAST_SPEED,
      0,
      MPS,
      WIND,
      AS_IS,
      1,
      { 0, 2, 1 },
      " 207 10 ",
      " si10 10si ws wspd wind_speed ff10 wind_10maboveground wind_surface "
      "wsmod ",
      " wind_speed ",
      NULL },
    { PEL_FORECAST_WIND_WAY,
      0,
      DEGREES,
      WIND,
      COMES_FROM,
      1,
      { 0, 2, 0 },
      " 260260 3031 ",
      " wdir10 10wdir wdir wind_direction wind_from_direction dd10 "
      "wdir_10maboveground wdir_surface ",
      " wind_from_direction ",
      NULL },
    { PEL_FORECAST_WIND_WAY,
      0,
      DEGREES,
      WIND,
      GOES_TO,
      1,
      { -1, 0, 0 },
      "",
      "",
      " wind_to_direction ",
      NULL },
    { PEL_WEATHER_HEIGHT,
      0,
      METRES,
      SEA,
      AS_IS,
      1,
      { 10, 0, 3 },
      " 140229 3100 ",
      " swh hs htsgw vhm0 htsgw_surface ",
      " sea_surface_wave_significant_height ",
      NULL },
    { PEL_WEATHER_PERIOD,
      0,
      SECONDS,
      SEA,
      AS_IS,
      1,
      { 10, 0, 34 },
      " 140231 ",
      " pp1d tp vtpk pwper ",
      " sea_surface_wave_period_at_variance_spectral_density_maximum ",
      NULL },
    { PEL_WEATHER_PERIOD,
      0,
      PEL_CF_HZ,
      SEA,
      AS_IS,
      1,
      { -1, 0, 0 },
      "",
      " fp ",
      " sea_surface_wave_frequency_at_variance_spectral_density_maximum "
      "dominant_wave_frequency sea_surface_wave_peak_frequency ",
      NULL },
    { PEL_WEATHER_PERIOD,
      1,
      SECONDS,
      SEA,
      AS_IS,
      1,
      { 10, 0, 11 },
      " 260234 3108 ",
      " perpw mpps perpw_surface ",
      "",
      NULL },
    { PEL_WEATHER_PERIOD,
      2,
      SECONDS,
      SEA,
      AS_IS,
      PEAK_OVER_ENERGY_PERIOD,
      { 10, 0, 15 },
      " 140232 ",
      " mwp mwsper vtm10 t0m1 ",
      " sea_surface_wave_mean_period_from_variance_spectral_density_inverse_"
      "frequency_moment ",
      MEAN_REMARK },
    { PEL_WEATHER_DIRECTION,
      0,
      DEGREES,
      SEA,
      COMES_FROM,
      1,
      { 10, 0, 14 },
      " 140230 ",
      " mwd wwsdir vmdr ",
      " sea_surface_wave_from_direction ",
      NULL },
    { PEL_WEATHER_DIRECTION,
      0,
      DEGREES,
      SEA,
      GOES_TO,
      1,
      { -1, 0, 0 },
      "",
      "",
      " sea_surface_wave_to_direction ",
      NULL },
    { PEL_WEATHER_DIRECTION,
      1,
      DEGREES,
      SEA,
      COMES_FROM,
      1,
      { 10, 0, 10 },
      " 260233 3107 ",
      " dirpw mdps vped dirpw_surface ",
      " sea_surface_wave_from_direction_at_variance_spectral_density_maximum ",
      NULL },
    { PEL_WEATHER_DIRECTION,
      1,
      DEGREES,
      SEA,
      GOES_TO,
      1,
      { -1, 0, 0 },
      "",
      "",
      " sea_surface_wave_to_direction_at_variance_spectral_density_maximum ",
      NULL },
    { PEL_WEATHER_WIND_HEIGHT,
      0,
      METRES,
      SEA,
      AS_IS,
      1,
      { 10, 0, 5 },
      " 140234 3102 ",
      " shww wvhgt vhm0_ww wvhgt_surface ",
      " sea_surface_wind_wave_significant_height ",
      NULL },
    { PEL_WEATHER_SWELL_PERIOD,
      0,
      SECONDS,
      SEA,
      AS_IS,
      1,
      { 10, 0, 36 },
      "",
      " pperts ",
      " sea_surface_swell_wave_period_at_variance_spectral_density_maximum ",
      NULL },
    { PEL_WEATHER_SWELL_PERIOD,
      1,
      SECONDS,
      SWELL,
      AS_IS,
      1,
      { 10, 0, 9 },
      " 3106 ",
      " mpts swper vtm01_sw1 swper_1insequence ",
      " sea_surface_swell_wave_period sea_surface_swell_wave_mean_period "
      "sea_surface_primary_swell_wave_mean_period ",
      NULL },
    { PEL_WEATHER_SWELL_PERIOD,
      1,
      SECONDS,
      SEA,
      AS_IS,
      1,
      { 192, 140, 239 },
      " 140239 ",
      "",
      "",
      NULL },
    { PEL_WEATHER_SWELL_DIRECTION,
      0,
      DEGREES,
      SWELL,
      COMES_FROM,
      1,
      { 10, 0, 7 },
      " 3104 ",
      " mdts swdir vmdr_sw1 swdir_1insequence ",
      " sea_surface_swell_wave_from_direction sea_surface_primary_swell_wave_"
      "from_direction ",
      NULL },
    { PEL_WEATHER_SWELL_DIRECTION,
      0,
      DEGREES,
      SEA,
      COMES_FROM,
      1,
      { 192, 140, 238 },
      " 140238 ",
      "",
      "",
      NULL },
    { PEL_WEATHER_SWELL_DIRECTION,
      0,
      DEGREES,
      SWELL,
      GOES_TO,
      1,
      { -1, 0, 0 },
      "",
      "",
      " sea_surface_swell_wave_to_direction sea_surface_primary_swell_wave_to_"
      "direction ",
      NULL },
};

const char *pel_forecast_name_of(int number)
{
    static const char *const names[] = {
        [PEL_WEATHER_WIND_EAST] = "wind to the east (UGRD, u10)",
        [PEL_WEATHER_WIND_NORTH] = "wind to the north (VGRD, v10)",
        [PEL_WEATHER_HEIGHT] = "significant wave height (HTSGW, swh)",
        [PEL_WEATHER_PERIOD] = "peak period (PWPER, PERPW, pp1d, mwp)",
        [PEL_WEATHER_DIRECTION] = "wave direction (WWSDIR, DIRPW, mwd)",
        [PEL_WEATHER_WIND_HEIGHT] = "height of the wind sea (WVHGT, shww)",
        [PEL_WEATHER_SWELL_PERIOD] = "period of the swell (SWPER, mpts)",
        [PEL_WEATHER_SWELL_DIRECTION] = "direction of the swell (SWDIR, mdts)",
        [PEL_FORECAST_SPEED] = "speed of the wind (WIND, si10)",
        [PEL_FORECAST_WIND_WAY] = "direction of the wind (WDIR, wdir10)",
    };
    return names[number];
}

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

static bool is_named(const struct row *r, const struct pel_forecast_name *name)
{
    char id[24];
    if (name->parameter[0] >= 0 &&
        memcmp(name->parameter, r->parameter, sizeof r->parameter) == 0) {
        return true;
    }
    snprintf(id, sizeof id, "%ld", name->id);
    return among(r->ids, name->id > 0 ? id : NULL) ||
           among(r->standards, name->standard) ||
           (!name->standard && among(r->names, name->variable));
}

bool pel_forecast_kind_of(const struct pel_forecast_name *name,
                          struct pel_forecast_kind *out)
{
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        const struct row *r = &rows[i];
        if (!is_named(r, name)) {
            continue;
        }
        *out = (struct pel_forecast_kind){ .number = r->number,
                                           .rank = r->rank,
                                           .quantity = r->quantity,
                                           .height = r->height,
                                           .factor = r->factor,
                                           .remark = r->remark };
        if (r->from != AS_IS) {
            /* From the compass to the angle from east, counterclockwise. */
            out->factor = -1;
            out->offset = r->from == COMES_FROM ? 270 : 90;
        }
        return true;
    }
    return false;
}
