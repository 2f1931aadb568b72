/* What comes back out of the water, until it is computed by transport: Case 1
 * water from its chlorophyll. Any thread. */
#pragma once

#include "optics/atmosphere.h"

/* Irradiance reflectance R = 0.33 b_b / a just below the surface (Morel and
 * Prieur 1977) at 680, 550, 440 nm; chlorophyll 0.01..30 mg/m³. */
struct pel_rgb pel_water_reflectance(double chlorophyll_mg_m3);

/* Radiance just above the surface before the Fresnel factor 1 − F̄, for an
 * irradiance E from Sun and sky on the sea: L_sea of Bruneton et al. 2010
 * eq. 28, = E t R / (π n² (1 − r R)) with t, r the surface's diffuse
 * transmittance downward and internal reflectance upward. */
struct pel_rgb pel_water_radiance(double chlorophyll_mg_m3,
                                  struct pel_rgb irradiance);
