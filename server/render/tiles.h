/* Which tiles of a picture need how many waves: the sums of section 3.2 run
 * only over the waves that a pixel resolves. Pure computation, no GL. */
#pragma once

#include "ocean/sea.h"
#include "render/filtering.h"
#include "scene/snapshot.h"

#define PEL_TILE 64
#define PEL_MAX_TILES (4096 / PEL_TILE * 4096 / PEL_TILE)

/* For each tile, row by row from the top left, the number of waves (longest
 * first) that any of its pixels may resolve with wavelengths of n_min pixels or
 * more; every pixel's length on the sea is taken as short as the crests allow.
 */
void pel_tiles_plan(const struct pel_camera *camera, double height_m,
                    double pixel, const struct pel_filtering *filtering,
                    const struct pel_sea *sea, short waves[PEL_MAX_TILES]);
