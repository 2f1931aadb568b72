/* Which tiles of a picture may show land or the bottom; the others are drawn by
 * the programs of the deep sea. Pure computation, no GL. */
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "render/seabedmap.h"

#define PEL_TILE 64
/* Of 4096 pixels a side and PEL_ACUITY_BORDER beyond each edge. */
#define PEL_MAX_TILES (68 * 68)

enum pel_coast_tile {
    PEL_COAST_NONE,
    PEL_COAST_BOTTOM, /* water whose bottom lies less than visible_m below it */
    PEL_COAST_LAND,   /* land, and such water */
    PEL_COAST_TILES,
};

/* For each tile, row by row from the top left, what its lines of sight can
 * meet. The camera's altitude is above the sea's zero. Returns whether there is
 * any but NONE. */
bool pel_coast_plan(const struct pel_environment *env,
                    const struct pel_seabed_map *map,
                    const struct pel_camera *camera, double visible_m,
                    uint32_t tiles[PEL_MAX_TILES]);
