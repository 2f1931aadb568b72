/* The sea that a sight meets: realised waves (seatrace), whose facets mirror
 * light on to each other, hide each other, and have water below. */
#ifndef SPACEWAVES_H
#define SPACEWAVES_H

#include <stdbool.h>

#include "../airtrace/airpath.h"
#include "../seatrace/searay.h"

struct space_waves {
    struct sea_surface surface;
    const struct air_ground *ground;
    double along, across; /* by how much places are drawn out */
    int orders;           /* reflections that are followed */
};

/* Linear waves of Elfouhaily's spectrum under a wind in m/s, drawn out along
 * and across it so that they have the ground's variances of slopes, whose axis
 * is theirs. Reflections beyond `orders` are black. */
void space_waves_init(struct space_waves *waves,
                      const struct air_ground *ground, double wind, int orders,
                      uint64_t seed);
void space_waves_finish(struct space_waves *waves);

/* What a sight meets, by `count` rays, which go to `escapes`; in one frame:
 * `toward` the ground, `up` of the place, the Sun and the ground's axis. Water
 * below has one radiance in all directions, such that the ground's albedo of
 * what falls on it would come through a level surface. `*error`: of the mean
 * that is mirrored to a white sky, of itself. */
struct air_first space_waves_first(const struct space_waves *waves,
                                   struct air_vec toward, struct air_vec up,
                                   struct air_vec sun, uint64_t seed,
                                   struct air_escape *escapes, int count,
                                   double *error);

/* Means over rays for the middle channel: mirrored to a white sky, of it once,
 * out of water of radiance 1. */
struct space_white {
    double mirrored, once, water;
};
struct space_white space_waves_white(const struct space_waves *waves,
                                     struct air_vec toward, struct air_vec up,
                                     int rays, uint64_t seed);

#endif
