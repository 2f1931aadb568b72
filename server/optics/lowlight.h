/* Photons that a camera for low light counts (docs/physics/sensors.md). Any
 * thread. */
#pragma once

/* Of a pixel, its lens and its photocathode. */
#define PEL_LOWLIGHT_PITCH_M 10e-6
#define PEL_LOWLIGHT_LENS 0.8 /* transmittance */

/* Mean photons that a pixel counts for each unit of spectral radiance at 680,
 * 550 and 440 nm [1 / (W m⁻² sr⁻¹ nm⁻¹)]: the spectrum is straight between
 * these and level beyond, to 900 nm, which is the near infrared's part. The
 * quantum efficiency is a gallium arsenide photocathode's (third generation).
 */
void pel_lowlight_photons(double exposure_s, double f_number, double out[3]);

/* That of a photocathode, 0..1. */
double pel_lowlight_efficiency(double nm);
