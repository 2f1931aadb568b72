/* Straight lines through the air on a sphere: heights above the ground and
 * distances in metres, mu the cosine of a direction's zenith angle where the
 * line begins. Written so that no large numbers cancel. Any thread. */
#pragma once

#include <math.h>

#include "optics/atmosphere.h"

#define PEL_AIR_TOP (PEL_ATMOSPHERE_RADIUS - PEL_EARTH_RADIUS)

/* Height at distance t along a line from height h, ≥ 0. */
static inline double pel_height_along(double h, double mu, double t)
{
    double r = PEL_EARTH_RADIUS + h;
    double rise = t * (t + 2.0 * r * mu); /* r_t² − r² */
    return fmax(h + rise / (sqrt(fmax(r * r + rise, 0)) + r), 0);
}

static inline double pel_distance_to_top(double h, double mu)
{
    double r = PEL_EARTH_RADIUS + h;
    double c = (PEL_AIR_TOP - h) * (PEL_ATMOSPHERE_RADIUS + r);
    return -r * mu + sqrt(fmax(r * r * mu * mu + c, 0));
}

/* Negative where the line does not meet the ground. */
static inline double pel_distance_to_ground(double h, double mu)
{
    double r = PEL_EARTH_RADIUS + h;
    double c = h * (PEL_EARTH_RADIUS + r);
    double disc = r * r * mu * mu - c;
    if (mu >= 0 || disc < 0) {
        return -1;
    }
    return c / (-r * mu + sqrt(disc));
}

static inline double pel_horizon_cosine(double h)
{
    return -sqrt(h * (2.0 * PEL_EARTH_RADIUS + h)) / (PEL_EARTH_RADIUS + h);
}

/* Mean of exp(−h / scale) over heights. */
static inline double pel_mean_density(double from, double to, double scale)
{
    double x = (to - from) / scale;
    return exp(-from / scale) * (fabs(x) > 1e-6 ? -expm1(-x) / x : 1.0);
}

/* Where in a step between two heights its scatterers lie on the mean, 0..1: by
 * a single exponential as steep as theirs. */
static inline double pel_air_step_middle(const struct pel_atmosphere *a,
                                         double from, double to)
{
    double h = 0.5 * (from + to);
    double r = a->rayleigh.g * exp(-h / a->rayleigh_height_m);
    double m = a->mie_extinction * exp(-h / a->mie_height_m);
    double x = (to - from) * (r / a->rayleigh_height_m + m / a->mie_height_m) /
               (r + m);
    return fabs(x) > 1e-3 ? -log(-expm1(-x) / x) / x : 0.5;
}

/* Steps of a ray of `way` metres from height h end at way · (k / steps)^power:
 * the first no thicker than a fifth of an optical depth. */
static inline double pel_air_step_power(const struct pel_atmosphere *a,
                                        double h, double way, int steps)
{
    double thick = a->rayleigh.g * exp(-h / a->rayleigh_height_m) +
                   a->mie_extinction * exp(-h / a->mie_height_m);
    return fmax(3, log(fmax(way * thick * 5.0, 1)) / log(steps));
}
