/* From spectral radiance at 680, 550 and 440 nm to linear Rec. 709 in cd/m²,
 * to exposure, to 8 bits. Any thread. */
#pragma once

#include "optics/atmosphere.h"

/* Row-major matrix M: Rec. 709 cd/m² = M · (L680, L550, L440), of light that
 * comes from a Sun of this elevation. Built from the CIE 1931 observer (Wyman,
 * Sloan, Shirley 2013 fit) with the spectrum between and beyond the three
 * samples taken as that of such a Sun's daylight (optics/daylight.h) times a
 * quadratic in λ⁻², whose terms are those of molecular scattering; of 22
 * elevations (optics/coloursuns.h), and mixed between them. Red
 * against green is within 11 % of the spectrum's own for a clear sky at any
 * time of day; docs/physics/eye.md. */
void pel_colour_matrix(double sun_sine, double m[9]);

/* Weights of a scotopic luminance [cd/m²], 1700 lm/W: the same with V'(λ). */
void pel_colour_rods(double sun_sine, double weights[3]);

/* Photometric illuminance [lx] of a spectral irradiance; the same. */
double pel_colour_illuminance(struct pel_rgb irradiance, double sun_sine);

/* Exposed light of 1 cd/m² at EV100: a reflected-light meter's K = 12.5, whose
 * reading becomes PEL_TONE_MIDDLE. */
double pel_colour_exposure_scale(double ev100);

/* Linear light of a screen, 0..1, for exposed grey x >= 0: the response of a
 * receptor, xᵖ / (xᵖ + σᵖ) (Naka and Rushton 1966), stretched to reach 1 at
 * PEL_TONE_WHITE, then a toe as of a lens's flare. It rises, makes
 * PEL_TONE_MIDDLE PEL_TONE_SHOWN, and is more than 1 beyond PEL_TONE_WHITE. */
double pel_tone_curve(double x);

/* The same of a colour, Rec. 709: its brightest channel by the curve, the
 * others in proportion, so that no channel is cut and the dominant wavelength
 * stays; less saturated the more light there is. */
void pel_tone_filmic(const double exposed[3], double out[3]);

/* What an eye adapts to [cd/m²]: the geometric mean of the luminances that a
 * view shows, and by day, by PEL_METER_INCIDENT, that of a matt surface under
 * the light on the level plane [lx], which looking around does not change. */
double pel_meter_mean(double mean, double level_lx);

/* EV100 for a meter's geometric mean of luminances and their fourth-power mean
 * [cd/m²], and the illuminance of the level plane [lx]: the mean is shown at a
 * key that falls with it (Krawczyk, Myszkowski and Seidel 2005, eq. 11, to
 * the power of PEL_METER_KEY_POWER, times PEL_METER_KEY), `high` at no more
 * than PEL_METER_HIGH of exposed light, within PEL_METER_LEAST and
 * PEL_METER_MOST. */
double pel_meter_ev(double mean, double high, double level_lx);

/* Share of the scattered light of a source per steradian, 1/sr, at an angle
 * from it of which 1 - cos is `away`: falls as 1/θ² like the straylight of CIE
 * 135/1 (1999) and Stiles-Holladay, level within PEL_GLARE_CORE; its sum over
 * all directions is 1. */
double pel_glare_spread(double away);
