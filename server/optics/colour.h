/* From spectral radiance at 680, 550 and 440 nm to linear Rec. 709 in cd/m²,
 * to exposure, to 8 bits. Any thread. */
#pragma once

#include "optics/atmosphere.h"

/* Row-major matrix M: Rec. 709 cd/m² = M · (L680, L550, L440). Built from the
 * CIE 1931 observer (Wyman, Sloan, Shirley 2013 fit) with the spectrum between
 * and beyond the three samples taken as the Sun's times a quadratic. */
void pel_colour_matrix(double m[9]);

/* Photometric illuminance [lx] of a spectral irradiance. */
double pel_colour_illuminance(struct pel_rgb irradiance);

/* EV100 an incident-light meter (C = 250) gives for an illuminance [lx],
 * within [-3, 16]. */
double pel_colour_auto_ev(double illuminance_lx);

/* Scale from cd/m² to exposed linear values for EV100: 1 / (1.2 · 2^EV). */
double pel_colour_exposure_scale(double ev100);
