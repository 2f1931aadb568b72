#include "scene/weathersea.h"

#include <math.h>

#include "base/vec.h"

#define MOST_WIND 30.0 /* the schema's limits */
#define MOST_SWELL 15.0
#define LEAST_PERIOD 3.0
#define MOST_PERIOD 30.0
#define LEAST_SPREAD 1.0
#define MOST_SPREAD 60.0

/* Whatever else runs there, the wind has raised a sea over so much at least. */
#define YOUNG_FETCH_M 2e4
/* The peak's period over that of a wind sea of the whole height: up to the
 * first it is one, from the second on it is swell. */
#define WIND_SEA_UP_TO 1.2
#define SWELL_FROM 1.8
/* Angle between wind and waves, likewise. */
#define ALONG 40.0
#define ACROSS 90.0
#define SWELL_SPREAD_DEG 15.0

static double smooth(double from, double to, double at)
{
    double x = pel_clamp((at - from) / (to - from), 0, 1);
    return x * x * (3 - 2 * x);
}

/* Compass direction that something comes from which goes to `to_rad`. */
static double from_deg(double to_rad)
{
    double d = fmod(270 - to_rad / PEL_DEG, 360);
    return d < 0 ? d + 360 : d;
}

/* The lesser of two heights, with a corner that is round, since what is left of
 * the energy is a swell's, whose height would begin as a root does. */
static double lesser(double a, double b)
{
    const double p = 16;
    double low = fmin(a, b), ratio = low / fmax(fmax(a, b), 1e-9);
    return low * pow(1 + pow(ratio, p), -1 / p);
}

/* Height of the wind sea in waves whose parts the file does not tell apart. */
static double wind_sea(const struct pel_weather_now *now,
                       const struct pel_growth_law *law, double wind_mps,
                       double wind_to_rad)
{
    double height = now->height_m;
    double most = lesser(
        height, pel_growth_height(law, wind_mps, PEL_GROWTH_MOST_FETCH_M));
    double young =
        lesser(height, pel_growth_height(law, wind_mps, YOUNG_FETCH_M));
    double period =
        pel_growth_peak(law, wind_mps, pel_growth_fetch(law, wind_mps, most));
    double apart =
        fabs(remainder(now->direction_rad - wind_to_rad, 2 * PEL_PI)) / PEL_DEG;
    double ratio = period > 0 ? now->period_s / period : SWELL_FROM;
    double share = (1 - smooth(WIND_SEA_UP_TO, SWELL_FROM, ratio)) *
                   (1 - smooth(ALONG, ACROSS, apart));
    most = fmax(most, young);
    return sqrt(young * young + share * (most * most - young * young));
}

void pel_weather_sea_of(const struct pel_weather_now *now,
                        const struct pel_growth_law *law, double turn_rad,
                        struct pel_weather_sea *out)
{
    double wind = hypot(now->wind_east_mps, now->wind_north_mps);
    double wind_to = atan2(now->wind_north_mps, now->wind_east_mps);
    *out = (struct pel_weather_sea){
        .wind_mps = fmin(wind, MOST_WIND),
        /* Clockwise is less of a mathematical angle. */
        .wind_from_deg = from_deg(wind_to - turn_rad),
    };
    if (now->height_m < 0) {
        return;
    }
    double height = now->height_m;
    double sea = now->parts ? fmin(now->wind_height_m, height)
                            : wind_sea(now, law, out->wind_mps, wind_to);
    out->fetch_m = pel_growth_fetch(law, out->wind_mps, sea);
    sea = fmin(pel_growth_height(law, out->wind_mps, out->fetch_m), height);
    double direction =
        now->parts ? now->swell_direction_rad : now->direction_rad;
    double agreement =
        pel_clamp(now->parts ? now->swell_agreement : now->agreement, 1e-6, 1);
    double scatter = sqrt(-2 * log(agreement)) / PEL_DEG;
    out->swell_height_m = fmin(sqrt(height * height - sea * sea), MOST_SWELL);
    out->swell_period_s =
        pel_clamp(now->parts ? now->swell_period_s : now->period_s,
                  LEAST_PERIOD, MOST_PERIOD);
    out->swell_from_deg = from_deg(direction - turn_rad);
    out->swell_spread_deg =
        pel_clamp(hypot(SWELL_SPREAD_DEG, scatter), LEAST_SPREAD, MOST_SPREAD);
}

static double turned(double a_deg, double b_deg)
{
    return remainder(a_deg - b_deg, 360) * PEL_DEG;
}

double pel_weather_sea_moves(const struct pel_weather_sea *from,
                             const struct pel_weather_sea *to,
                             const struct pel_growth_law *law)
{
    /* Changes of a spectrum's logarithm, root mean square over its energy: by a
     * peak of 10 % in frequency, and of 6 % of a swell; by directions spread as
     * cos^{2s} with s about 10, and by the swell's own spread. Amplitudes
     * change by half of that. */
    const double by_peak = 5, by_swell = 1 / 0.06, by_direction = 2.2;
    if (!(to->fetch_m > 0)) {
        return 0;
    }
    double h[2] = { pel_growth_height(law, from->wind_mps, from->fetch_m),
                    pel_growth_height(law, to->wind_mps, to->fetch_m) };
    double t[2] = { pel_growth_peak(law, from->wind_mps, from->fetch_m),
                    pel_growth_peak(law, to->wind_mps, to->fetch_m) };
    double sea = fmax(h[0], h[1]) / 4;
    double swell = fmax(from->swell_height_m, to->swell_height_m) / 4;
    double spread =
        fmin(from->swell_spread_deg, to->swell_spread_deg) * PEL_DEG;
    double longer = t[0] > 0 && t[1] > 0 ? log(t[1] / t[0]) : 0;
    const double parts[] = {
        (h[1] - h[0]) / 4,
        0.5 * sea * by_peak * longer,
        0.5 * sea * by_direction *
            turned(to->wind_from_deg, from->wind_from_deg),
        (to->swell_height_m - from->swell_height_m) / 4,
        0.5 * swell * by_swell * log(to->swell_period_s / from->swell_period_s),
        0.5 * swell * turned(to->swell_from_deg, from->swell_from_deg) / spread,
        0.5 * swell * log(to->swell_spread_deg / from->swell_spread_deg),
    };
    double sum = 0;
    for (size_t i = 0; i < sizeof parts / sizeof *parts; i++) {
        sum += parts[i] * parts[i];
    }
    return sqrt(sum);
}
