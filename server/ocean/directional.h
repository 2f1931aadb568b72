/* A directional wave spectrum of any origin as one type: variance of height
 * over wavenumber and direction. Wind sea, swell trains and buoys' records are
 * parts of it, each a density over ln k on PEL_DIRECTIONAL_NODES nodes times a
 * spreading. Immutable once built, any thread. Directions are mathematical,
 * the way waves travel to. */
#pragma once

#include <stdbool.h>

#include "base/err.h"
#include "ocean/sea.h"

#define PEL_DIRECTIONAL_NODES 1024
#define PEL_DIRECTIONAL_CUT 832 /* node of PEL_SEA_SHORTEST_M */
#define PEL_DIRECTIONAL_LONGEST_M 20000.0
#define PEL_DIRECTIONAL_PARTS (2 + PEL_SEA_MAX_SWELLS) /* and ring waves */

enum pel_spreading {
    PEL_SPREADING_COSINE,  /* cos^{2s}(θ/2), shape = s */
    PEL_SPREADING_ELLIPSE, /* (1 + Δ cos 2θ)/π, |θ| < π/2, shape = Δ */
    PEL_SPREADING_NORMAL,  /* Gaussian, shape = standard deviation */
    PEL_SPREADING_ENTROPY, /* maximum entropy of two moments */
};

/* Lygre and Krogstad 1986: D = top / |1 − p e^{−iθ} − q e^{−2iθ}|². */
struct pel_entropy {
    double px, py, qx, qy, top;
};

struct pel_directional_part {
    enum pel_spreading spreading;
    int last; /* node where it ends, sharply */
    double direction_rad;
    double energy[PEL_DIRECTIONAL_NODES]; /* m² for each unit of ln k */
    double shape[PEL_DIRECTIONAL_NODES];
    double log_norm[PEL_DIRECTIONAL_NODES]; /* of the cosine */
    struct pel_entropy *entropy;            /* NULL or one for each node */
};

/* A single wave: all its energy at one wave vector. */
struct pel_directional_line {
    double kx, ky, energy; /* rad/m, m² */
};

struct pel_directional {
    double log_k0, step; /* ln k of node i is log_k0 + step · i */
    double depth_m;      /* 0: deep */
    double wind_to_rad;  /* axis of `along` */
    int count;
    struct pel_directional_part part[PEL_DIRECTIONAL_PARTS];
    int line_count;
    struct pel_directional_line line[PEL_SEA_MAX_SINGLES];
};

/* Builds the spectrum of a sea; OUT_OF_RANGE as pel_sea_build, NO_MEMORY.
 * All but Elfouhaily's end at PEL_SEA_SHORTEST_M. A spectrum over frequency
 * becomes one over wavenumber by ω² = g k tanh(k d), without surface tension.
 *
 * Pierson–Moskowitz, JONSWAP: spectrum.h. TMA (Bouws et al. 1985): JONSWAP
 * times tanh²(kd) / (1 + 2kd/sinh 2kd). OMEGA2: h ∝ ω⁻² for waves in geometric
 * progression is S = α g² ω⁻⁵, α of Pierson–Moskowitz, down from that one's
 * peak. These spread as Hasselmann 1980 with the floor of sea.h. Bretschneider
 * (ITTC, Recommended Procedure 7.5-02-07-01.1): S = A ω⁻⁵ exp(−B ω⁻⁴), B = 5/4
 * ω_p⁴, A = B H²/4, spread as 2/π cos² θ. Elfouhaily,
 * Chapron, Katsaros and Vandemark 1997: eq. 30–32, 34–37, 40, 41, 43, 44, 49,
 * 57, 66; that density is symmetric between a wave and its opposite, here all
 * waves run with the wind, and keep the share that the wind sustains against
 * viscosity (pel_wind_over_viscosity). Swell: Gaussian, 6 % in ω, and in
 * direction. Measured: linear between the record's frequencies; beyond them ω⁻⁵
 * with the mean level and moments of the highest four tenths. In rain the wind
 * sea keeps what pel_rain_leaves, and ring waves run evenly to all sides, with
 * surface tension (ringwaves.h). */
PEL_CHECK enum pel_err pel_directional_create(const struct pel_sea_desc *desc,
                                              struct pel_directional **out);
void pel_directional_destroy(struct pel_directional *d); /* NULL allowed */

/* Is `desc` inside its ranges? */
bool pel_sea_desc_ok(const struct pel_sea_desc *desc);

/* Density over ln k and direction [m²/rad] at the wave vector (kx, ky); single
 * waves are no part of it, nor of what follows, but of the moments. */
double pel_directional_density(const struct pel_directional *d, double kx,
                               double ky);

/* S(ω, θ) [m² s/rad²], with the whole dispersion ω(k). */
double pel_directional_at(const struct pel_directional *d, double omega,
                          double theta);

/* Integrals of the spectrum over a band of wavenumbers. */
struct pel_band_moments {
    double m0;                  /* m² */
    double along, cross, mixed; /* slope variance, in wind axes */
    double east, north; /* ∫ E (cos θ, sin θ): mean direction, m² */
};
void pel_directional_moments(const struct pel_directional *d, double k_lo,
                             double k_hi, struct pel_band_moments *out);

/* The same without the single waves. */
void pel_directional_continuous(const struct pel_directional *d, double k_lo,
                                double k_hi, struct pel_band_moments *out);

/* Energy of all parts at node i and their first and second angular moments,
 * energy-weighted: Σ E (cos θ, sin θ, cos 2θ, sin 2θ) [m²]. */
struct pel_node_moments {
    double energy, c1, s1, c2, s2;
};
void pel_directional_node(const struct pel_directional *d, int i,
                          struct pel_node_moments *out);

/* ω(k) [rad/s] of gravity waves with surface tension in depth_m of water (0:
 * deep): ω² = g k (1 + k²/k_m²) tanh(k d), and its inverse, k to 1e-12. */
double pel_dispersion_depth(double k, double depth_m);
double pel_dispersion_k(double omega, double depth_m);

/* Elfouhaily et al. 1997: omnidirectional S(k) [m³] and the anisotropy Δ(k)
 * of its spreading, for wind at 10 m and inverse wave age from the fetch. */
void pel_elfouhaily(double k, double wind_mps, double fetch_m, double *density,
                    double *delta);

/* Its peak, rad/m. */
double pel_elfouhaily_peak(double wind_mps, double fetch_m);

/* Rate β [1/s] at which the wind raises the energy of a wave of k rad/m:
 * 0.05 ω (v/c)², v the friction velocity (Plant 1982: 0.04 ± 0.02). */
double pel_wind_growth(double k, double wind_mps);

/* Share of a wave's growth by the wind that viscosity leaves, 0..1:
 * 1 − 4 ν k² / β. Elfouhaily's long waves do not know the calm below which wind
 * raises no ripples: alone they have a mean-square slope of 0.021 at any wind,
 * more than Cox and Munk saw in all below 3.5 m/s. This takes the ripples of
 * light winds away and changes little above 5 m/s. */
double pel_wind_over_viscosity(double k, double wind_mps);
