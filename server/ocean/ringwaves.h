/* What rain does to waves: drops raise ring waves and stir the water below,
 * which takes short gravity waves away. Plain functions, any thread. */
#pragma once

#define PEL_RAIN_MOST_MM_H 150.0

/* Spectrum of the ring waves over frequency [m² s], frequency_hz > 0: Bliven,
 * Sobieski and Craeye 1997, S_p exp(−π (ln(f/f_p) / (Δf/f_p))²),
 * f_p = 5.772 − 0.0018 R Hz, Δf = 4.42 + 0.0028 R Hz,
 * S_p = 6e-4 R^0.53 cm² s, measured for 10 to 200 mm/h over water without wind.
 * 0 where rain_mm_h is 0. */
double pel_ring_density(double rain_mm_h, double frequency_hz);

/* Share of its energy that a wave of k rad/m keeps in rain at a wind at 10 m of
 * wind_mps, 0..1; 1 where rain_mm_h is 0.
 *
 * The water stirred has an eddy viscosity of ten times the molecular (Poon,
 * Tang and Wu 1992) down to 0.1 m, the same from 40 mm/h on (Peirson et al.
 * 2013: 40 to 170 mm/h) and in proportion below. A wave loses 4 ν k² of its
 * energy times the share 1 − e^{−2kh} of its motion that is there. It falls for
 * PEL_RAIN_LASTING_S, but not below the share of its growth by the wind (Plant
 * 1982) that is left. */
#define PEL_RAIN_LASTING_S 600.0
double pel_rain_leaves(double rain_mm_h, double k, double wind_mps);

/* Share of whitecaps that rain leaves, e^{−R/20 mm/h}. Set by words: in tens of
 * mm/h there are next to none, whatever the wind (Cavaleri, Bertotti and Bidlot
 * 2015); no measured law was found. */
double pel_rain_whitecaps(double rain_mm_h);
