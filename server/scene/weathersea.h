/* Which sea a weather field's numbers mean: a wind sea by the wind, as high as
 * the waves' energy allows and the wind can have raised, and the rest as swell.
 * Continuous in all numbers (docs/physics/waves.md has the equations). Any
 * thread. */
#pragma once

#include "ocean/growth.h"
#include "weather/weather.h"

/* Fields of the schema's Sea that follow the weather. */
struct pel_weather_sea {
    double wind_mps;      /* 0..30 */
    double wind_from_deg; /* 0..360, in the scene's frame */
    /* All below only where the field has waves. */
    double fetch_m;
    double swell_height_m, swell_period_s, swell_from_deg, swell_spread_deg;
};

/* turn_rad: local heading less true heading there (scene/geodesy.h), 0 at the
 * scene's origin. */
void pel_weather_sea_of(const struct pel_weather_now *now,
                        const struct pel_growth_law *law, double turn_rad,
                        struct pel_weather_sea *out);

/* Root mean square of how far the surface moves when the one sea becomes the
 * other, its modes' phases kept, m; without waves in the field 0. An estimate,
 * within a factor of three. */
double pel_weather_sea_moves(const struct pel_weather_sea *from,
                             const struct pel_weather_sea *to,
                             const struct pel_growth_law *law);
