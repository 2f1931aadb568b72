/* Tiles of a picture that neither ship waves nor wash reach: their programs
 * need not ask for any. Pure computation, any thread. */
#pragma once

#include "render/programs.h"
#include "render/tiles.h"

/* Whether such tiles have programs of their own. Compilers for GPUs round the
 * same text in two programs differently; llvmpipe's does where one of them
 * alone has foam. */
bool pel_still_wanted(const struct pel_environment *env,
                      const struct pel_programs *programs);

/* Marks them with PEL_TILE_STILL; false: there is none. A tile is marked only
 * if no place that its pixels may show, of any height that waves have, lies in
 * a square of waves or a cell of wash. */
bool pel_still_tiles(const struct pel_environment *env,
                     const struct pel_camera *camera,
                     uint32_t tiles[PEL_MAX_TILES]);
