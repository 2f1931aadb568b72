/* Which waves of a sea are read together over a bottom (shore.h). Any thread.
 */
#pragma once

#include "ocean/shore.h"

/* Fills shore->bands, band and of_wave. Of trochoids longer than
 * PEL_AREA_SHORTER_M those of like direction and length are a band; of cascades
 * each of the two coarser ones, whose energy's mean it is. */
void pel_shore_bands_of(const struct pel_sea *sea, struct pel_shore *shore);
