/* Trochoids drawn from any directional spectrum. */
#pragma once

#include "ocean/directional.h"

/* Fills the sea up to desc.wave_count trochoids of `spectrum`: the bins,
 * places, directions and phases of pel_sea_build, over wavenumber instead of
 * frequency, swell and wind sea together. NO_MEMORY. A spectrum without energy
 * adds none. */
PEL_CHECK enum pel_err
pel_sea_add_spectrum(struct pel_sea *sea,
                     const struct pel_directional *spectrum);
