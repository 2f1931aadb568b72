#include "render/coast.h"

#include <math.h>
#include <string.h>

#include "base/vec.h"
#include "optics/atmosphere.h"
#include "render/tiles.h"

#define BINS 512        /* of azimuth */
#define MOST_SQUARES 64 /* a side: so coarse a field is enough */

/* What there is to see in a direction: the bottom from where to where, land,
 * and how high its top stands, as a tangent above the level. */
struct bin {
    double near_m[2], far_m[2], top; /* [1]: of land */
};

struct panorama {
    double height_m; /* of the eye */
    bool everywhere;
    struct bin bins[BINS];
};

static int bin_of(double azimuth)
{
    double turns = azimuth / (2.0 * PEL_PI);
    int bin = (int)((turns - floor(turns)) * BINS);
    return bin < BINS ? bin : BINS - 1;
}

/* A disc on the ground, of height top_m above the sea (-HUGE_VAL: below it). */
static void add_disc(struct panorama *p, double east_m, double north_m,
                     double radius_m, double top_m)
{
    bool land = !isinf(top_m);
    double distance = hypot(east_m, north_m);
    double near = distance - radius_m, far = distance + radius_m;
    double half = near > 0 ? asin(fmin(radius_m / distance, 1.0)) : PEL_PI;
    double rise = top_m - p->height_m;
    double at = rise > 0 ? fmax(near, 1.0) : far;
    double top = near > 0 || !land ? rise / at - at / (2.0 * PEL_EARTH_RADIUS)
                                   : HUGE_VAL;
    int first =
        (int)floor((atan2(north_m, east_m) - half) * BINS / (2.0 * PEL_PI));
    int count = (int)ceil(half * BINS / PEL_PI) + 2;
    for (int i = 0; i < count && i < BINS; i++) {
        struct bin *b = &p->bins[((first + i) % BINS + BINS) % BINS];
        b->near_m[land] = fmin(b->near_m[land], fmax(near, 0.0));
        b->far_m[land] = fmax(b->far_m[land], far);
        b->top = fmax(b->top, top);
    }
}

static void look_around(struct panorama *p, const struct pel_environment *env,
                        const struct pel_seabed_map *map,
                        const struct pel_camera *c, double visible_m)
{
    const struct pel_seabed *bed = env->seabed;
    const struct pel_seabed_tops *t = &map->squares;
    int k = 0;
    while (k + 1 < t->levels &&
           (t->columns[k] > MOST_SQUARES || t->rows[k] > MOST_SQUARES)) {
        k++;
    }
    double side = bed->spacing_m * exp2(k + 1);
    /* Refracted, a line of sight runs on by its depth at most; waves carry
     * the surface aside. */
    double waves = 5.0 * sqrt(env->sea->m0);
    double margin = visible_m + waves;
    for (int y = 0; y < t->rows[k]; y++) {
        for (int x = 0; x < t->columns[k]; x++) {
            double top =
                (double)
                    t->highest[t->first[k] + (size_t)(y * t->columns[k] + x)] -
                env->sea_level_m;
            if (top < -visible_m) {
                continue;
            }
            /* The last square of a row may be up to twice as wide. */
            double wide = side * (x + 1 < t->columns[k] ? 1 : 2);
            double tall = side * (y + 1 < t->rows[k] ? 1 : 2);
            double east = bed->west_m + side * x + 0.5 * wide - c->east_m;
            double north = bed->south_m + side * y + 0.5 * tall - c->north_m;
            double radius = 0.5 * hypot(wide, tall);
            add_disc(p, east, north, radius + margin, -HUGE_VAL);
            if (top > -waves) {
                add_disc(p, east, north, radius + waves, top);
            }
        }
    }
    p->everywhere = env->water.depth_m + env->sea_level_m < visible_m;
}

/* By the azimuths, distances and heights that a tile sees. */
static enum pel_coast_tile tile_of(const struct panorama *p,
                                   const struct pel_camera *c, double x0,
                                   double x1, double y0, double y1)
{
    struct pel_tile_sight see;
    if (!pel_tile_sight(c, x0, x1, y0, y1, &see)) {
        return PEL_COAST_LAND;
    }
    const double low = see.low, high = see.high;
    double horizon = sqrt(2.0 * p->height_m / PEL_EARTH_RADIUS);
    double nearest = low < -1e-6 ? 0.9 * p->height_m / -low - 5.0 : 0.0;
    double farthest =
        high < -1.5 * horizon ? 1.3 * p->height_m / -high + 5.0 : HUGE_VAL;
    if (low >= -1e-6) {
        nearest = HUGE_VAL;
    }
    int first = bin_of(see.middle + see.right - see.slack);
    int count =
        (int)((see.left - see.right + 2 * see.slack) / (2.0 * PEL_PI) * BINS) +
        2;
    enum pel_coast_tile tile = PEL_COAST_NONE;
    for (int i = 0; i < count; i++) {
        const struct bin *b = &p->bins[(first + i) % BINS];
        /* Land stands in the way of sights that reach it above the water. */
        if (b->near_m[1] <= farthest &&
            (b->far_m[1] >= nearest || b->top >= low)) {
            return PEL_COAST_LAND;
        }
        if (p->everywhere ||
            (b->near_m[0] <= farthest && b->far_m[0] >= nearest)) {
            tile = PEL_COAST_BOTTOM;
        }
    }
    return tile;
}

bool pel_coast_plan(const struct pel_environment *env,
                    const struct pel_seabed_map *map,
                    const struct pel_camera *c, double visible_m,
                    uint32_t tiles[PEL_MAX_TILES])
{
    struct panorama p = { .height_m = fmax(c->altitude_m, PEL_LEAST_EYE_M) };
    for (int i = 0; i < BINS; i++) {
        p.bins[i] = (struct bin){ { HUGE_VAL, HUGE_VAL },
                                  { -HUGE_VAL, -HUGE_VAL },
                                  -HUGE_VAL };
    }
    look_around(&p, env, map, c, visible_m);
    double px = (c->tan_right - c->tan_left) / c->width;
    double py = (c->tan_top - c->tan_bottom) / c->height;
    bool any = false;
    int index = 0;
    for (uint32_t y = 0; y < c->height; y += PEL_TILE) {
        for (uint32_t x = 0; x < c->width; x += PEL_TILE) {
            double x0 = c->tan_left + px * x, y1 = c->tan_top - py * y;
            enum pel_coast_tile tile =
                tile_of(&p, c, x0, x0 + px * PEL_TILE, y1 - py * PEL_TILE, y1);
            any = any || tile != PEL_COAST_NONE;
            tiles[index++] = (uint32_t)tile;
        }
    }
    return any;
}
