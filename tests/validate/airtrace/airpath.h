/* Light along a line of sight: the first order by quadrature, the others by
 * random paths followed backwards from the eye, with the Sun asked for at each
 * turn. The Suns stand over the x axis; the eye is over the z axis. */
#ifndef AIRPATH_H
#define AIRPATH_H

#include "airground.h"
#include "airsun.h"

enum { AIR_SUNS = 16 };

struct air_scene {
    const struct air *air;
    const struct air_sun *sun;
    const struct air_ground *ground;
};

struct air_sight {
    int channel;
    double height;         /* of the eye, km */
    struct air_vec toward; /* unit */
    int suns;
    double zenith[AIR_SUNS]; /* rad */
    int first_order;         /* paths bring it, too (tests) */
    int guided; /* turns are sought where the only Sun shines: for dusk */
};

/* Radiance for a solar irradiance of 1, of light turned once. */
void air_once(const struct air_scene *scene, const struct air_sight *sight,
              double light[AIR_SUNS]);

/* Mean over `paths` of light turned more often. The seed moves a lattice over
 * the first two turns, so means of several seeds tell the error. */
void air_more(const struct air_scene *scene, const struct air_sight *sight,
              int paths, uint64_t seed, double light[AIR_SUNS]);

#endif
