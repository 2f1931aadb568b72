/* The light of the night sky that is no star: airglow, zodiacal light, and that
 * of the stars too faint for the catalogue, with what is between them. Any
 * thread. Radiances W m⁻² sr⁻¹ nm⁻¹ at 680, 550, 440 nm. "S10" is one star of
 * magnitude 10 in V a square degree, 27.78 magnitudes an arcsecond². */
#pragma once

#include <stdbool.h>

#include "optics/atmosphere.h"

#define PEL_S10 1.1917e-11 /* W m⁻² sr⁻¹ nm⁻¹ at 550 nm */

#define PEL_PLANETS 4 /* Venus, Mars, Jupiter, Saturn */
struct pel_planet {
    struct pel_vec3 to; /* unit, equator and equinox of J2000 */
    double magnitude;   /* V */
};

/* The sky of a moment; zero: none. */
struct pel_night_sky {
    bool on;
    /* Columns: where the axes of J2000's equator point, east, north, up: at
     * this moment, and at the beginning of its minute, by which what has no
     * outlines is drawn. */
    struct pel_mat3 local, local_minute;
    double sun_longitude_rad; /* ecliptic of J2000 */
    double years;             /* since J2000 */
    double stars; /* share of their light that is shown: 0 until the Sun is 1°
                     under the horizon, 1 from 5° on */
    struct pel_planet planets[PEL_PLANETS];
};

/* Zodiacal light [S10] at an ecliptic latitude and a longitude from the Sun,
 * radians: Leinert et al. 1998, table 16, between its places. */
double pel_night_zodiacal(double longitude, double latitude);

/* Stars fainter than 6.5 and the light that dust scatters [S10] at a galactic
 * longitude and latitude, radians: 24 / √(sin² b + 0.008), more towards the
 * middle: a plain form of what Leinert et al. 1998, section 10, show, 24 at the
 * poles, a mean of 270 on the plane, good to a third where the Milky Way has
 * structure. */
double pel_night_starlight(double longitude, double latitude);

/* Both above the air, in a local direction. */
struct pel_rgb pel_night_above(const struct pel_night_sky *night,
                               const struct pel_mat3 *local,
                               struct pel_vec3 dir);

/* Airglow by zenith cosine without the air below it: a thin layer 90 km high
 * (van Rhijn 1921), PEL_AIRGLOW_S10 at the zenith, which makes a moonless
 * zenith 22 magnitudes an arcsecond² away from Milky Way and ecliptic. */
#define PEL_AIRGLOW_S10 80.0
struct pel_rgb pel_night_airglow(double mu);

/* Rows of elevation, π/2 times the square of their place; texels a side of the
 * map, on which a direction lies at ½ + ½ (x, y) / √(1 + z) (Lambert's equal
 * areas, the horizon around it). */
#define PEL_NIGHT_ROWS PEL_NIGHT_MAP_ROWS
#define PEL_NIGHT_SIDE 96

struct pel_night_map {
    float zonal[PEL_NIGHT_ROWS][4];               /* mean around the horizon */
    float off[PEL_NIGHT_SIDE][PEL_NIGHT_SIDE][4]; /* what is more there */
    struct pel_rgb air; /* that a long way through the air tends to */
};

/* Of the map, in a direction (unit, east, north, up): all of it, or what is
 * more than its mean around the horizon there; below the horizon none. */
struct pel_rgb pel_night_seen(const struct pel_night_map *map,
                              struct pel_vec3 dir, bool off);

/* What is seen from sea level through air of this visibility: above it times
 * its transmittance, and for the rest what the air scatters, whose source is
 * the mean of what comes from all sides, its own light too. Some 10 ms. */
void pel_night_map_make(const struct pel_night_sky *night, double visibility_m,
                        struct pel_night_map *out);
