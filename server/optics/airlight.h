/* Light that the air scatters for the second time and more: the source that
 * the last scattering before an eye draws on, at every height, for every
 * height of a light and in every direction. Successive orders of scattering on
 * the sphere, with the phase functions of molecules and aerosols and a sea
 * below that mirrors; of the air alone, so one table serves every light, eye
 * and moment. Any thread once built. */
#pragma once

#include "base/err.h"
#include "optics/atmosphere.h"
#include "shaders/lib/blocks.h"

/* The radiance to which scattering turns the light that reaches a place, per
 * unit irradiance of a light above the air [1/sr], as log2: times the
 * scattering coefficients of molecules and aerosols together it is the source.
 * Light that comes straight from the light source and is scattered once is not
 * in it. By the light's zenith cosine (pel_airlight_sun), the height
 * (pel_airlight_height) and the zenith angle of the line of sight in equal
 * steps from 0 to π, and by the sine of half its azimuth from the light; the
 * last is padding. As the shaders' texture has it. 7.6 MB. */
struct pel_airlight {
    float log2[PEL_AIR_SUNS][PEL_AIR_HEIGHTS][PEL_AIR_ZENITHS][PEL_AIR_AZIMUTHS]
              [4];
};

/* From the constants and the columns of an atmosphere; 0.35 to 0.9 s of one
 * core, the same bits however it is shared. `share` NULL: by the calling
 * thread. NO_MEMORY. */
PEL_CHECK enum pel_err pel_airlight_build(const struct pel_atmosphere *a,
                                          pel_airlight_share *share, void *pool,
                                          struct pel_airlight *out);

/* Places in the table, 0..1. */
double pel_airlight_sun(double sun_mu);
double pel_airlight_height(const struct pel_atmosphere *a, double height_m);

/* The table at a height for a line of sight of zenith angle zenith_rad and
 * cosine of azimuth from the light cos_azimuth, linear in its logarithm. */
struct pel_rgb pel_airlight_at(const struct pel_airlight *l,
                               const struct pel_atmosphere *a, double height_m,
                               double sun_mu, double zenith_rad,
                               double cos_azimuth);
