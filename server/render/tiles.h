/* Tiles of a picture, each shaded by the programs of what it may show. Pure
 * computation, any thread. */
#pragma once

#include "render/coast.h"

/* What a tile may show beside enum pel_coast_tile: objects on the sea; sea that
 * mirrors one of the four that look largest, or lies in the shadow of one of
 * eight: masks of their ranks. */
#define PEL_TILE_OBJECTS 4
#define PEL_TILE_HULLS 8 /* of what shades it, seen through the sea */
#define PEL_TILE_MIRROR(rank) (0x10u << (rank))
#define PEL_TILE_SHADE(rank) (0x100u << (rank))
#define PEL_TILE_MIRRORED(tile) ((tile) >> 4 & 0xfu)
#define PEL_TILE_SHADED(tile) ((tile) >> 8 & 0xffu)
#define PEL_TILE_COAST 3        /* mask of the coast's bits */
#define PEL_TILE_STILL 0x10000u /* neither ship waves nor wash reach it */

/* Tiles of a row, side by side, of one kind; pixels. */
struct pel_tile_run {
    int x, y, width, height;
    unsigned tile;
};

/* The one after *run, the first after { 0 }; false after the last. The tiles
 * are those of the camera's picture, row by row from the top left. */
bool pel_tiles_next(const uint32_t *tiles, const struct pel_camera *camera,
                    struct pel_tile_run *run);

/* What the tile between these tangents of the camera sees: azimuths about its
 * middle's (mathematical) and slopes of its rays, with slack; false: it may
 * look straight up or down. */
struct pel_tile_sight {
    double middle, left, right; /* rad; right ≤ 0 ≤ left */
    double low, high;
    double slack;
};
bool pel_tile_sight(const struct pel_camera *camera, double x0, double x1,
                    double y0, double y1, struct pel_tile_sight *out);
