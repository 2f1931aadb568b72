/* The sea from high up: the WGS 84 ellipsoid, made a sphere by an affine map,
 * so that rays that touch the one touch the other. Directions and lengths of
 * the eye's frame (x, y level, z up along the ellipsoid's normal, metres) go
 * over by `from`; in the frame of the sphere the eye stands on the z axis. The
 * air is a shell of that frame (optics/atmosphere.h). Pure functions, any
 * thread. */
#pragma once

#include <stdbool.h>

#include "base/vec.h"

/* Eyes above the open sea from LEAST on have this form; from there to WHOLE the
 * sphere of the low one and the light of its eye's nadir turn into the
 * ellipsoid and the light of each point. What there is only near the eye
 * (things, lamps, a bottom, clouds and fog with a shape) keeps the low form up
 * to WHOLE; from there to ALONE such views are drawn in both forms and mixed.
 */
#define PEL_SPACE_LEAST_M 10000.0
#define PEL_SPACE_WHOLE_M 20000.0
#define PEL_SPACE_ALONE_M 30000.0

struct pel_space_geometry {
    double height_m;       /* in the sphere's frame, above its radius */
    double whole;          /* 0 at LEAST, 1 from WHOLE on */
    struct pel_mat3 from;  /* of the eye's frame into the sphere's */
    struct pel_mat3 earth; /* of the eye's frame into axes fixed to the Earth:
                              x to 0° N 0° E, z to the north pole */
    double semi_major_m, semi_minor_m;
};

/* Of an eye at height_m (> 0) above the ellipsoid; true north stands
 * `convergence_rad` clockwise of the frame's y axis. */
struct pel_space_geometry pel_space_geometry_of(double height_m,
                                                double latitude_rad,
                                                double longitude_rad,
                                                double convergence_rad);

/* Distance in metres from the eye along a unit direction of its frame to the
 * ellipsoid, and the unit normal there in that frame; false: it is not met. */
bool pel_space_meets(const struct pel_space_geometry *g, struct pel_vec3 dir,
                     double *distance_m, struct pel_vec3 *normal);

/* Angle at the sphere's middle between the nadir and the horizon. */
double pel_space_reach(const struct pel_space_geometry *g);
