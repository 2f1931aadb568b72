/* Heat that sea, sky and air send out, 8 to 12 µm: what a thermal camera sees
 * (docs/physics/sensors.md). Any thread; nothing allocates. */
#pragma once

#include "base/vec.h"

#define PEL_KELVIN 273.15

/* Radiance of a black body between 8 and 12 µm [W m⁻² sr⁻¹] at 150 to 1500 K
 * (Planck; by Simpson's rule, to 1e-6). */
double pel_thermal_radiance(double kelvin);

/* Its inverse: the apparent temperature [K] of a radiance > 0. */
double pel_thermal_temperature(double radiance);

/* Emissivity of level water, 1 less Fresnel's reflectance of both
 * polarisations, by the cosine of the angle of incidence, 0..1: the mean over
 * the band as black bodies of 288 K fill it; complex index of Hale and Querry
 * (1973). */
double pel_thermal_emissivity(double cosine);

/* The same of water of Gaussian slopes of this variance along each axis, ≥ 0,
 * seen at this cosine from its mean normal: the mean over the facets that face
 * the eye by the area they show (Masuda et al. 1988, without what facets send
 * each other); and the mean cosine, from the same normal, of what they mirror,
 * by how much each reflects. */
struct pel_thermal_rough {
    double emissivity, mirrored;
};
#define PEL_THERMAL_LEVELS 513
/* `level`: emissivities of level water by equal steps of the cosine, from 0. */
struct pel_thermal_rough
pel_thermal_rough(double cosine, double variance,
                  const double level[PEL_THERMAL_LEVELS]);
void pel_thermal_level(double out[PEL_THERMAL_LEVELS]);

/* Air near the sea and the sky above it. */
struct pel_thermal_air {
    double kelvin;
    double extinction; /* 1/m */
    double zenith;     /* emissivity of the sky there, 0..1 */
};

/* humidity: relative, 0..1; cloud: share of the clear sky's coldness that
 * clouds take, 0..1. Extinction: the water vapour's own continuum (Roberts et
 * al. 1976) at 10 µm, 0.03/km for lines, and of the aerosol's at 550 nm, from
 * the visibility, 12 % where one sees 10 km or more, all of it in fog of 500 m
 * (a fit by eye between Shettle and Fenn's maritime haze and fog). Zenith: Idso
 * 1981, eq. 17, for 8 to 14 µm. */
struct pel_thermal_air pel_thermal_air(double kelvin, double humidity,
                                       double visibility_m, double cloud);

/* Masses of air above in a direction of this sine of elevation (Kasten and
 * Young 1989), at most 38; below the horizon as there. */
double pel_thermal_masses(double sine);

/* Radiance of the sky there: of air of one temperature. */
double pel_thermal_sky(const struct pel_thermal_air *air, double sine);

/* Temperature that the Sun's light adds to a matt painted wall in wind, K:
 * `sine` of its elevation, `facing` the cosine of its incidence. Absorbs 0.6
 * of the beam (Meinel and Meinel 1976), and loses 5.7 + 3.8 wind W/m²/K
 * (McAdams 1954). */
double pel_thermal_sunned(double sine, double facing, double wind_mps);
