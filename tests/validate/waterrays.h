/* Photons in deep water below a flat surface, followed backwards from the eye:
 * a reference for server/optics, with which it shares no code, table or
 * constant but the refractive index. Particles scatter by Fournier and Forand
 * 1994 of a backscattered fraction, integrated here; molecules by 1 + q cos².
 * What particles turn by less than one degree is taken as not turned. Any
 * thread. */
#pragma once

#include <stdint.h>

struct ray_water {
    double absorption;           /* 1/m */
    double molecular, particles; /* scattering, 1/m */
    double index, size_slope;    /* n and μ of the particles */
    double molecular_anisotropy; /* q */
};

struct ray_sun {
    double zenith,
        azimuth; /* rad; azimuth of the line of sight from the Sun's */
};

#define RAY_SUNS 16

/* Radiance above the surface towards an eye at zenith angle `view` (rad) for
 * Suns of irradiance 1 normal to their beams: mean and its standard error. */
void water_rays(const struct ray_water *water, double view,
                const struct ray_sun *suns, int count, uint64_t paths,
                uint64_t seed, double *mean, double *error);

/* The same of what `from` turns by Raman scattering, `strength` [1/m] of its
 * scalar irradiance, into light that goes on in `to`: phase function 1 + 0.55
 * cos². The Suns have irradiance 1 in `from`. */
void water_rays_raman(const struct ray_water *to, const struct ray_water *from,
                      double strength, double view, const struct ray_sun *suns,
                      int count, uint64_t paths, uint64_t seed, double *mean,
                      double *error);

/* Fournier and Forand's phase function of such particles [1/sr], within one
 * degree as at its edge. */
double water_ray_particles(double index, double size_slope, double angle);

/* Backscattered fraction of those particles, by quadrature. */
double water_ray_back(double index, double size_slope);
