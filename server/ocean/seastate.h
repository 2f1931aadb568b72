/* Other ways to write how rough the sea is. Plain functions, any thread. */
#pragma once

#include "ocean/sea.h"

/* Wind at 10 m [m/s] of a Beaufort number, 0..10: 0.836 B^1.5 (World
 * Meteorological Organization 1970, the scale's definition since 1946). */
double pel_beaufort_wind(double number);

/* Significant wave height [m] of a degree of Douglas's sea scale, 0..9: the
 * middle of its interval (0, 0.05, 0.3, 0.875, 1.875, 3.25, 5, 7.5, 11.5, 14),
 * linear between degrees. */
double pel_douglas_height(double degree);

/* The wind [m/s] whose wind sea, by the kind, fetch and depth of `desc`, has
 * the significant height; 30 where none within the range raises it. Measured
 * spectra answer as Pierson–Moskowitz. Within 1e-3 m/s. */
double pel_wind_for_height(const struct pel_sea_desc *desc, double height_m);

/* Beaufort number of a wind at 10 m, 0..12, by WMO's classes of speed. */
unsigned pel_beaufort_of(double wind_mps);

/* Degree of Douglas's sea scale, 0..9, whose interval has the significant
 * height. */
unsigned pel_douglas_of(double height_m);
