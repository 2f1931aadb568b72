/* Radiance that a realised sea shows in one direction, by rays. */
#ifndef SEALIGHT_H
#define SEALIGHT_H

#include "searay.h"

enum {
    SEA_SUNS = 3,
    SEA_CHANNELS = 3,
    SEA_SKY_ELEVATIONS = 121, /* at 90 (i / 120)^2 degrees */
    SEA_SKY_AZIMUTHS = 181,   /* degrees from the Sun's azimuth */
    SEA_ORDERS = 8
};

/* The sky's radiance at one place of the Sun, the same on both its sides. */
struct sea_sky {
    double sun[3];     /* towards it; its azimuth is the x axis */
    double irradiance; /* of the Sun, normal to its beam */
    float radiance[SEA_SKY_ELEVATIONS][SEA_SKY_AZIMUTHS][SEA_CHANNELS];
};

void sea_sky_look(const struct sea_sky *sky, const double *direction,
                  double *radiance);

/* Where an eye far above the sea looks: zenith is of the direction from the
 * sea to the eye; azimuth of the line of sight, 0 towards the Sun. Directions
 * are spread evenly over the two fields (full widths, as in a picture). */
struct sea_row {
    double zenith_rad, azimuth_rad;
    double wide_rad, high_rad;
};

struct sea_row_light {
    double fresnel; /* mean reflectance of what is seen first */
    double white;   /* radiance under a sky of radiance 1, black water */
    double closed;  /* the same with water of radiance 1: 1 is right */
    double once;    /* white's part of what escapes after one reflection */
    double blocked; /* share of first reflections that meet another wave */
    double area;    /* share of the surface that is seen, of its horizontal
                       extent */
    double lost;    /* share of rays given up */
    double sky[SEA_SUNS][SEA_CHANNELS];
    double sky_once[SEA_SUNS]; /* of sky at the middle channel, mirrored once */
    double sun[SEA_SUNS];      /* mirrored once */
    double sun_more[SEA_SUNS]; /* mirrored twice and more */
    double sun_rays[SEA_SUNS]; /* mirrored once, by the rays of the eye */
};

/* From rays of the eye: all but `sun`. */
void sea_row_rays(const struct sea_surface *surface, double index,
                  const struct sea_row *row, const struct sea_sky *skies,
                  int suns, int rays, struct sea_random *random,
                  struct sea_row_light *light);

/* Slopes at random places, for the next. */
struct sea_facet {
    float x, y, slope_x, slope_y;
};
void sea_facets(const struct sea_surface *surface, struct sea_random *random,
                struct sea_facet *facets, int count);

/* light->sun, from the facets that mirror the Sun to the eye. */
void sea_row_sun(const struct sea_surface *surface, double index,
                 const struct sea_row *row, const struct sea_sky *skies,
                 int suns, const struct sea_facet *facets, int count,
                 struct sea_random *random, struct sea_row_light *light);

#endif
