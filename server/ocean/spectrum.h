/* Directional wave spectra S(ω, θ) [m² s / rad²]. Plain functions, any
 * thread. */
#pragma once

#include "ocean/sea.h"

/* Omnidirectional wind-sea spectrum S(ω) [m² s/rad], ω > 0.
 * Pierson–Moskowitz: Bruneton et al. 2010 eq. 1 in terms of wind at 10 m.
 * JONSWAP: Hasselmann et al. 1973. Zero when wind_mps is 0. */
double pel_spectrum_wind(const struct pel_sea_desc *desc, double omega);

/* Peak frequency of the wind sea [rad/s]; 0 without wind. */
double pel_spectrum_peak(const struct pel_sea_desc *desc);

/* Hasselmann 1980 spreading exponent s(ω). */
double pel_spectrum_spreading(const struct pel_sea_desc *desc, double omega);

/* Spreading density D(θ) = N cos^{2s}(θ/2), normalised so ∫ D dθ = 1;
 * θ relative to the mean direction, rad. */
double pel_spectrum_direction(double s, double theta);

/* m0 = ∫ S dω over [omega_lo, omega_hi], by quadrature to 1e-6 relative. */
double pel_spectrum_m0(const struct pel_sea_desc *desc, double omega_lo,
                       double omega_hi);
