#include "render/band.h"

#include <string.h>

#include "render/coast.h"

_Static_assert(PEL_BAND_ROWS % PEL_TILE == 0, "bands are rows of tiles");

struct pel_band pel_band_of(const struct pel_draw *draw)
{
    uint32_t height = draw->camera.height;
    return draw->rows ? (struct pel_band){ draw->first_row, draw->rows }
                      : (struct pel_band){ 0, height };
}

struct pel_camera pel_band_camera(const struct pel_camera *whole,
                                  struct pel_band band)
{
    struct pel_camera c = *whole;
    double row = (whole->tan_top - whole->tan_bottom) / whole->height;
    c.tan_top = whole->tan_top - row * band.first;
    c.tan_bottom = c.tan_top - row * band.rows;
    c.height = band.rows;
    return band.rows < whole->height ? c : *whole;
}

struct pel_disc_box pel_band_disc(const struct pel_camera *whole,
                                  struct pel_vec3 to, double radius_rad,
                                  struct pel_band band)
{
    struct pel_disc_box box;
    if (!pel_disc_place(whole, to, radius_rad, &box)) {
        return (struct pel_disc_box){ 0 };
    }
    int top = box.y - (int)band.first, bottom = top + box.height;
    top = top > 0 ? top : 0;
    bottom = bottom < (int)band.rows ? bottom : (int)band.rows;
    box.y = top;
    box.height = bottom > top ? bottom - top : 0;
    return box;
}

void pel_band_tiles(const struct pel_camera *whole, struct pel_band band,
                    uint32_t *tiles)
{
    size_t across = (whole->width + PEL_TILE - 1) / PEL_TILE;
    size_t down = (band.rows + PEL_TILE - 1) / PEL_TILE;
    memmove(tiles, tiles + band.first / PEL_TILE * across,
            across * down * sizeof *tiles);
}
