/* A place of the local frame as a place on Earth: how directions and things are
 * seen from there. The local frame is a map about the origin; an eye far from
 * it has its own horizontal, and its own Sun. Pure, any thread. */
#pragma once

#include <stdbool.h>

#include "base/vec.h"
#include "optics/light.h"
#include "optics/nightsky.h"

struct pel_snapshot;
struct pel_entity_state;

/* Places of eyes are told apart by squares of this side, so that the views of a
 * ship share what is computed of their light: from its middle to its corner the
 * Sun moves by 0.0064 deg, less than the 0.01 deg of its formulae. */
#define PEL_PLACE_SIDE_M 1000.0
/* What is carried so far from an entity's or the origin's place stands there.
 */
#define PEL_PLACE_ARM_M 400.0
/* To this distance from the origin the map is taken as it is: it stretches what
 * lies across the way from there by 0.41 %, bearings by 0.12 deg. */
#define PEL_PLACE_MAP_M 1e6

struct pel_place {
    bool origin; /* the origin's square: nothing below */
    bool far;    /* beyond PEL_PLACE_MAP_M */
    /* In the local frame, the middle of the square; of a far place itself. */
    double east_m, north_m;
    double latitude, longitude; /* deg */
    double turned_rad;          /* local heading less true heading there */
    struct pel_mat3
        turned; /* directions of the origin's axes in this place's */
    struct pel_vec3
        from_m; /* the origin seen from here, in this place's axes */
};

/* The square that a place of the local frame is in: origin, far, east_m and
 * north_m, at once. Far places have none: what is seen from there stands about
 * the place itself. */
struct pel_place pel_place_square(double east_m, double north_m);
/* The rest of it, some microseconds. */
void pel_place_settle(const struct pel_snapshot *s, struct pel_place *place);
/* Both. */
void pel_place_of(const struct pel_snapshot *s, double east_m, double north_m,
                  struct pel_place *out);

/* Whether they are one square. */
static inline bool pel_place_same(const struct pel_place *a,
                                  const struct pel_place *b)
{
    return a->east_m == b->east_m && a->north_m == b->north_m;
}

/* The lights and the night of the snapshot's moment, pel_snapshot_lights and
 * pel_snapshot_night of the origin, as they stand at the place, in the local
 * frame's axes there: rigidly turned, a light at distance_m with its parallax.
 * So Sun and Moon that the state fixes are fixed at the origin. */
void pel_place_lights(const struct pel_snapshot *s, double time_s,
                      const struct pel_place *place,
                      struct pel_light out[PEL_LIGHTS]);
void pel_place_night(const struct pel_snapshot *s, double time_s,
                     const struct pel_place *place, struct pel_vec3 sun,
                     struct pel_night_sky *out);

/* Sun of the place. */
struct pel_vec3 pel_place_sun(const struct pel_snapshot *s, double time_s,
                              const struct pel_place *place);

/* Where a far place has an entity of the local frame: at its true distance and
 * bearing from there, and headed as it truly is. */
void pel_place_carry(const struct pel_snapshot *s,
                     const struct pel_place *place, struct pel_entity_state *e);
