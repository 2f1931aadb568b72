/* The clear atmosphere: Rayleigh, aerosols (by visibility) and ozone on a
 * sphere; single scattering integrated along the ray, higher orders by
 * optics/airlight.h. Double precision reference for
 * shaders/lib/sky.glsl. Any thread once built.
 *
 * Spectral quantities are at 680, 550 and 440 nm in this order (`rgb`):
 * radiance W m⁻² sr⁻¹ nm⁻¹, irradiance W m⁻² nm⁻¹. Lengths in metres. */
#pragma once

#include "base/err.h"
#include "base/vec.h"
#include "shaders/lib/blocks.h"

#define PEL_EARTH_RADIUS 6360000.0
#define PEL_ATMOSPHERE_RADIUS 6420000.0
/* Normal to the beam above the air. */
#define PEL_SUN_IRRADIANCE                                                     \
    {                                                                          \
        1.474, 1.850, 1.912                                                    \
    }
#define PEL_SUN_ANGULAR_RADIUS 0.004651 /* rad: 0.2665° */
#define PEL_SUN_SOLID_ANGLE 6.8e-5      /* sr */

struct pel_rgb {
    double r, g, b;
};

/* Air crossed by a ray, each constituent as metres of its density at the
 * height where its coefficient is given. */
struct pel_columns {
    double rayleigh, mie, ozone;
};

/* Sizes of the tables below. */
#define PEL_COLUMN_HEIGHTS 40
#define PEL_COLUMN_COSINES 128

struct pel_atmosphere_desc {
    double visibility_m; /* meteorological, Koschmieder 3.912/β, 200..300000 */
};

struct pel_airlight;

/* Shares work between threads as pel_worker_pool_run does. */
typedef void pel_airlight_share(void *pool, int count,
                                void (*work)(void *user, int member, int i),
                                void *user);

/* Light out of the water as a share of what falls on it, matt: chlorophyll
 * 0.2 mg/m³ (Morel and Maritorena 2001). */
#define PEL_SEA_LEAVING                                                        \
    {                                                                          \
        0.0006, 0.006, 0.02                                                    \
    }

/* 120 kB: constants, and two tables that make this reference's sky cheap. */
struct pel_atmosphere {
    struct pel_rgb solar_irradiance; /* above the air */
    struct pel_rgb rayleigh;         /* scattering at sea level, 1/m */
    double rayleigh_height_m;
    double mie_extinction, mie_scattering; /* at sea level, 1/m */
    double mie_height_m;
    double mie_g;                         /* Cornette–Shanks asymmetry */
    struct pel_rgb ozone;                 /* peak absorption, 1/m */
    double ozone_center_m, ozone_width_m; /* triangular profile */
    /* Columns to the top, by distance to the horizon and by the ray's length
     * between its least and greatest (Bruneton and Neyret 2008, sec. 4). */
    struct pel_columns columns[PEL_COLUMN_HEIGHTS][PEL_COLUMN_COSINES];
    struct pel_airlight *airlight; /* light scattered before, or NULL */
};

/* Fills the constants for a visibility (clamped to its range, NaN: 40 km), in
 * under a microsecond; the tables are not touched. Extinction at 550 nm at sea
 * level is 3.912 / visibility (Koschmieder); aerosols are what Rayleigh
 * scattering leaves of it, none beyond 288 km, with a scale height of 1.2 km,
 * or less in fog, whose vertical optical depth stays at PEL_FOG_DEPTH: dense
 * fog is a shallow layer, and it is day below it. The published default, Mie
 * extinction 4.44e-6 1/m, has a visibility of PEL_CLEAR_VISIBILITY_M. */
#define PEL_CLEAR_VISIBILITY_M 217370.0
#define PEL_FOG_DEPTH 1.5
void pel_atmosphere_init(const struct pel_atmosphere_desc *desc,
                         struct pel_atmosphere *out);

/* Fills the tables from the constants, 0.35 to 0.9 s of one core, of which all
 * but 10 ms is shared (NULL: not; airlight.h); the result does not depend on
 * it. Everything below that says `tabulated` needs it; pel_atmosphere_finish
 * gives its memory back. NO_MEMORY. */
PEL_CHECK enum pel_err pel_atmosphere_tabulate(struct pel_atmosphere *a,
                                               pel_airlight_share *share,
                                               void *pool);
/* Likewise, in 10 ms, of a table of the same air made before. */
PEL_CHECK enum pel_err
pel_atmosphere_take_table(struct pel_atmosphere *a,
                          const struct pel_airlight *table);
void pel_atmosphere_finish(struct pel_atmosphere *a);

/* Columns from height_m along a direction of zenith cosine mu to the top, by
 * quadrature to 1e-5; the ray must not meet the ground. */
struct pel_columns pel_atmosphere_columns(const struct pel_atmosphere *a,
                                          double height_m, double mu);

/* Transmittance from height_m along a direction of zenith cosine mu to the top
 * of the atmosphere; 0 when the ray meets the ground, 1 above the air. */
struct pel_rgb pel_atmosphere_transmittance(const struct pel_atmosphere *a,
                                            double height_m, double mu);

/* Part of the solar disc above the horizon of height_m, 0..1: the smooth step
 * ½ + ¾x − ¼x³ of x = (cosine above the horizon) / (angular radius), within
 * 0.04 of the disc's segment. */
double pel_atmosphere_sun_visible(double height_m, double sun_mu);

/* Rayleigh's phase function and that of Cornette and Shanks 1992 [1/sr], of
 * the cosine of the scattering angle. */
double pel_phase_rayleigh(double nu);
double pel_phase_mie(double nu, double g);

/* Sky radiance seen from height_m (also from above the air) in direction `dir`
 * (z up, any elevation; rays that meet the ground end there with nothing
 * added), without the solar disc. `sun` points to the Sun. Tabulated. */
struct pel_rgb pel_atmosphere_sky(const struct pel_atmosphere *a,
                                  double height_m, struct pel_vec3 dir,
                                  struct pel_vec3 sun);

/* Horizontal irradiance of the sky at sea level, by quadrature of the above;
 * about 2 ms. Tabulated. */
struct pel_rgb pel_atmosphere_sky_irradiance(const struct pel_atmosphere *a,
                                             struct pel_vec3 sun);

/* Irradiance of the Sun normal to its beam at height_m, with the part of the
 * disc below the horizon left out; no refraction. */
struct pel_rgb pel_atmosphere_sun_irradiance(const struct pel_atmosphere *a,
                                             double height_m,
                                             struct pel_vec3 sun);
