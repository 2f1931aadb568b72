#include "render/stilltiles.h"

#include <math.h>

#include "ocean/wash.h"
#include "scene/wakes.h"

#define BINS 512
/* Crests are seldom six standard deviations high; no more are drawn. */
#define SIGMAS 8.0
#define SLACK_M 5.0

/* By azimuth: nearest and farthest place with waves or wash. */
struct around {
    double near_m[BINS], far_m[BINS];
};

/* From the eye's nadir. */
struct square {
    double low[2], high[2];
};

static double angle_of(int bin)
{
    return 2.0 * PEL_PI * bin / BINS;
}

static void widen(struct around *a, int bin, double near_m, double far_m)
{
    a->near_m[bin] = fmin(a->near_m[bin], near_m);
    a->far_m[bin] = fmax(a->far_m[bin], far_m);
}

/* The part of a ray from the nadir that lies in the square. */
static void add_ray(struct around *a, int bin, double angle,
                    const struct square *s)
{
    const double d[2] = { cos(angle), sin(angle) };
    double near = 0, far = HUGE_VAL;
    for (int k = 0; k < 2; k++) {
        double to[2] = { s->low[k] / d[k], s->high[k] / d[k] };
        near = fmax(near, fmin(to[0], to[1]));
        far = fmin(far, fmax(to[0], to[1]));
    }
    if (near <= far) {
        widen(a, bin, near, far);
    }
}

static void add_square(struct around *a, const struct square *s)
{
    double far = hypot(fmax(fabs(s->low[0]), fabs(s->high[0])),
                       fmax(fabs(s->low[1]), fabs(s->high[1])));
    if (s->low[0] <= 1 && s->high[0] >= -1 && s->low[1] <= 1 &&
        s->high[1] >= -1) {
        for (int i = 0; i < BINS; i++) {
            widen(a, i, 0, far);
        }
        return;
    }
    double middle = atan2(s->low[1] + s->high[1], s->low[0] + s->high[0]);
    double left = 0, right = 0;
    for (int i = 0; i < 4; i++) {
        double x = i & 1 ? s->high[0] : s->low[0];
        double y = i & 2 ? s->high[1] : s->low[1], angle = atan2(y, x);
        double turn = remainder(angle - middle, 2.0 * PEL_PI);
        left = fmax(left, turn);
        right = fmin(right, turn);
        int bin = (int)floor(angle / (2.0 * PEL_PI) * BINS) & (BINS - 1);
        widen(a, bin, hypot(x, y), hypot(x, y));
    }
    int first = (int)floor((middle + right) / (2.0 * PEL_PI) * BINS);
    int last = (int)floor((middle + left) / (2.0 * PEL_PI) * BINS);
    for (int i = first; i <= last; i++) {
        add_ray(a, i & (BINS - 1), angle_of(i) + 1e-9, s);
        add_ray(a, i & (BINS - 1), angle_of(i + 1) - 1e-9, s);
    }
}

static void add_wakes(struct around *a, const struct pel_wake_moment *wakes,
                      const struct pel_camera *c, double more_m)
{
    for (size_t i = 0; i < wakes->count; i++) {
        for (int k = 0; k < PEL_WAKE_TILES; k++) {
            const struct pel_wake_tile *t = &wakes->wake[i].tile[k];
            double held = PEL_WAKE_FADED * t->length_m + more_m;
            double x = t->x_m - c->east_m, y = t->y_m - c->north_m;
            if (t->texels) {
                add_square(a, &(struct square){ { x - held, y - held },
                                                { x + held, y + held } });
            }
        }
    }
}

static bool is_empty(const struct pel_wash *w, int column, int row)
{
    return (w->cell[row * w->columns + column] & 1023u) == 0;
}

/* Its cells, those of a row that stand side by side at once. */
static void add_wash(struct around *a, const struct pel_wash *w,
                     const struct pel_camera *c, double more_m)
{
    double side = w->columns ? 1.0 / w->cells_per_m : 0;
    for (int row = 0; row < w->rows; row++) {
        for (int first = 0; first < w->columns; first++) {
            int end = first;
            while (end < w->columns && !is_empty(w, end, row)) {
                end++;
            }
            if (end > first) {
                double x = w->west_m - c->east_m, y = w->south_m - c->north_m;
                add_square(
                    a, &(struct square){ { x + side * first - more_m,
                                           y + side * row - more_m },
                                         { x + side * end + more_m,
                                           y + side * (row + 1) + more_m } });
                first = end;
            }
        }
    }
}

static bool is_still(const struct around *a, const struct pel_camera *c,
                     double height_m, double crest_m, double x0, double x1,
                     double y0, double y1)
{
    struct pel_tile_sight see;
    if (!pel_tile_sight(c, x0, x1, y0, y1, &see)) {
        return false;
    }
    double horizon = sqrt(2.0 * (height_m + crest_m) / PEL_EARTH_RADIUS);
    double below = 0.9 * height_m - crest_m;
    double nearest = see.low > -1e-6 ? HUGE_VAL
                     : below > 0     ? below / -see.low - SLACK_M
                                     : 0.0;
    double farthest = see.high < -1.5 * horizon
                          ? 1.3 * (height_m + crest_m) / -see.high + SLACK_M
                          : HUGE_VAL;
    double from = see.middle + see.right - see.slack;
    double width = see.left - see.right + 2 * see.slack;
    int first = (int)floor(from / (2.0 * PEL_PI) * BINS);
    int last = (int)floor((from + width) / (2.0 * PEL_PI) * BINS);
    for (int i = first; i <= last; i++) {
        int bin = i & (BINS - 1);
        if (a->near_m[bin] <= farthest && a->far_m[bin] >= nearest) {
            return false;
        }
    }
    return true;
}

bool pel_still_wanted(const struct pel_environment *env,
                      const struct pel_programs *programs)
{
    return (env->wash ? env->sea->foam != NULL : env->wakes != NULL) &&
           programs->software && !programs->compute && !env->nowhere_still;
}

bool pel_still_tiles(const struct pel_environment *env,
                     const struct pel_camera *c, uint32_t tiles[PEL_MAX_TILES])
{
    struct around a;
    for (int i = 0; i < BINS; i++) {
        a.near_m[i] = HUGE_VAL;
        a.far_m[i] = -HUGE_VAL;
    }
    const double sigma = sqrt(env->sea->m0);
    const double crest = fmin(SIGMAS * sigma, env->sea->max_height_m) + 1.0;
    const double shift = fmin(SIGMAS * sigma, env->sea->max_shift_m) + SLACK_M;
    if (env->wakes) {
        add_wakes(&a, env->wakes, c, SLACK_M);
    }
    if (env->wash) {
        add_wash(&a, env->wash, c, shift);
    }
    double height = fmax(c->altitude_m, PEL_LEAST_EYE_M);
    double px = (c->tan_right - c->tan_left) / c->width;
    double py = (c->tan_top - c->tan_bottom) / c->height;
    bool any = false;
    int index = 0;
    for (uint32_t y = 0; y < c->height; y += PEL_TILE) {
        for (uint32_t x = 0; x < c->width; x += PEL_TILE, index++) {
            double x0 = c->tan_left + px * x, y1 = c->tan_top - py * y;
            if (is_still(&a, c, height, crest, x0, x0 + px * PEL_TILE,
                         y1 - py * PEL_TILE, y1)) {
                tiles[index] |= PEL_TILE_STILL;
                any = true;
            }
        }
    }
    return any;
}
