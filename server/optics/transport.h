/* Light inside the water: Iwasaki, Dobashi and Nishita 2003 ("I"), corrected,
 * and all orders beyond it. Plane-parallel water below a flat surface of index
 * PEL_WATER_INDEX, a Lambertian bottom, scattering by any of
 * optics/phase.h.
 * One wavelength at a time, double precision. Any thread.
 *
 * Results are radiances just above the surface for a unit of solar irradiance
 * normal to the beam above it [1/sr]. An azimuth of 0 looks towards the Sun.
 */
#pragma once

#include <stdbool.h>

#include "base/err.h"
#include "optics/phase.h"

/* Water at one wavelength. */
struct pel_medium {
    double absorption; /* a, 1/m, PEL_ABSORPTION_MIN..PEL_COEFFICIENT_MAX */
    double scattering; /* b, 1/m, 0..PEL_COEFFICIENT_MAX */
    double asymmetry;  /* g of particles, 0..PEL_ASYMMETRY_MAX; read where
                          `back` is 0 */
    double depth_m;    /* PEL_DEPTH_MIN..PEL_DEPTH_MAX */
    double albedo;     /* of the bottom, 0..1 */
    double molecular;  /* share of the scattering that is the water's own, 0..1;
                          0: all by particles */
    double back;       /* backscattered fraction of particles, by Fournier and
                          Forand's function; 0: Henyey and Greenstein's */
};

/* How it turns light (optics/phase.h). */
struct pel_phase pel_medium_phase(const struct pel_medium *medium);

/* Fraction of the scattering that turns by less than 90°, c_f. */
double pel_medium_forward(const struct pel_medium *medium);

/* Mean cosine of the scattering. */
double pel_medium_mean_cosine(const struct pel_medium *medium);

#define PEL_ABSORPTION_MIN 0.001
#define PEL_COEFFICIENT_MAX 100.0
#define PEL_ASYMMETRY_MAX 0.98
#define PEL_DEPTH_MIN 0.1
#define PEL_DEPTH_MAX 11000.0

/* Zeniths in air, 0..π/2 (the Sun's is that of a point below it). */
struct pel_geometry {
    double sun_zenith_rad, view_zenith_rad;
    double azimuth_rad; /* of the line of sight from the Sun's, any */
};

/* OUT_OF_RANGE and *fault (NULL allowed) filled, `name` as its path, unless
 * value is in minimum..maximum. */
PEL_CHECK enum pel_err pel_optics_check(const char *name, const char *unit,
                                        double value, double minimum,
                                        double maximum,
                                        struct pel_fault *fault);

/* OUT_OF_RANGE, *fault (NULL allowed) naming `absorption`, `depth` …, when a
 * value is outside its range or not finite. */
PEL_CHECK enum pel_err pel_medium_check(const struct pel_medium *medium,
                                        struct pel_fault *fault);

/* Phase function of Henyey and Greenstein [1/sr], I eq. 2 with β = b p; `nu`
 * the cosine of the scattering angle. Integrates to 1 (I eq. 3). */
double pel_hg_phase(double nu, double g);

/* Forward fraction c_f = 2π ∫₀^{π/2} p sin α dα, in closed form. I gives it
 * without 1/b. */
double pel_hg_forward_fraction(double g);

/* The g in 0..PEL_ASYMMETRY_MAX whose phase function is `phase` [1/sr] at a
 * scattering angle of cosine nu < 0, where it falls as g grows. */
double pel_hg_asymmetry(double nu, double phase);

/* Refraction of a geometry at the flat surface: cosines in the water, the
 * irradiance normal to the refracted beam just below it, E T_i cos θ_ii /
 * cos θ_io, and T_o / n², the part of the radiance below that is seen above. */
struct pel_interface {
    double sun_mu, view_mu, scatter_nu;
    double beam, leaving;
};
struct pel_interface pel_interface_at(const struct pel_geometry *geometry);

enum pel_extinction {
    PEL_EXTINCTION_FULL,    /* c */
    PEL_EXTINCTION_REDUCED, /* c (1 − ω0 c_f), as I eq. 5 */
};

/* Single scattering, I eq. 5; L_sun T_i is the horizontal irradiance. */
double pel_transport_single(const struct pel_medium *medium,
                            const struct pel_geometry *geometry,
                            enum pel_extinction extinction);

/* Radiance of single scattering at a depth in a direction of zenith cosine
 * `mu` > 0 downward, < 0 upward, I eq. 7, over β E': attenuation and path only
 * [m]. Where sec θ_io cos θ = 1 its limit, z sec θ_io exp(−c z sec θ_io). */
double pel_transport_first_path(const struct pel_medium *medium, double sun_mu,
                                double depth_m, double mu);

/* The depth integral of I eq. 6 for light that was scattered into zenith
 * cosine mu: attenuation towards the view times first_path, in closed form
 * [m²]. */
double pel_transport_second_path(const struct pel_medium *medium, double sun_mu,
                                 double view_mu, double mu);

/* Second order, I eq. 6–8, full extinction: quadrature over directions, in
 * closed form over depth. About 2 ms, good to 1e-4. */
double pel_transport_second(const struct pel_medium *medium,
                            const struct pel_geometry *geometry);

/* The same as the paper samples it: `planes` levels of depth, equal steps
 * in θ and twice as many in φ. 1..64 planes, 2..256 zeniths. */
double pel_transport_second_sampled(const struct pel_medium *medium,
                                    const struct pel_geometry *geometry,
                                    int planes, int zeniths);

/* Sunlight the bottom reflects, unscattered on its way, I eq. 9. */
double pel_transport_bottom(const struct pel_medium *medium,
                            const struct pel_geometry *geometry);

enum pel_water_orders {
    PEL_ORDERS_ALL,    /* every order, internal reflection, light to and from
                          the bottom scattered on its way */
    PEL_ORDERS_TWO,    /* single and second, both with full extinction */
    PEL_ORDERS_PAPER,  /* single with reduced extinction, second with full */
    PEL_ORDERS_SINGLE, /* of these the single alone */
    PEL_ORDERS_COUNT,
};

/* How these count single scattering. */
enum pel_extinction pel_orders_extinction(enum pel_water_orders orders);

struct pel_leaving {
    double single, second, higher; /* never touched the bottom */
    double bottom_direct;          /* I eq. 9 */
    double bottom_scattered;       /* touched it and was scattered as well */
    double total;
};

/* Everything at once; higher and bottom_scattered are 0 but with
 * PEL_ORDERS_ALL, which takes about 30 ms. NO_MEMORY. */
PEL_CHECK enum pel_err
pel_transport_leaving(const struct pel_medium *medium,
                      const struct pel_geometry *geometry,
                      enum pel_water_orders orders, struct pel_leaving *out);
