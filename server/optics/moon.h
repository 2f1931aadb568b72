/* The Moon as a light: how bright it is by its phase, and how its disc is lit.
 * The phase angle alpha [rad, 0..pi] is that between the Sun and the eye as the
 * Moon sees them, 0 at full Moon. Any thread. */
#pragma once

#define PEL_MOON_DISTANCE 384400e3  /* m, at which PEL_MOON_STRENGTH holds */
#define PEL_MOON_RADIUS 1737.4e3    /* m */
#define PEL_MOON_MAGNITUDE (-12.73) /* of the full Moon, V, above the air */
#define PEL_MOON_ANGULAR_RADIUS 0.004520 /* rad, at that distance */

/* Irradiance at this distance [m] over that of the full Moon at the mean one:
 * Krisciunas and Schaefer 1991, eq. 9, 0.026 |alpha| + 4e-9 alpha^4 magnitudes
 * [alpha in degrees]; without the rise of a third within 7 deg of full. */
double pel_moon_strength(double alpha, double distance_m);

/* Phase angle of which this share of the disc is lit, 0..1. */
double pel_moon_alpha(double lit);

/* A sphere of dust (Lommel and Seeliger): brightness at cosines mu0 to the Sun
 * and mu to the eye over the mean of the disc at full Moon is 2 mu0 / (mu0 +
 * mu); the share of that mean left at this phase angle. */
double pel_moon_disc(double alpha);

/* Brightness of the side that only the Earth lights over twice that of the
 * full Moon: the Earth's geometric albedo 0.367, its phase that of a matt
 * sphere. */
double pel_moon_earthlight(double alpha);
