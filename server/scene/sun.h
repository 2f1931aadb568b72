/* Where the Sun is. Pure functions, any thread. Source: J. Meeus, Astronomical
 * Algorithms, 2nd ed., chapters 12, 13 and 25 (low accuracy, 0.01°). */
#pragma once

#include "base/err.h"

/* Seconds since 1970 UTC of an ISO 8601 text with its zone
 * (`2026-06-21T12:00:00Z`), years 1900 to 2100. INVALID, OUT_OF_RANGE. */
PEL_CHECK enum pel_err pel_utc_parse(const char *text, double *unix_s);

/* Azimuth (clockwise from true north) and elevation of the Sun's centre,
 * radians, without refraction, for a place on the ellipsoid, radians. */
void pel_sun_position(double unix_s, double latitude_rad, double longitude_rad,
                      double *azimuth_rad, double *elevation_rad);
