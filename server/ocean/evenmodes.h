/* Frequencies of a cascade's longest modes. A mode stands for all waves of its
 * cell of the wave-vector plane. Where the cells are wide against the spectrum,
 * modes with the frequencies of their cells' middles come two or three at once
 * and leave gaps between, in the spectrum of a time series; so each gets that
 * frequency of its cell at which the spectrum has as much energy below it as
 * the modes before it, in the order of |k|, carry. */
#pragma once

#include "ocean/cascade.h"
#include "ocean/directional.h"

/* Sets the frequencies of cascade `index`, whose energies are drawn and whose
 * rings have the spectrum's, below mode number 31.5: within half a mode number
 * of the dispersion relation's. Any thread. */
void pel_cascade_even(const struct pel_directional *spectrum,
                      const struct pel_sea_desc *desc, int index,
                      struct pel_cascade *c);
