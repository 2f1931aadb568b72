/* Atmospheres with their tables (pel_atmosphere_tabulate), of which the two
 * that were used last are kept: a renderer made anew after a loss of the
 * device, and every question about the sky, would pay 0.35 to 0.9 s of a core
 * again. Any thread. */
#pragma once

#include "base/err.h"
#include "optics/atmosphere.h"

/* The air of visibility_m, to be given back; made by the calling thread, with
 * `share` and `pool` as for pel_atmosphere_tabulate, where it is not one
 * that is kept. Its bits do not depend on that. NO_MEMORY. */
PEL_CHECK enum pel_err pel_air_take(double visibility_m,
                                    pel_airlight_share *share, void *pool,
                                    const struct pel_atmosphere **out);
void pel_air_give(const struct pel_atmosphere *air);
