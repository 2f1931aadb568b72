/* Radiance in the water by random paths that are followed backwards from the
 * eye. Every leg of a path gathers, in closed form, the sunlight that it turns
 * once on its whole length, that of the bottom at its lower end, and the sky at
 * its upper one. */
#ifndef UNDERPATH_H
#define UNDERPATH_H

#include "undersurface.h"

/* Lengths in m, coefficients in 1/m. */
struct under_scene {
    double absorption, scattering;
    const struct under_phase *phase;
    struct under_surface surface;
    double sun_zenith; /* rad, in air */
    double irradiance; /* of the Sun, normal to its beam, above the surface */
    const struct under_sky *sky;
    double bottom; /* depth, INFINITY: none */
    double albedo; /* of the matt bottom */
    double sought; /* 1/m: paths are drawn to the surface by it; 0: not */
};

/* A rate at which light falls with depth, roughly and rather too low. */
double under_rate(const struct under_scene *scene);

/* Radiances. */
struct under_light {
    double scattered; /* in the water or at the bottom at least once */
    double window;    /* of the sky, refracted at the surface only */
};

/* Mean over paths, for an eye at a depth (0: just below the surface) that looks
 * in the direction `toward`. The seed moves a lattice over the first turns, so
 * means of several seeds tell the error. */
struct under_light under_look(const struct under_scene *scene, double depth,
                              struct under_vec toward, int paths,
                              uint64_t seed);

/* Radiance of the Sun itself: through a level surface of its disc of radius
 * 0.2665°, through a rough one of the facets that refract it (no disc). */
double under_sun(const struct under_scene *scene, double depth,
                 struct under_vec toward);

/* Irradiance of the Sun's unscattered light through a level surface, normal to
 * the refracted beam; that beam's cosine. */
double under_beam(const struct under_scene *scene, double depth,
                  double *cosine);

/* Plane irradiances and scalar irradiance of light that goes up; a level
 * surface. */
struct under_field {
    double down, up, scalar_up;
};

struct under_field under_field(const struct under_scene *scene, double depth,
                               int paths, uint64_t seed);

#endif
