/* The clear atmosphere: Rayleigh, aerosols (by visibility) and ozone on a
 * sphere; single scattering integrated along the ray, higher orders by the
 * isotropic series of Hillaire 2020. Double precision reference for
 * shaders/lib/atmosphere.glsl. Any thread once built.
 *
 * Spectral quantities are at 680, 550 and 440 nm in this order (`rgb`):
 * radiance W m⁻² sr⁻¹ nm⁻¹, irradiance W m⁻² nm⁻¹. Lengths in metres. */
#pragma once

#include "base/err.h"
#include "base/vec.h"

#define PEL_EARTH_RADIUS 6360000.0
#define PEL_ATMOSPHERE_RADIUS 6420000.0
#define PEL_SUN_ANGULAR_RADIUS 0.004651 /* rad: 0.2665° */
#define PEL_SUN_SOLID_ANGLE 6.8e-5      /* sr */

struct pel_rgb {
    double r, g, b;
};

struct pel_atmosphere_desc {
    double visibility_m; /* meteorological, Koschmieder 3.912/β, 200..300000 */
};

struct pel_atmosphere {
    struct pel_rgb solar_irradiance;   /* above the air */
    struct pel_rgb rayleigh;           /* scattering at sea level, 1/m */
    double rayleigh_height_m;
    double mie_extinction, mie_scattering; /* at sea level, 1/m */
    double mie_height_m;
    double mie_g;                      /* Cornette–Shanks asymmetry */
    struct pel_rgb ozone;              /* peak absorption, 1/m */
    double ozone_center_m, ozone_width_m; /* triangular profile */
};

/* Fills the constants for a visibility. */
void pel_atmosphere_init(const struct pel_atmosphere_desc *desc,
                         struct pel_atmosphere *out);

/* Transmittance from height_m along a direction of zenith cosine mu to the top
 * of the atmosphere; 0 when the ray meets the ground. */
struct pel_rgb pel_atmosphere_transmittance(const struct pel_atmosphere *a,
                                            double height_m, double mu);

/* Multiple-scattering gain Ψ_ms at a height for a Sun zenith cosine
 * (Hillaire 2020, eq. 10) with a ground of albedo 0.06 (sea). */
struct pel_rgb pel_atmosphere_multiple(const struct pel_atmosphere *a,
                                       double height_m, double sun_mu);

/* Sky radiance seen from height_m in direction `dir` (z up, any elevation;
 * rays that meet the ground end there with nothing added), without the solar
 * disc. `sun` points to the Sun. */
struct pel_rgb pel_atmosphere_sky(const struct pel_atmosphere *a,
                                  double height_m, struct pel_vec3 dir,
                                  struct pel_vec3 sun);

/* Horizontal irradiance of the sky at sea level, by quadrature of the above. */
struct pel_rgb pel_atmosphere_sky_irradiance(const struct pel_atmosphere *a,
                                             struct pel_vec3 sun);

/* Irradiance of the Sun normal to its beam at height_m, with the part of the
 * disc below the horizon left out. */
struct pel_rgb pel_atmosphere_sun_irradiance(const struct pel_atmosphere *a,
                                             double height_m,
                                             struct pel_vec3 sun);
