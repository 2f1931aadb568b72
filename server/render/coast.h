/* Which tiles of a picture may show land or the bottom: the others are drawn
 * as deep sea, at no cost. Pure computation, no GL. */
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "render/seabedmap.h"

#define PEL_TILE 64
#define PEL_MAX_TILES (4096 / PEL_TILE * 4096 / PEL_TILE)

/* For each tile, row by row from the top left, 1 where a line of sight of it
 * can meet land, or water whose bottom lies less than visible_m below it; the
 * waves are at most rise_m high. The camera's altitude is above the sea's zero.
 * Returns whether there is any. */
bool pel_coast_plan(const struct pel_environment *env,
                    const struct pel_seabed_map *map,
                    const struct pel_camera *camera, double visible_m,
                    uint8_t tiles[PEL_MAX_TILES]);
