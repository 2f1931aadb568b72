#include "render/tiles.h"

bool pel_tiles_next(const uint16_t *tiles, const struct pel_camera *c,
                    struct pel_tile_run *run)
{
    int width = (int)c->width, height = (int)c->height;
    int across = (width + PEL_TILE - 1) / PEL_TILE;
    int x = run->x + run->width, y = run->y;
    if (x >= width) {
        x = 0;
        y += PEL_TILE;
    }
    if (y >= height) {
        return false;
    }
    const uint16_t *row = &tiles[y / PEL_TILE * across];
    int first = x / PEL_TILE, end = first + 1;
    while (end < across && row[end] == row[first]) {
        end++;
    }
    int right = end * PEL_TILE, top = y + PEL_TILE;
    *run =
        (struct pel_tile_run){ x, y, (right < width ? right : width) - x,
                               (top < height ? top : height) - y, row[first] };
    return true;
}
