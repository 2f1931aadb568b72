/* Photons through a column of water whose constituents change with depth,
 * below a level or a wind-blown surface and above a Lambertian bottom, followed
 * from the Sun or the sky downwards: a reference for server/optics, with which
 * it shares nothing but the refractive index. What particles turn by less than
 * one degree is taken as not turned. Any thread. */
#pragma once

#include <stdbool.h>
#include <stdint.h>

/* At a depth [1/m]. */
struct column_water {
    double absorption, molecular, particles;
};

enum column_particles {
    COLUMN_PETZOLD, /* averaged by Mobley 1994, table 3.10 */
    COLUMN_FOURNIER_FORAND,
};

struct column {
    struct column_water (*at)(double depth_m);
    double depth_m; /* of the bottom; what goes deeper is lost */
    double bottom;  /* its albedo */
    enum column_particles by;
    double index, size_slope;    /* of Fournier and Forand's particles */
    double molecular_anisotropy; /* q of 1 + q cos² */
    double slopes;               /* mean square of the surface's, all around */
    /* Light above the surface of horizontal irradiance 1: the cosine of the
     * zenith of a ray of it by a number 0..1. */
    double (*light)(double u);
};

struct column_field {
    double down, scalar_up; /* irradiances */
    double nadir;           /* radiance straight up, 1/sr */
};

/* What of a unit of irradiance is found at these depths (0: just below a level
 * surface), mean and standard error. 1..COLUMN_DEPTHS depths. */
#define COLUMN_DEPTHS 4
void water_column(const struct column *column, const double *depths_m,
                  int depths, uint64_t photons, uint64_t seed,
                  struct column_field *mean, struct column_field *error);
