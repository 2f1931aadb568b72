/* What falls through the air: how much light it takes. Plain functions, any
 * thread. */
#pragma once

#define PEL_SNOW_MOST_MM_H 10.0

/* Extinction of rain of a rate [mm/h], 1/m, the same at all wavelengths: drops
 * are far larger than these, so each takes twice its cross-section. Marshall
 * and Palmer 1948, N = 8000 m⁻³ mm⁻¹ e^{−ΛD}, Λ = 4.1 R^−0.21 mm⁻¹:
 * ∫ 2 (π/4) D² N dD = π N₀ / Λ³ = 3.65e-4 R^0.63 (Atlas 1953: 3.912 over
 * 11.6 km R^0.63). */
double pel_rain_extinction(double mm_per_h);

/* The same of snow, its rate in water. Sekhon and Srivastava 1970: melted drops
 * N = 2500 R^−0.94 m⁻³ mm⁻¹ e^{−ΛD}, Λ = 2.29 R^−0.45 mm⁻¹; aggregates of
 * density 0.17 g cm⁻³ mm / D (Holroyd 1971) are (D³ / 0.17)^½ mm across when
 * melted to D mm: 3 π N₀ / (0.17 Λ⁴) = 5.0e-3 R^0.86. */
double pel_snow_extinction(double mm_per_h);

/* The visibility [m] that is left of visibility_m in rain and snow, Koschmieder
 * 3.912/β; visibility_m itself without them; 200 at least, where the air's
 * range ends. */
double pel_visibility_in_rain(double visibility_m, double rain_mm_h,
                              double snow_mm_h);

/* The other way: the visibility of the air alone where visibility_m is seen in
 * rain and snow. Of these remains what takes nine tenths of the extinction,
 * because what is seen counts, not a word for the rain. */
double pel_visibility_besides(double visibility_m, double *rain_mm_h,
                              double *snow_mm_h);
