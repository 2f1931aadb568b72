#include "render/tiles.h"

#include <math.h>

static double depression(const struct pel_camera *c, double x, double y,
                         double *cos_axis)
{
    struct pel_vec3 v = pel_vec3_normalize((struct pel_vec3){ x, y, -1.0 });
    *cos_axis = -v.z;
    struct pel_vec3 d = pel_mat3_apply(&c->world_from_camera, v);
    return -asin(pel_clamp(d.z, -1.0, 1.0));
}

/* Shortest length of a pixel on the sea within the tile. */
static double shortest_footprint(const struct pel_camera *c, double low_m,
                                 double pixel, double anisotropy, double x0,
                                 double x1, double y0, double y1)
{
    const double xs[] = { x0, x1, x0, x1, 0.5 * (x0 + x1) };
    const double ys[] = { y0, y0, y1, y1, 0.5 * (y0 + y1) };
    double steepest = -1.0, least_cos = 1.0;
    for (int i = 0; i < 5; i++) {
        double cos_axis;
        steepest = fmax(steepest, depression(c, xs[i], ys[i], &cos_axis));
        least_cos = fmin(least_cos, cos_axis);
    }
    /* A pixel between the corners may look a little further down. */
    steepest += 0.1 * (x1 - x0 + y1 - y0);
    if (steepest <= 1e-4) {
        steepest = 1e-4;
    }
    steepest = fmin(steepest, 0.5 * PEL_PI);
    double slant = low_m / sin(steepest);
    double across = slant * least_cos * pixel;
    return across * fmax(1.0, 1.0 / (sin(steepest) * anisotropy));
}

void pel_tiles_plan(const struct pel_camera *camera, double height_m,
                    double pixel, const struct pel_filtering *filtering,
                    const struct pel_sea *sea, short waves[PEL_MAX_TILES])
{
    double rise = fmin(sea->max_height_m, 5.0 * sqrt(sea->m0));
    double low_m = height_m - rise;
    int index = 0;
    double px = (camera->tan_right - camera->tan_left) / camera->width;
    double py = (camera->tan_top - camera->tan_bottom) / camera->height;
    for (uint32_t y = 0; y < camera->height; y += PEL_TILE) {
        for (uint32_t x = 0; x < camera->width; x += PEL_TILE) {
            short count = (short)sea->count;
            if (low_m > 0.0) {
                double x0 = camera->tan_left + px * x;
                double y0 = camera->tan_top - py * y;
                double shortest = filtering->n_min *
                                  shortest_footprint(camera, low_m, pixel,
                                                     filtering->anisotropy, x0,
                                                     x0 + px * PEL_TILE,
                                                     y0 - py * PEL_TILE, y0);
                while (count > 0 && 2.0 * PEL_PI /
                                            hypot(sea->waves[count - 1].kx,
                                                  sea->waves[count - 1].ky) <
                                        shortest) {
                    count--;
                }
            }
            waves[index++] = count;
        }
    }
}
