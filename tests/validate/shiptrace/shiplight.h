/* Light of a ship in a realised sea, by rays: mirrored in it, shading it, and
 * seen through it. */
#ifndef SHIPLIGHT_H
#define SHIPLIGHT_H

#include "../seatrace/sealight.h"
#include "shipmesh.h"

enum { SHIP_SUNS = 3, SHIP_CHANNELS = 3 };

/* A sky of one elevation, with the Sun at several azimuths. */
struct ship_scene {
    struct sea_surface surface;
    struct ship_mesh mesh;
    int suns;
    struct sea_sky sky[SHIP_SUNS];
    double irradiance[SHIP_CHANNELS]; /* of the Sun, normal to its beam */
    double water[SHIP_CHANNELS];      /* radiance that leaves the water */
    double fade[SHIP_CHANNELS];       /* 1/m, of light in the water */
    double index;
    double washed; /* standard deviation of the sea along the hull, m */
};

/* What one line of sight brings. */
struct ship_sight {
    double direct;                         /* 1: it meets the ship */
    double body[SHIP_SUNS][SHIP_CHANNELS]; /* radiance of the ship there */
    double mirrors; /* 1: its mirrored ray meets the ship */
    double sky[SHIP_SUNS][SHIP_CHANNELS];  /* mirrored, without the ship */
    double with[SHIP_SUNS][SHIP_CHANNELS]; /* the same with it */
    double sunny[SHIP_SUNS]; /* share of the Sun seen at the place */
    double lit[SHIP_SUNS][SHIP_CHANNELS]; /* of the water's light of the Sun,
                                             what is left */
    double open[SHIP_CHANNELS];           /* of its light of the sky */
    double wet; /* 1: its refracted ray meets the ship */
    double hull[SHIP_SUNS][SHIP_CHANNELS]; /* radiance of that, in the air */
};

void ship_look(const struct ship_scene *scene, const double *eye,
               const double *direction, struct sea_random *random,
               struct ship_sight *sight);

/* Radiance of the ship at a place of it against the direction of a ray that
 * meets it: Sun, sky, sea's mirror and water below, other parts of the ship.
 * Its paint is glTF's of roughness 1: Lambert's law and facets of GGX
 * (glTF 2.0, appendix B; there the first has also a factor 1 - F, which is left
 * out). */
void ship_radiance(const struct ship_scene *scene, const double *point,
                   const double *direction, const struct ship_hit *hit,
                   int turns, struct sea_random *random,
                   double (*radiance)[SHIP_CHANNELS]);

#endif
