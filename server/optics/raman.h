/* Raman scattering by water: light whose wavenumber falls by 3400 1/cm, so that
 * blue light becomes green and green becomes red. In the clearest water it is a
 * fifth of what leaves in the green and more of the red. Beyond this file one
 * line stands for the band, 40 nm wide in the green; light is turned so once.
 * Any thread. */
#pragma once

#include "base/err.h"
#include "optics/transport.h"

struct pel_ordinates;

/* The wavelength that becomes `nm` [nm]. */
double pel_raman_excitation_nm(double nm);

/* What is scattered so of light of wavelength `nm`, in units of energy [1/m]:
 * Bartlett, Voss, Sathyendranath and Vodacek 1998, 2.7e-4 at 488 nm (± 0.2e-4),
 * falling as nm^-5.5. */
double pel_raman_scattering(double nm);

/* Radiance that one unit of it makes at another wavelength [1]: b_R (λ'/λ)²,
 * the second factor because a band of wavenumbers is narrower in wavelength
 * where it comes from; times the Sun above the air at λ' over that at λ. What
 * the air takes of both is taken as equal. */
double pel_raman_strength(double nm);

/* What a water does at one wavelength with the light of another. */
struct pel_raman {
    double strength;        /* pel_raman_strength; 0: nothing */
    struct pel_medium from; /* the water at the excitation; its depth and bottom
                               are not read but its albedo */
};

#define PEL_RAMAN_MODES 3

/* Radiance going up just below the surface in directions of zenith cosine
 * view_mu (in the water; any, the surface may keep them) of sunbeams of zenith
 * cosines `mu`, irradiance 1 at this wavelength normal to them (in the water),
 * over `depths`: modes in azimuth, out[depth][mode][beam][view] [1/sr]. By
 * reciprocity the light of a source at a depth is what a beam from the eye
 * brings there, so the solver need not know of sources. beams and views
 * 1..PEL_ORDINATES_BEAMS. NO_MEMORY. */
PEL_CHECK enum pel_err
pel_raman_respond(struct pel_ordinates *o, const struct pel_medium *medium,
                  const struct pel_raman *raman, const double *depths,
                  int levels, const double *mu, int beams,
                  const double *view_mu, int views, double *out);
