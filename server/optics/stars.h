/* The stars that an eye sees: the Bright Star Catalogue (5th revised edition,
 * 9,100 stars to magnitude 6.5 and some beyond), as Debian's package xplanet
 * installs it. Any thread. */
#pragma once

#include <stddef.h>

#include "base/vec.h"
#include "optics/atmosphere.h"

#define PEL_STARS_FILE "/usr/share/xplanet/stars/BSC"
#define PEL_STARS_MOST 10000

struct pel_star {
    struct pel_vec3 to;        /* unit, equator and equinox of J2000 */
    struct pel_vec3 moves;     /* a year, rad: of the fastest alone */
    struct pel_rgb irradiance; /* above the air, W m⁻² nm⁻¹ */
    double magnitude;          /* V */
};

/* Irradiance above the air of magnitude V, by the colour B − V: at 550 nm
 * 3.63e-11 W m⁻² nm⁻¹ for 0 (Bessell, Castelli, Plez 1998); at 440 and 680 nm
 * the Sun's (B − V 0.65) by the difference of B − V, and 0.55 of it. */
struct pel_rgb pel_star_irradiance(double magnitude, double b_v);

/* The catalogue, read once; none where there is no such file, and the log says
 * so. Its lines are declination [deg], right ascension [h], magnitude, a name
 * and the number in the catalogue. Colours are in it no more: those of the 80
 * brightest are here, the others are taken as 0.45; and the motions of those
 * faster than 0.5″ a year that are bright, or than 2″ (0.015° from 2000 to
 * 2026), by Hipparcos. */
const struct pel_star *pel_stars(size_t *count);

/* The same from a text. */
size_t pel_stars_read(const char *text, struct pel_star *out, size_t most);
