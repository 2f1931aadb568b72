/* Rays over a realised surface, and what a flat piece of it reflects. */
#ifndef SEARAY_H
#define SEARAY_H

#include "seasurface.h"

/* Refractive index of sea water, Quan and Fry 1995 eq. 3: salinity in g/kg,
 * degrees Celsius, nm of vacuum. */
double sea_water_index(double salinity, double celsius, double nm);

/* Fresnel's reflectance of unpolarised light, from air; cosine of the angle
 * of incidence, 0 to 1. */
double sea_fresnel(double cosine, double index);

enum sea_end {
    SEA_ESCAPED,
    SEA_HIT,
    SEA_LOST /* more steps than allowed: counted by the caller */
};

struct sea_hit {
    double point[3];  /* just above the surface */
    double normal[3]; /* of the surface there */
    int steps;
};

/* From a point above the surface along a unit direction to the first place
 * where the surface is met. The march never steps further than the steepest
 * gradients of the grids allow, down to SEA_STEP_M, and halves the last step
 * until the crossing is known to 1e-8 m; so a crest is missed only where the
 * ray is in it for less than SEA_STEP_M. */
#define SEA_STEP_M 1.5e-4
enum sea_end sea_trace(const struct sea_surface *surface, const double *from,
                       const double *direction, struct sea_hit *hit);

/* Whether nothing is met from a point of the surface along a direction. */
int sea_sees(const struct sea_surface *surface, double x, double y,
             const double *direction);

void sea_reflect(const double *direction, const double *normal, double *out);

static inline double sea_dot(const double *a, const double *b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

#endif
