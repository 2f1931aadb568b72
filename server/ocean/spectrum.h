/* Directional wave spectra S(ω, θ) = S(ω) D(θ) [m² s / rad²] and the
 * dispersion of deep water. Plain functions, any thread. */
#pragma once

#include <stdbool.h>

#include "ocean/sea.h"

/* Does the spectrum depend on it (of enum pel_spectrum_uses)? */
bool pel_spectrum_uses(enum pel_spectrum_kind kind, unsigned what);

/* Is S(omega) below all of the wind sea of `desc`? Others have a depth, rain or
 * wave numbers of their own: directional.h. */
bool pel_spectrum_is_whole(const struct pel_sea_desc *desc);

/* Wind at 19.5–20 m over wind at 10 m. Pierson and Moskowitz (and V20 in
 * Bruneton et al. 2010, eq. 1) mean the higher one, everything else here the
 * wind at 10 m. Neutral logarithmic profile: 1 + √C_D / κ · ln 2 with
 * C_D = 1.3e-3, κ = 0.4. So Hs = 0.2092 V20²/g = 0.2361 U10²/g. */
#define PEL_WIND_20_OVER_10 1.0625

/* Deep water with surface tension: ω² = g k (1 + k²/k_m²), k_m = 370 rad/m.
 * k in rad/m, ω in rad/s. */
double pel_dispersion_omega(double k);

/* Omnidirectional wind-sea spectrum S(ω) [m² s/rad], ω > 0 rad/s; k = ω²/g.
 * Pierson–Moskowitz: Bruneton et al. 2010 eq. 1 with
 * V20 = PEL_WIND_20_OVER_10 · wind_mps.
 * JONSWAP: Hasselmann et al. 1973, α = 0.076 (U²/(F g))^0.22,
 * ω_p = 22 (g²/(U F))^(1/3), peak factor γ^r with σ = 0.07 below the peak and
 * 0.09 above. Zero when wind_mps is 0. */
double pel_spectrum_wind(const struct pel_sea_desc *desc, double omega);

/* Peak frequency of the wind sea [rad/s]; 0 without wind. */
double pel_spectrum_peak(const struct pel_sea_desc *desc);

/* Spreading exponent of Hasselmann, Dunckel and Ewing 1980:
 * s = 6.97 (ω/ω_p)^4.06 below the peak,
 * 9.77 (ω/ω_p)^(−2.33 − 1.45 (U/c_p − 1.17)) above, c_p = g/ω_p. */
double pel_spectrum_spreading(const struct pel_sea_desc *desc, double omega);

/* Spreading density D(θ) = N cos^{2s}(θ/2) [1/rad], ∫ D dθ = 1 over
 * [−π, π], s ≥ 0; θ relative to the mean direction, rad. */
double pel_spectrum_direction(double s, double theta);

/* m0 = ∫ S dω [m²] over [omega_lo, omega_hi], 0 ≤ omega_lo, omega_hi may be
 * INFINITY: closed form for Pierson–Moskowitz and every tail, else quadrature
 * to 1e-6 relative. Wind sea only. */
double pel_spectrum_m0(const struct pel_sea_desc *desc, double omega_lo,
                       double omega_hi);
