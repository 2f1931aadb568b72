/* The surface of the water, level or of facets with Gaussian slopes, and the
 * sky above it. */
#ifndef UNDERSURFACE_H
#define UNDERSURFACE_H

#include "underphase.h"

struct under_surface {
    double index;
    double along, across; /* variances of slopes; 0, 0: level */
    double toward;        /* azimuth of the axis `along`, rad */
};

enum under_side { UNDER_AIR, UNDER_WATER };

/* Fresnel's reflectance, unpolarised, for the cosine (0..1) on the side that
 * light comes from, and the relative index there: other side over this. 1 where
 * light is totally reflected. */
double under_fresnel(double cosine, double index);

/* The direction behind a level surface, of d that comes from `from`, 0 where
 * it is totally reflected; the reflectance. */
struct under_vec under_refracted(const struct under_surface *surface,
                                 enum under_side from, struct under_vec d,
                                 double *reflectance);

/* Follows a ray *d that comes from a side of a rough surface from facet to
 * facet as Smith's model has them, heights and slopes independent (Heitz,
 * Hanika, d'Eon and Dachsbacher 2016), by chance reflected or refracted at
 * each; the side to which it leaves, with its direction. All light leaves. */
enum under_side under_cross(const struct under_surface *surface,
                            struct sea_random *random, enum under_side from,
                            struct under_vec *d);

/* Radiance just below a rough surface, in the direction of sight `toward`
 * (upwards), of a parallel beam of irradiance 1 (normal to it) from the
 * direction `sun`, refracted once: closed form with Smith's masking. */
double under_glitter(const struct under_surface *surface, struct under_vec sun,
                     struct under_vec toward);

/* Radiance of the sky by zenith angle and azimuth from the Sun's, bilinear;
 * `uniform` where there is no table. */
struct under_sky {
    double uniform;
    int zeniths, azimuths;
    double *zenith, *azimuth; /* rad, rising */
    double *radiance;         /* of [zenith][azimuth] */
};

/* Of a file of lines `zenith,azimuth,radiance`, degrees, each pair of a grid
 * once in any order, other lines left out. Azimuths that end at 180 mean both
 * sides. 0, or -1 and words in *why. */
int under_sky_read(struct under_sky *sky, const char *path, const char **why);
void under_sky_free(struct under_sky *sky);
double under_sky_at(const struct under_sky *sky, struct under_vec toward);

#endif
