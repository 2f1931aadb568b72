/* How much of the Sun's light, as a disc, reaches a place. */
#ifndef AIRSUN_H
#define AIRSUN_H

#include "airmodel.h"

/* Radius of the disc, rad: 0.2665 degrees. */
#define AIR_SUN_RADIUS 0.0046513
enum { AIR_SUN_HEIGHTS = 161, AIR_SUN_ANGLES = 1025 };

/* Optical depth from a height to the top along a direction of zenith cosine
 * `cosine`, 1e30 where the ground is in the way; quadrature in
 * `pieces` of three Gauss nodes. */
double air_depth(const struct air *air, int channel, double height,
                 double cosine, int pieces);

/* Mean transmittance over the disc, 0 for what the ground hides: by
 * quadrature over `chords` of it; its middle has the zenith cosine. */
double air_sun_exact(const struct air *air, int channel, double height,
                     double cosine, int chords);

/* The same as a table: linear over the cube root of the height, and the root
 * of the angle above the lower limb of a disc that has just set. */
struct air_sun {
    double ground, top;
    float through[AIR_CHANNELS][AIR_SUN_HEIGHTS][AIR_SUN_ANGLES];
};

void air_sun_init(struct air_sun *sun, const struct air *air);

/* The table's rows about a distance from the Earth's centre, for Suns of any
 * zenith cosine. */
struct air_sun_place {
    const float *lower, *upper;
    double between, limb;
};

struct air_sun_place air_sun_place(const struct air_sun *sun, int channel,
                                   double distance);
double air_sun_seen(const struct air_sun_place *place, double cosine);

#endif
