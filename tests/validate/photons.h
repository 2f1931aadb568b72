/* What the water's photons have in common: random numbers, directions, the
 * flat surface's reflectance and a tabulated phase function. Shares nothing
 * with server/optics but the refractive index. Angles in rad; z is up; any
 * thread. */
#pragma once

#include <stdint.h>

#define PHOTON_INDEX 1.34 /* of the surface */
#define PHOTON_CELLS 8192 /* over the sine of half the angle */
#define PHOTON_PI 3.14159265358979323846

struct photon_vector {
    double x, y, z;
};

/* 0..1, both excluded: PCG (O'Neill 2014). */
double photon_draw(uint64_t *random);

double photon_dot(struct photon_vector a, struct photon_vector b);

/* A direction at this cosine from another, drawn about it. */
struct photon_vector photon_turned(uint64_t *random, struct photon_vector from,
                                   double cosine);

/* Fresnel's reflectance, unpolarised, of light in the water by its angle to
 * the surface's normal; by reciprocity also of the light that comes in so. */
double photon_mirrored(double sine_water, double cos_water);

/* A phase function, 1/sr, and the share turned by less. */
struct photon_phase {
    double value[PHOTON_CELLS + 1];
    double below[PHOTON_CELLS + 1];
};

/* Of a function of the angle; divided by its integral, which is returned. */
double photon_tabulate(struct photon_phase *phase,
                       double (*at)(double angle, const void *of),
                       const void *of);

double photon_turn(const struct photon_phase *phase, double cosine);

/* The density by which photon_draw_cosine draws, flat in each cell. */
double photon_density(const struct photon_phase *phase, double cosine);
double photon_draw_cosine(const struct photon_phase *phase, uint64_t *random);
