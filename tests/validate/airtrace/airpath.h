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

/* What a sight itself meets on the ground, where that is not the ground's mean:
 * a realised surface, by directions that light comes from in the end, in the
 * sight's frame. */
struct air_escape {
    struct air_vec toward;
    double upto; /* sum of the middle channel's weights so far */
    double weight[AIR_CHANNELS];
};
struct air_first {
    const struct air_escape *escapes;
    int count;    /* 0: nothing is mirrored */
    double drawn; /* mean weight of the middle channel */
    /* Light out of the water that is seen, of the ground's; of a Sun's beam of
     * 1, what is mirrored twice and more. */
    double leaves[AIR_CHANNELS], again[AIR_CHANNELS];
};

/* What a path from the eye has met first. */
enum air_part { AIR_TURNED, AIR_MIRRORED, AIR_LEFT_WATER, AIR_PARTS };

struct air_sight {
    int channel;
    double height;         /* of the eye, km */
    struct air_vec toward; /* unit */
    int suns;
    double zenith[AIR_SUNS]; /* rad */
    int first_order;         /* paths bring it, too (tests) */
    int guided; /* turns are sought where the only Sun shines: for dusk */
    const struct air_first *first; /* NULL: the ground; of one Sun */
};

/* Radiance for a solar irradiance of 1, of light turned once. */
void air_once(const struct air_scene *scene, const struct air_sight *sight,
              double light[AIR_SUNS]);

/* Mean over `paths` of light turned more often. The seed moves a lattice over
 * the first two turns, so means of several seeds tell the error. */
void air_more(const struct air_scene *scene, const struct air_sight *sight,
              int paths, uint64_t seed, double light[AIR_SUNS]);

/* The same, of the first Sun, by what is met first. */
void air_parts(const struct air_scene *scene, const struct air_sight *sight,
               int paths, uint64_t seed, double part[AIR_PARTS]);

#endif
