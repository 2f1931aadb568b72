/* Where Moon, planets and stars are. Thread-safe; what is computed depends on
 * the arguments alone. Positions of Moon and planets by scene/orbit.h,
 * precession by Lieske 1979; without nutation (0.005 deg, of which only its
 * part in obliquity, 0.0026 deg, turns the sky), aberration of stars (0.006
 * deg) and refraction. */
#pragma once

#include "base/vec.h"
#include "optics/nightsky.h"

/* Terrestrial less universal time [s], within 3 s from 1900 to 2026. */
double pel_ephemeris_delta_t(double unix_s);

/* Columns: where the axes of the mean equator and equinox of J2000 point in the
 * local frame (east, north, up) of a place, radians. */
struct pel_mat3 pel_ephemeris_sky(double unix_s, double latitude_rad,
                                  double longitude_rad);

/* The Moon seen from the surface of the ellipsoid: its parallax there is up to
 * a degree. */
struct pel_moon_place {
    struct pel_vec3 direction; /* unit, east, north, up */
    double distance_m;
    double lit; /* share of the disc */
};
void pel_ephemeris_moon(double unix_s, double latitude_rad,
                        double longitude_rad, struct pel_moon_place *out);

/* The sky of a night at a place, but for `stars` and whether it is on: the
 * planets by libnova, their magnitudes by the Astronomical Almanac's formulas
 * of 1984 (Meeus 1998, chapter 41), Saturn's with its rings. */
void pel_ephemeris_night(double unix_s, double latitude_rad,
                         double longitude_rad, struct pel_night_sky *out);
