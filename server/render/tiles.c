#include "render/tiles.h"

#include <math.h>

bool pel_tiles_next(const uint32_t *tiles, const struct pel_camera *c,
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
    const uint32_t *row = &tiles[y / PEL_TILE * across];
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

bool pel_tile_sight(const struct pel_camera *c, double x0, double x1, double y0,
                    double y1, struct pel_tile_sight *out)
{
    struct pel_tile_sight s = { .low = HUGE_VAL, .high = -HUGE_VAL };
    for (int i = 0; i < 9; i++) {
        /* The middle first; azimuths count from there. */
        int at = (i + 4) % 9;
        struct pel_vec3 v = { x0 + 0.5 * (x1 - x0) * (at % 3),
                              y0 + 0.5 * (y1 - y0) * (at / 3), -1.0 };
        struct pel_vec3 d =
            pel_vec3_normalize(pel_mat3_apply(&c->world_from_camera, v));
        double level = hypot(d.x, d.y);
        double slope = d.z / fmax(level, 1e-6);
        double azimuth = atan2(d.y, d.x);
        if (level < 0.2) {
            return false;
        }
        s.middle = i == 0 ? azimuth : s.middle;
        double turn = remainder(azimuth - s.middle, 2.0 * PEL_PI);
        s.left = fmax(s.left, turn);
        s.right = fmin(s.right, turn);
        s.low = fmin(s.low, slope);
        s.high = fmax(s.high, slope);
    }
    s.slack = 0.1 * (x1 - x0 + y1 - y0);
    s.low -= s.slack;
    s.high += s.slack;
    *out = s;
    return true;
}
